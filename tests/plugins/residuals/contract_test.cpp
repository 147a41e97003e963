// What every registered residual promises (stages/residual.hpp), over flat, straight and cluttered surroundings.
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <random>

#include "aslio/stages/residual.hpp"
#include "plugins/build_environment.hpp"
#include "plugins/overlaps/one_stage.hpp"
#include "plugins/under_test.hpp"

using namespace aslio;

namespace {

constexpr double kSigma = 0.03;  // [m]

class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}
  double operator()(double half) { return half * (2.0 * static_cast<double>(engine_() >> 11) * 0x1p-53 - 1.0); }
  Vec3 in_box(double half) {
    const double x = (*this)(half), y = (*this)(half), z = (*this)(half);
    return {x, y, z};
  }

 private:
  std::mt19937_64 engine_;
};

/// Queries and their neighbours: the first lies on the query, so that the query lies on every surface through them.
struct Surroundings {
  Surroundings(int count, const MapQuery& ask, std::uint64_t seed) : reach(0.4 * ask.max_distance) {
    Random random(seed);
    neighbours.resize(static_cast<std::size_t>(count), ask.k);
    for (int i = 0; i < count; ++i) {
      queries.push_back(1e4 * random.in_box(1.0));
      const Mat3 axes = exp_so3(random.in_box(2.0));
      // A plane, a line, a cloud, in turn: a residual of any kind of surface finds its own.
      const Vec3 extent = i % 3 == 0 ? Vec3(reach, reach, 0) : i % 3 == 1 ? Vec3(reach, 0, 0) : Vec3::Constant(reach);
      normals.push_back(axes.col(2));
      std::vector<Vec3> offsets{Vec3::Zero()};
      while (std::ssize(offsets) < ask.k) offsets.push_back(axes * extent.cwiseProduct(random.in_box(1.0)));
      std::sort(offsets.begin(), offsets.end(), [](const Vec3& a, const Vec3& b) { return a.norm() < b.norm(); });
      const auto row = static_cast<std::size_t>(i);
      neighbours.count[row] = static_cast<std::uint8_t>(ask.k);
      for (std::size_t j = 0; j < offsets.size(); ++j) {
        neighbours.offsets[row * neighbours.k() + j] = offsets[j].cast<float>();
        neighbours.squared[row * neighbours.k() + j] = static_cast<float>(offsets[j].squaredNorm());
      }
    }
  }

  double reach;  ///< half extent of a plane [m]
  std::vector<Vec3> queries, normals;
  Neighbours neighbours;
};

/// Far enough from the sensor for gates that ask more of near points [m].
constexpr float kFar = 1e5F;

std::vector<Surface> fitted(Residual& residual, const Surroundings& around) {
  std::vector<Surface> surfaces(around.queries.size(), {Vec3::Ones(), Vec3::Ones(), 7.0, true});
  residual.fit(around.queries, around.neighbours, surfaces);
  return surfaces;
}

std::vector<ResidualRow> evaluated(Residual& residual, const std::vector<Vec3>& world,
                                   const std::vector<Surface>& surfaces, float distance = kFar) {
  const std::vector<float> range(world.size(), distance);
  std::vector<ResidualRow> rows(world.size() * static_cast<std::size_t>(residual.rows_per_match()),
                                {7.0, Vec3::Ones(), 7.0});
  residual.evaluate(world, range, surfaces, kSigma, rows);
  return rows;
}

struct EveryResidual {
  std::vector<std::string> all() const { return test::under_test(catalog, Residual::family); }
  std::unique_ptr<Residual> make(const std::string& text) {
    return test::make_stage<Residual>(catalog, text, environment.context());
  }
  std::unique_ptr<Residual> make(const std::string& text, exec::Executor& exec) {
    return test::make_stage<Residual>(catalog, text, {exec, environment.sensor, nullptr, 0});
  }
  const plugin::Catalog catalog = test::stages_under_test();
  test::BuildEnvironment environment;
};

}  // namespace

TEST_CASE("every residual: asks for neighbours, finds surfaces, and none where there are no neighbours") {
  EveryResidual every;
  REQUIRE(!every.all().empty());
  for (const std::string& text : every.all()) {
    CAPTURE(text);
    const auto residual = every.make(text);
    REQUIRE(residual->rows_per_match() >= 1);
    if (residual->surfaces_from_map()) continue;
    const MapQuery ask = residual->query();
    REQUIRE(ask.k >= 1);
    REQUIRE(ask.k <= Neighbours::kMax);
    REQUIRE(ask.max_distance > 0.0);
    Surroundings around(300, ask, 1);
    std::size_t valid = 0;
    for (const Surface& surface : fitted(*residual, around)) {
      if (!surface.valid) continue;
      ++valid;
      REQUIRE(surface.anchor.allFinite());
      REQUIRE(surface.quality > 0.0);
      REQUIRE(surface.quality <= 1.0);
    }
    CHECK(valid >= 60);  // most of one kind at least
    std::fill(around.neighbours.count.begin(), around.neighbours.count.end(), std::uint8_t{0});
    for (const Surface& surface : fitted(*residual, around)) REQUIRE_FALSE(surface.valid);
  }
}

TEST_CASE("every residual: zero on its surface, the distance off it, Jacobians as central differences") {
  EveryResidual every;
  for (const std::string& text : every.all()) {
    CAPTURE(text);
    const auto residual = every.make(text);
    const auto per_match = static_cast<std::size_t>(residual->rows_per_match());
    const MapQuery ask = residual->query();
    const Surroundings around(300, ask, 2);
    std::vector<Surface> surfaces(around.queries.size());
    if (residual->surfaces_from_map()) {
      for (std::size_t i = 0; i < surfaces.size(); ++i) surfaces[i] = {around.normals[i], around.queries[i], 1.0, true};
    } else {
      surfaces = fitted(*residual, around);
    }
    const double off = 0.5 * kSigma, step = 1e-4;
    std::vector<Vec3> displaced = around.queries;
    for (std::size_t i = 0; i < displaced.size(); ++i) displaced[i] += off * around.normals[i];
    const auto on = evaluated(*residual, around.queries, surfaces), rows = evaluated(*residual, displaced, surfaces);
    // Planes and lines, each with those that are off: a residual of lines may take a narrow plane for one.
    std::array<std::size_t, 2> checked{}, off_true{};
    for (std::size_t i = 0; i < surfaces.size(); ++i) {
      if (i % 3 == 2 || !surfaces[i].valid || rows[i * per_match].information <= 0.0) continue;
      double squared_on = 0, squared_off = 0;
      for (std::size_t r = i * per_match; r < (i + 1) * per_match; ++r) {
        squared_on += on[r].r * on[r].r;
        squared_off += rows[r].r * rows[r].r;
      }
      // Neighbours are floats.
      const bool exact = std::sqrt(squared_on) < 1e-5 && std::abs(std::sqrt(squared_off) - off) < 1e-4;
      ++checked[i % 3];
      off_true[i % 3] += exact ? 0U : 1U;
    }
    CAPTURE(checked, off_true);
    CHECK(((checked[0] >= 60 && off_true[0] == 0) || (checked[1] >= 60 && off_true[1] == 0)));
    for (int axis = 0; axis < 3; ++axis) {
      std::vector<Vec3> up = displaced, down = displaced;
      for (auto& p : up) p[axis] += step;
      for (auto& p : down) p[axis] -= step;
      const auto rows_up = evaluated(*residual, up, surfaces), rows_down = evaluated(*residual, down, surfaces);
      for (std::size_t r = 0; r < rows.size(); ++r) {
        if (rows[r].information <= 0.0 || rows_up[r].information <= 0.0 || rows_down[r].information <= 0.0) continue;
        // Coordinates of 1e4 m are known to 2e-12 m.
        REQUIRE(std::abs(rows[r].J[axis] - (rows_up[r].r - rows_down[r].r) / (2 * step)) < 1e-6);
      }
    }
  }
}

TEST_CASE("every residual: no information from invalid surfaces, nor from points that are not finite") {
  EveryResidual every;
  constexpr double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  for (const std::string& text : every.all()) {
    CAPTURE(text);
    const auto residual = every.make(text);
    for (const ResidualRow& row : evaluated(*residual, {Vec3(1, 2, 3), Vec3::Zero()}, std::vector<Surface>(2))) {
      REQUIRE((!row.takes_part() && !row.measures()));
    }
    const Surface surface{Vec3::UnitZ(), Vec3::Zero(), 1.0, true};
    for (const Vec3& bad : {Vec3(nan, nan, nan), Vec3(inf, inf, inf)}) {
      for (const ResidualRow& row : evaluated(*residual, {bad}, {surface}))
        REQUIRE((!row.takes_part() && !row.measures()));
    }
  }
}

TEST_CASE("every residual: what a gate leaves out is measured all the same") {
  EveryResidual every;
  const std::vector<Surface> surface{{Vec3::UnitZ(), Vec3::Zero(), 1.0, true}};
  std::size_t left_out = 0;
  for (const std::string& text : every.all()) {
    CAPTURE(text);
    const auto residual = every.make(text);
    for (const double off : {1e-3, 0.1, 3.0, 1e4}) {
      const std::vector<Vec3> p{{0.3 * off, 0.4 * off, -off}};
      const auto far = evaluated(*residual, p, surface);
      for (const float distance : {1e-3F, 1.0F, 30.0F, kFar}) {
        const auto rows = evaluated(*residual, p, surface, distance);
        bool measured = false;
        for (std::size_t r = 0; r < rows.size(); ++r) {
          measured = measured || rows[r].measures();
          REQUIRE((rows[r].r == far[r].r && rows[r].J == far[r].J));
          left_out += rows[r].takes_part() ? 0U : 1U;
        }
        REQUIRE(measured);
      }
    }
  }
  if (!test::one_under_test(Residual::family)) CHECK(left_out > 0);  // a single one may have no gate
}

TEST_CASE("every residual: the same bits for any number of threads, place in the batch and repetition") {
  EveryResidual every;
  for (const std::string& text : every.all()) {
    CAPTURE(text);
    exec::Executor one(1), many(5);
    const auto alone = every.make(text, one), threaded = every.make(text, many);
    const Surroundings around(3000, alone->query(), 3);
    const auto a = fitted(*alone, around), b = fitted(*threaded, around), c = fitted(*alone, around);
    std::vector<Vec3> displaced = around.queries;
    for (auto& p : displaced) p += Vec3(0.01, -0.004, 0.006);
    const auto rows = evaluated(*alone, displaced, a), others = evaluated(*threaded, displaced, a);
    for (std::size_t i = 0; i < a.size(); ++i) {
      for (const Surface* other : {&b[i], &c[i]}) {
        REQUIRE(a[i].valid == other->valid);
        if (a[i].valid) REQUIRE((a[i].normal == other->normal && a[i].anchor == other->anchor));
      }
    }
    for (std::size_t r = 0; r < rows.size(); ++r) {
      REQUIRE(rows[r].information == others[r].information);
      if (rows[r].information > 0.0) REQUIRE((rows[r].r == others[r].r && rows[r].J == others[r].J));
    }
    const auto per_match = static_cast<std::size_t>(alone->rows_per_match());
    for (const std::size_t i : {std::size_t{0}, std::size_t{1501}, a.size() - 1}) {
      const auto single = evaluated(*alone, {displaced[i]}, {a[i]});
      for (std::size_t r = 0; r < per_match; ++r) REQUIRE(single[r].information == rows[i * per_match + r].information);
    }
  }
}
