#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cmath>

#include "closure.hpp"
#include "routes.hpp"
#include "smoothness.hpp"

using namespace aslio;
using namespace aslio::simulator;
using namespace aslio::simulator::test;

namespace {

/// The state of its derivatives jumps in the middle: jerk and curvature of the rate of turn by 6 each.
class Kinked final : public Motion {
 public:
  MotionState at(double t) const override {
    const double u = std::max(0.0, t - 0.5003);
    MotionState state;
    state.a.x() = 6 * u;
    state.w.z() = 3 * u * u;
    return state;
  }
  double duration() const override { return 1; }
};

WalkParams with_gait(GaitKind gait) {
  WalkParams params;
  params.gait = gait;
  params.glances = {{0.3, 70, 0.5, 0.3}};
  return params;
}

void check_smooth(const Motion& motion) {
  const DerivativeErrors errors = derivative_errors(motion, 2.3e-3);
  CHECK(errors.velocity < 1e-7);
  CHECK(errors.acceleration < 2e-5);
  CHECK(errors.rate < 2e-6);
  CHECK(errors.rotation < 1e-14);
  const LargestChanges coarse = largest_changes(motion, 5e-4), fine = largest_changes(motion, 5e-5);
  CHECK(fine.jerk < 0.11 * coarse.jerk);
  CHECK(fine.rate_curvature < 0.11 * coarse.rate_curvature);
}

}  // namespace

TEST_CASE("the measure of smoothness finds jumps of the third derivative") {
  const LargestChanges coarse = largest_changes(Kinked(), 5e-4), fine = largest_changes(Kinked(), 5e-5);
  CHECK(coarse.jerk > 3);
  CHECK(fine.jerk > 3);
  CHECK(coarse.rate_curvature > 3);
  CHECK(fine.rate_curvature > 3);
}

TEST_CASE("walks over routes have exact derivatives and are three times continuously differentiable") {
  for (const GaitKind gait : kGaits) {
    CAPTURE(static_cast<int>(gait));
    check_smooth(*make_route_walk(crooked(), hilly(), with_gait(gait), 3));
  }
  check_smooth(*make_route_walk(out_and_back(), Ground{}, with_gait(GaitKind::walking), 1));
  WalkParams under_way = with_gait(GaitKind::running);
  under_way.dynamic_start = true;
  under_way.laps = 2;
  check_smooth(*make_route_walk(crooked(), hilly(), under_way, 2));
}

TEST_CASE("walks end exactly where they began, and stand still before and after") {
  for (const GaitKind gait : kGaits)
    for (const std::uint64_t seed : {1, 2, 77}) {
      CAPTURE(static_cast<int>(gait), seed);
      for (const Route& route : {crooked(), out_and_back()}) {
        WalkParams params = with_gait(gait);
        const auto walk = make_route_walk(route, hilly(), params, seed);
        check_closed(*walk, params.standstill);
        check_still_before(*walk, params.standstill);
      }
    }
}

TEST_CASE("a dynamic start begins in full walk and ends in the same pose") {
  for (const GaitKind gait : kGaits)
    for (const std::uint64_t seed : {1, 2, 3, 4}) {
      CAPTURE(static_cast<int>(gait), seed);
      WalkParams params = with_gait(gait);
      params.dynamic_start = true;
      const auto walk = make_route_walk(crooked(), Ground{}, params, seed);
      CHECK(walk->at(0).v.head<2>().norm() == Approx(params.speed));
      CHECK((walk->at(0).v.head<2>().normalized() - Vec2(1, 0)).norm() < 1e-12);
      check_closed(*walk, params.standstill);
    }
}

TEST_CASE("a walk goes through the middles of its edges, looking ahead, at its height above the ground") {
  const Route route = crooked();
  const Ground ground = hilly();
  WalkParams params;
  params.gait = GaitKind::smooth;
  const auto walk = make_route_walk(route, ground, params, 4);
  double farthest = 0;
  for (double t = 0; t < walk->duration(); t += 0.01) {
    const MotionState m = walk->at(t);
    farthest = std::max(farthest, route.distance(m.p.head<2>()));
    REQUIRE(std::abs(m.p.z() - ground.height(m.p.x(), m.p.y()) - params.height) < 1e-12);
    REQUIRE(m.v.head<2>().norm() < params.speed + 1e-9);
  }
  CHECK(farthest < params.corner_radius);
  for (const auto& [middle, along] : {std::pair(Vec2(3.5, 0), Vec2(1, 0)), std::pair(Vec2(14, 4.5), Vec2(0, 1)),
                                      std::pair(Vec2(11, 15), Vec2(0, -1)), std::pair(Vec2(5.5, 10), Vec2(-1, 0))}) {
    double nearest = 1;
    Vec3 ahead = Vec3::Zero();
    for (double t = 0; t < walk->duration(); t += 0.005) {
      const MotionState m = walk->at(t);
      if ((m.p.head<2>() - middle).norm() >= nearest) continue;
      nearest = (m.p.head<2>() - middle).norm();
      ahead = m.R.col(0);
    }
    CAPTURE(middle.transpose());
    CHECK(nearest < 0.01);
    CHECK((ahead.head<2>() - along).norm() < 1e-9);
  }
}

TEST_CASE("laps are walked without a stop, each over the whole round") {
  WalkParams params;
  params.gait = GaitKind::smooth;
  params.standstill = 1;
  const Route route = crooked();
  const auto once = make_route_walk(route, Ground{}, params, 4);
  params.laps = 3;
  const auto thrice = make_route_walk(route, Ground{}, params, 4);
  const auto length = [](const Motion& motion) {
    double sum = 0;
    for (double t = 0; t < motion.duration(); t += 1e-3) sum += 1e-3 * motion.at(t).v.norm();
    return sum;
  };
  CHECK(length(*thrice) == Approx(3 * length(*once)).epsilon(0.01));
  check_closed(*thrice, params.standstill);
  double slowest = 10;
  for (double t = params.standstill + 2; t < thrice->duration() - params.standstill - 2; t += 0.01)
    slowest = std::min(slowest, thrice->at(t).v.norm());
  CHECK(slowest > 0.3);
}

TEST_CASE("the seed draws turns and gait: equal seeds give equal walks") {
  const auto a = make_route_walk(crooked(), hilly(), WalkParams{}, 5);
  const auto b = make_route_walk(crooked(), hilly(), WalkParams{}, 5);
  const auto c = make_route_walk(crooked(), hilly(), WalkParams{}, 6);
  double apart = 0;
  for (double t = 0; t < a->duration(); t += 0.1) {
    CHECK(a->at(t).p == b->at(t).p);
    CHECK(a->at(t).R == b->at(t).R);
    apart = std::max(apart, log_so3(a->at(t).R.transpose() * c->at(t).R).norm());
  }
  CHECK(apart > 0.01);
}
