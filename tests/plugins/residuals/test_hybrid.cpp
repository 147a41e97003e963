// Planes and points in one batch: which is which, the share of planes, rows, and the Jacobian.
#include <catch2/catch.hpp>
#include <limits>
#include <random>

#include "aslio/toolkit/point_matches.hpp"
#include "plugins/build_environment.hpp"
#include "residuals/hybrid.hpp"

using namespace aslio;
using plugins::Hybrid;
using plugins::PointToPlane;
using plugins::PointToPoint;

namespace {

struct Random {
  std::mt19937_64 engine{5};
  double operator()(double half) { return half * (2.0 * static_cast<double>(engine() >> 11) * 0x1p-53 - 1.0); }
  Vec3 vector(double half) { return {(*this)(half), (*this)(half), (*this)(half)}; }
};

/// `planar` queries on planes, then `cluttered` ones among scattered points, then `alone` ones with two neighbours and
/// `empty` ones without any.
struct Surroundings {
  Surroundings(int planar, int cluttered, int alone, int empty) {
    Random random;
    const int n = planar + cluttered + alone + empty;
    neighbours.resize(static_cast<std::size_t>(n), 5);
    for (int i = 0; i < n; ++i) {
      queries.push_back(random.vector(100));
      range.push_back(10.0F);
      const Vec3 normal = random.vector(1).normalized(), u = normal.unitOrthogonal(), v = normal.cross(u);
      const int found = i < planar + cluttered ? 5 : i < planar + cluttered + alone ? 2 : 0;
      neighbours.count[static_cast<std::size_t>(i)] = static_cast<std::uint8_t>(found);
      for (int j = 0; j < found; ++j) {
        const double turn = 1.2566 * j, reach = 0.2 + 0.05 * j;
        Vec3 offset = reach * (std::cos(turn) * u + std::sin(turn) * v);
        if (i >= planar) offset += (j % 2 == 0 ? 0.3 : -0.3) * normal;
        neighbours.offsets[static_cast<std::size_t>(5 * i + j)] = offset.cast<float>();
        neighbours.squared[static_cast<std::size_t>(5 * i + j)] = static_cast<float>(offset.squaredNorm());
      }
    }
  }
  std::vector<Surface> fitted(Residual& residual) const {
    std::vector<Surface> out(queries.size());
    residual.fit(queries, neighbours, out);
    return out;
  }
  std::vector<Vec3> queries;
  std::vector<float> range;
  Neighbours neighbours;
};

std::vector<ResidualRow> rows_of(Residual& residual, const std::vector<Vec3>& world, const std::vector<float>& range,
                                 const std::vector<Surface>& surfaces, double sigma = 0.03) {
  std::vector<ResidualRow> rows(world.size() * static_cast<std::size_t>(residual.rows_per_match()));
  residual.evaluate(world, range, surfaces, sigma, rows);
  return rows;
}

}  // namespace

TEST_CASE("hybrid: planes as point_to_plane has them, the nearest point where there is none") {  // eq. RES-6
  test::BuildEnvironment environment;
  const Surroundings around(60, 20, 10, 10);
  Hybrid residual({}, environment.context());
  PointToPlane planes({}, environment.context());
  PointToPoint points({.max_distance = 1.0}, environment.context());
  const auto found = around.fitted(residual), plane = around.fitted(planes), point = around.fitted(points);
  const auto rows = rows_of(residual, around.queries, around.range, found);
  const auto plane_rows = rows_of(planes, around.queries, around.range, plane);
  const auto point_rows = rows_of(points, around.queries, around.range, point, 0.15);
  const double alpha = 60.0 / 90.0;  // of 100, ten have nothing to match
  for (std::size_t i = 0; i < 100; ++i) {
    CAPTURE(i);
    REQUIRE(plane[i].valid == (i < 60));
    REQUIRE(found[i].valid == (i < 90));
    if (i < 60) {
      CHECK(found[i].quality == Approx(alpha));
      CHECK(rows[3 * i].r == plane_rows[i].r);
      CHECK(rows[3 * i].J == plane_rows[i].J);
      CHECK(rows[3 * i].information == Approx(alpha * plane_rows[i].information));
      for (std::size_t row : {3 * i + 1, 3 * i + 2}) CHECK((!rows[row].measures() && !rows[row].takes_part()));
    } else if (i < 90) {
      CHECK(found[i].quality == Approx(1.0 - alpha));
      for (std::size_t row = 3 * i; row < 3 * i + 3; ++row) {
        CHECK(rows[row].r == point_rows[row].r);
        CHECK(rows[row].J == point_rows[row].J);
        CHECK(rows[row].information > 0.0);
        CHECK(rows[row].information == Approx((1.0 - alpha) * point_rows[row].information));
      }
    }
  }
}

TEST_CASE("hybrid: alpha is the share of planes of one association, and none leaves all weights at 1") {
  test::BuildEnvironment environment;
  Hybrid residual({}, environment.context());
  for (const auto& [planar, cluttered] : {std::pair{50, 0}, std::pair{0, 50}, std::pair{49, 1}, std::pair{10, 30}}) {
    CAPTURE(planar, cluttered);
    const double alpha = planar / static_cast<double>(planar + cluttered);
    const auto found = Surroundings(planar, cluttered, 0, 3).fitted(residual);
    for (int i = 0; i < planar + cluttered; ++i) {
      CHECK(found[static_cast<std::size_t>(i)].quality == Approx(i < planar ? alpha : 1.0 - alpha));
    }
  }
  Hybrid plain({.weighting = Hybrid::Weighting::none}, environment.context());
  for (const Surface& surface : Surroundings(10, 30, 0, 0).fitted(plain)) CHECK(surface.quality == 1.0);
}

TEST_CASE("hybrid: planarity refuses planes by the share of the smallest eigenvalue") {
  test::BuildEnvironment environment;
  const Surroundings around(0, 20, 0, 0);
  const auto valid = [&](std::optional<double> planarity) {
    PointToPlane planes({.plane_threshold = 10.0, .planarity = planarity, .min_spread = 0.0}, environment.context());
    const auto found = around.fitted(planes);
    return std::count_if(found.begin(), found.end(), [](const Surface& s) { return s.valid; });
  };
  CHECK(valid(std::nullopt) == 20);
  CHECK(valid(1.0 / 3.0) == 20);  // the smallest of three is never more
  CHECK(valid(0.01) == 0);
  Hybrid residual({.plane_threshold = 10.0, .planarity = 0.01, .min_spread = 0.0}, environment.context());
  for (const Surface& surface : around.fitted(residual)) CHECK((surface.valid && surface.normal.isZero(0.0)));
}

TEST_CASE("hybrid: the Jacobians are those of central differences, and matches are counted by matches") {
  test::BuildEnvironment environment;
  Random random;
  Hybrid residual({.gate = 0, .point_gate = 0}, environment.context());
  const Surroundings around(20, 20, 0, 0);
  const auto surfaces = around.fitted(residual);
  std::vector<Vec3> world = around.queries;
  for (Vec3& p : world) p += random.vector(0.05);
  const auto rows = rows_of(residual, world, around.range, surfaces);
  for (int axis = 0; axis < 3; ++axis) {
    constexpr double step = 1e-4;
    std::vector<Vec3> up = world, down = world;
    for (Vec3& p : up) p[axis] += step;
    for (Vec3& p : down) p[axis] -= step;
    const auto above = rows_of(residual, up, around.range, surfaces),
               below = rows_of(residual, down, around.range, surfaces);
    for (std::size_t r = 0; r < rows.size(); ++r) {
      CHECK(rows[r].J[axis] == Approx((above[r].r - below[r].r) / (2 * step)).margin(1e-8));
    }
  }
  const auto part = std::count_if(rows.begin(), rows.end(), [](const ResidualRow& row) { return row.takes_part(); });
  CHECK(part == 20 + 3 * 20);
  CHECK(count_matches(rows, 3, static_cast<std::size_t>(part)) == 40);
  CHECK(count_matches(rows, 3, static_cast<std::size_t>(part), 0.0) == 0);  // none lies within a gate of 0
}

TEST_CASE("hybrid: planes and points have gates of their own, and the kernel bends points alone") {
  test::BuildEnvironment environment;
  Hybrid residual({.point_sigma = 0.1, .point_gate = 3.0, .weighting = Hybrid::Weighting::none}, environment.context());
  const Surface plane{.normal = Vec3::UnitZ(), .valid = true}, point{.valid = true};
  const auto rows = [&](const Surface& surface, const Vec3& at) {
    return rows_of(residual, {at}, {10.0F}, {surface}, 0.02);
  };
  CHECK(rows(plane, {0, 0, 0.3})[0].information == Approx(1 / (0.02 * 0.02)));  // 10 m > 81 * 0.09 m
  CHECK(rows(plane, {0, 0, 0.4})[0].information == 0.0);
  const double bell = 0.1 / (0.1 + 0.04);
  CHECK(rows(point, {0.2, 0, 0})[0].information == Approx(bell * bell / 0.01));
  CHECK(rows(point, {0.31, 0, 0})[0].information == 0.0);
  CHECK(rows(point, {0.31, 0, 0})[0].measures());
}
