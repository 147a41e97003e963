// What every registered map promises (stages/map.hpp), with its default parameters.
#include <catch2/catch.hpp>
#include <limits>

#include "plugins/maps/map_fixture.hpp"

using namespace aslio;
using namespace aslio::test;

TEST_CASE("every map of points: neighbours equal brute force over insertions and trims, near and far from the origin") {
  EveryMap fixture;
  const auto types = fixture.types(MapContent::points);
  REQUIRE((!types.empty() || one_under_test(Map::family)));
  for (const auto& type : types) {
    for (const double origin : {0.0, 1e5}) {
      INFO(type << " at " << origin);
      const auto map = fixture.make(type, fixture.exec);
      Uniform uniform(7);
      Vec3 centre(origin, -origin, 0.1 * origin);
      std::size_t offered = 0;
      for (std::uint32_t stamp = 1; stamp <= 60; ++stamp) {
        std::vector<WorldPoint> batch;
        for (int i = 0; i < 1000; ++i) batch.push_back(at(uniform.in_box(centre, 3.0)));
        const std::size_t before = map->size();
        const InsertCount count = map->insert(batch, stamp);
        offered += count.offered;
        REQUIRE(count.offered == batch.size());
        REQUIRE(map->size() == before + count.inserted);
        centre += Vec3(7.0, 0.5, 0.0);
        map->trim(centre);
        if (stamp % 10 != 0) continue;
        std::vector<Vec3> queries;
        for (int i = 0; i < 30; ++i) queries.push_back(uniform.in_box(centre - Vec3(7.0, 0.5, 0.0), 4.0));
        MapQuery ask;
        for (const int k : {1, 5, 20}) {
          ask.k = k;
          check_against_visit(*map, queries, ask);
        }
      }
      REQUIRE(offered == 60000);
      REQUIRE(map->size() > 1000);
      // What trim() has kept is what the radius reaches, and a coarse cell more at most.
      for (const Vec3& p : contents(*map)) REQUIRE((p - centre).norm() < 1.2 * map->radius() + 10.0);
    }
  }
}

TEST_CASE("every map of points: only points inserted at max_stamp or before are seen") {
  EveryMap fixture;
  for (const auto& type : fixture.types(MapContent::points)) {
    INFO(type);
    const auto map = fixture.make(type, fixture.exec);
    map->insert(std::vector<WorldPoint>{at({0.1, 0.1, 0.1})}, 1);
    map->insert(std::vector<WorldPoint>{at({0.6, 0.1, 0.1})}, 2);
    map->insert(std::vector<WorldPoint>{at({0.1, 0.6, 0.1})}, 3);
    const std::vector<Vec3> query{{0.1, 0.55, 0.1}};
    Neighbours found;
    MapQuery ask;
    for (const std::uint32_t stamp : {0U, 1U, 2U, 3U}) {
      ask.max_stamp = stamp;
      map->correspond(query, ask, found);
      REQUIRE(found.count[0] == stamp);
    }
    REQUIRE(found.offset(0, 0).isApprox(Eigen::Vector3f(0.0F, 0.05F, 0.0F), 1e-5F));
    ask.max_stamp = 2;
    map->correspond(query, ask, found);
    REQUIRE(found.offset(0, 0).isApprox(Eigen::Vector3f(0.0F, -0.45F, 0.0F), 1e-5F));
  }
}

TEST_CASE("every map of points: equal distances come in the order of insertion") {
  EveryMap fixture;
  for (const auto& type : fixture.types(MapContent::points)) {
    INFO(type);
    const std::vector<Vec3> around{{0.25, 0, 0},  {-0.25, 0, 0}, {0, 0.25, 0},
                                   {0, -0.25, 0}, {0, 0, 0.25},  {0, 0, -0.25}};
    for (std::size_t first = 0; first < around.size(); ++first) {
      const auto map = fixture.make(type, fixture.exec);
      std::vector<WorldPoint> points;
      for (std::size_t i = 0; i < around.size(); ++i) points.push_back(at(around[(first + i) % around.size()]));
      map->insert(points, 1);
      Neighbours found;
      MapQuery ask;
      ask.k = 3;
      map->correspond(std::vector<Vec3>{Vec3::Zero()}, ask, found);
      REQUIRE(found.count[0] == 3);
      for (std::size_t j = 0; j < 3; ++j) REQUIRE(found.offset(0, j).cast<double>() == points[j].p_W);
    }
  }
}

TEST_CASE("every map of points: the same bits for any number of threads") {
  EveryMap fixture;
  for (const auto& type : fixture.types(MapContent::points)) {
    INFO(type);
    Neighbours expected;
    for (const int threads : {1, 2, 3, 8}) {
      exec::Executor executor(threads);
      const auto map = fixture.make(type, executor);
      Uniform uniform(3);
      std::vector<WorldPoint> points;
      for (int i = 0; i < 20000; ++i) points.push_back(at(uniform.in_box(Vec3::Zero(), 5.0)));
      map->insert(points, 1);
      std::vector<Vec3> queries;
      for (int i = 0; i < 3000; ++i) queries.push_back(uniform.in_box(Vec3::Zero(), 5.5));
      Neighbours found;
      map->correspond(queries, MapQuery{}, found);
      if (threads == 1) expected = found;
      REQUIRE(found.count == expected.count);
      for (std::size_t i = 0; i < queries.size(); ++i) {
        for (std::size_t j = 0; j < found.count[i]; ++j) REQUIRE(found.offset(i, j) == expected.offset(i, j));
      }
    }
  }
}

TEST_CASE("every map: what is not finite or beyond all cells is refused and finds nothing") {
  EveryMap fixture;
  constexpr double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  for (const auto& type : fixture.types()) {
    INFO(type);
    const auto map = fixture.make(type, fixture.exec);
    const std::vector<Vec3> bad{{nan, 0, 0}, {0, inf, 0}, {0, 0, -inf}, {1e30, 0, 0}, {0, -1e30, 0}, {0, 0, 1e300}};
    std::vector<WorldPoint> points{at({1, 1, 1})};
    for (const Vec3& p : bad) points.push_back(at(p));
    const InsertCount count = map->insert(points, 1);
    REQUIRE(count.offered == 7);
    REQUIRE(count.inserted == 1);
    REQUIRE(map->size() == 1);
    Neighbours found;
    map->correspond(bad, MapQuery{}, found);
    for (const auto n : found.count) REQUIRE(n == 0);
    map->trim({nan, 0, 0});
    REQUIRE(map->size() == 1);
    map->clear();
    REQUIRE(map->size() == 0);
    map->correspond(std::vector<Vec3>{{1, 1, 1}}, MapQuery{}, found);
    REQUIRE(found.count[0] == 0);
  }
}

TEST_CASE("every map: memory stays bounded over a kilometre, and two visits see the same points") {
  EveryMap fixture;
  for (const auto& type : fixture.types()) {
    INFO(type);
    const auto map = fixture.make(type, fixture.exec);
    Uniform uniform(11);
    const double lap = 2.5 * map->radius();
    std::size_t after_first_lap = 0;
    std::vector<WorldPoint> batch(200);
    for (double x = 0; x < lap + 1000.0; x += 1.0) {
      for (auto& point : batch) point = at({x + uniform(-1, 1), uniform(-5, 5), uniform(0, 3)});
      map->insert(batch, 1);
      map->trim({x, 0, 0});
      if (x < lap) after_first_lap = map->memory_bytes();
    }
    REQUIRE(static_cast<double>(map->memory_bytes()) < 1.25 * static_cast<double>(after_first_lap));
    const auto forward = contents(*map);
    const auto again = contents(*map);
    REQUIRE(forward == again);
  }
}
