// What every registered insertion owes the loop, with every map it can work with.
#include <catch2/catch.hpp>
#include <limits>

#include "plugins/allocation_count.hpp"
#include "plugins/insertions/every_insertion.hpp"
#include "plugins/insertions/random_windows.hpp"
#include "plugins/insertions/recording_map.hpp"

namespace aslio {
namespace {

using test::EveryInsertion;
using test::RandomWindows;

void play(Insertion& insertion, RandomWindows& windows, Map& map, int updates) {
  for (int k = 0; k < updates; ++k) {
    windows.next();
    InsertCount count = insertion.begin(windows.window, map);
    REQUIRE(count.inserted <= count.offered);
    if (!windows.update.insert) continue;
    count = insertion.apply(windows.window, windows.update, map);
    REQUIRE(count.inserted <= count.offered);
  }
}

}  // namespace

TEST_CASE("every insertion: the same updates make the same map, of points of the map use alone") {
  EveryInsertion every;
  REQUIRE(every.insertions().size() >= (test::one_under_test(Insertion::family) ? 1 : 5));
  for (const std::string& type : every.insertions()) {
    for (const MapContent content : {MapContent::points, MapContent::surfaces}) {
      if (content == MapContent::surfaces && every.insertion(type)->needs_nearest_points()) continue;
      for (const std::string& map_type : every.types(content)) {
        CAPTURE(type, map_type);
        std::vector<std::vector<Vec3>> maps;
        for (int run = 0; run < 2; ++run) {
          const auto insertion = every.insertion(type);
          const auto map = every.make(map_type);
          RandomWindows windows(7);
          play(*insertion, windows, *map, 100);
          insertion->finish(*map);
          CHECK(map->size() > 0);
          maps.push_back(test::contents(*map));
        }
        CHECK(maps[0] == maps[1]);
      }
    }
    test::RecordingMap map;
    const auto insertion = every.insertion(type);
    RandomWindows windows(9);
    play(*insertion, windows, map, 100);
    insertion->finish(map);
    CHECK(map.given.size() > 500);
    CHECK(map.stamps.count(-1) == 0);  // those of the other uses
  }
}

TEST_CASE("every insertion: points that are not finite do no harm") {
  EveryInsertion every;
  constexpr double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  const std::vector<WorldPoint> points = {test::at({nan, 0, 0}), test::at({1, 2, 3}), test::at({0, -inf, 0}),
                                          test::at({0, 0, 1e300})};
  for (const std::string& type : every.insertions()) {
    CAPTURE(type);
    const auto insertion = every.insertion(type);
    const auto map = every.make("voxel_hash");
    Window window;
    window.sequence = 1;
    Update update;
    update.map_points = points;
    insertion->begin(window, *map);
    insertion->apply(window, update, *map);
    insertion->finish(*map);
    CHECK(map->size() == 1);
  }
}

TEST_CASE("every insertion: nothing is allocated after warm-up but by the map") {
  class Blind final : public Map {
   public:
    void correspond(std::span<const Vec3> queries, const MapQuery& query, Neighbours& out) const override {
      out.resize(queries.size(), query.k);
    }
    InsertCount insert(std::span<const WorldPoint> points, std::uint32_t) override { return {points.size(), 0}; }
    void trim(const Vec3&) override {}
    void clear() override {}
    std::size_t size() const override { return 0; }
    std::size_t memory_bytes() const override { return 0; }
    double radius() const override { return 0; }
    void visit(const std::function<void(const Vec3&)>&) const override {}
  };
  EveryInsertion every;
  for (const std::string& type : every.insertions()) {
    CAPTURE(type);
    const auto insertion = every.insertion(type);
    Blind map;
    std::vector<WorldPoint> points(500);
    Update update;
    Window window;
    std::size_t warm = 0;
    for (std::uint32_t k = 1; k <= 300; ++k) {
      if (k == 100) warm = test::allocation_count();
      window.sequence = k;
      window.plan.fresh_begin = 1000 * static_cast<TimeNs>(k);
      window.plan.end = window.plan.fresh_begin + 1000;
      window.plan.history_begin = window.plan.end - 5000;
      for (std::size_t i = 0; i < points.size(); ++i) {
        points[i].t = window.plan.fresh_begin + 1 + static_cast<TimeNs>(i);
        points[i].p_W = Vec3(static_cast<double>(i), 0, k);
      }
      update.map_points = std::span(points).first(400 + k % 100);
      insertion->begin(window, map);
      insertion->apply(window, update, map);
    }
    CHECK(test::allocation_count() == warm);
  }
}

}  // namespace aslio
