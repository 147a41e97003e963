/// Jolts, sway, tremor and turns about all axes.

#include <catch2/catch.hpp>
#include <cmath>

#include "aslio/core/angles.hpp"
#include "aslio/core/measurement.hpp"
#include "simulator/motion/closure.hpp"
#include "simulator/motion/routes.hpp"
#include "simulator/motion/smoothness.hpp"

using namespace aslio;
using namespace aslio::simulator;
using namespace aslio::simulator::test;

namespace {

constexpr GaitRealism kBody{.heel = 1, .sway = 1, .tremor = 1, .turns = 1};

struct Peaks {
  double force_g = 0, roll_rate = 0, pitch_rate = 0;  ///< [g], [rad/s], [rad/s]
};

Peaks peaks(const Motion& motion) {
  Peaks most;
  for (double t = 0; t < motion.duration(); t += 1e-3) {
    const MotionState m = motion.at(t);
    most.force_g = std::max(most.force_g, (m.a + Vec3(0, 0, kStandardGravity)).norm() / kStandardGravity);
    most.roll_rate = std::max(most.roll_rate, std::abs(m.w.x()));
    most.pitch_rate = std::max(most.pitch_rate, std::abs(m.w.y()));
  }
  return most;
}

WalkParams with(GaitKind gait, bool dynamic_start = false) {
  WalkParams params;
  params.gait = gait;
  params.dynamic_start = dynamic_start;
  return params;
}

}  // namespace

TEST_CASE("a walk with a body has exact derivatives and closes", "[realism]") {
  for (const GaitKind gait : kGaits) {
    for (const bool dynamic : {false, true}) {
      CAPTURE(static_cast<int>(gait), dynamic);
      const WalkParams params = with(gait, dynamic);
      const auto motion = make_route_walk(crooked(), hilly(), params, 3, kBody);
      const DerivativeErrors errors = derivative_errors(*motion, 7.1e-3);
      CHECK(errors.velocity < 1e-5);
      CHECK(errors.acceleration < 2e-3);
      CHECK(errors.rate < 1e-4);
      CHECK(errors.rotation < 1e-14);
      check_closed(*motion, params.standstill);
    }
  }
}

TEST_CASE("heels jolt: some 1.5 g on foot, 4 to 6 g at a run", "[realism]") {
  const double walking = peaks(*make_route_walk(crooked(), {}, with(GaitKind::walking), 3, {.heel = 1})).force_g;
  const double running = peaks(*make_route_walk(crooked(), {}, with(GaitKind::running), 3, {.heel = 1})).force_g;
  CHECK(walking > 1.3);
  CHECK(walking < 2);
  CHECK(running > 4);
  CHECK(running < 6);
}

TEST_CASE("a turn is one about all axes", "[realism]") {
  const Peaks plain = peaks(*make_route_walk(crooked(), {}, with(GaitKind::smooth), 3));
  const Peaks leaning = peaks(*make_route_walk(crooked(), {}, with(GaitKind::smooth), 3, {.turns = 1}));
  CHECK(plain.roll_rate < 1e-9);
  CHECK(leaning.roll_rate > 30 * kRadPerDeg);
  CHECK(leaning.pitch_rate > 20 * kRadPerDeg);
}

TEST_CASE("a hand trembles by a tenth of a degree, and the way sways by 2 cm", "[realism]") {
  const auto plain = make_route_walk(crooked(), {}, with(GaitKind::walking), 3);
  const auto trembling = make_route_walk(crooked(), {}, with(GaitKind::walking), 3, {.tremor = 1});
  const auto swaying = make_route_walk(crooked(), {}, with(GaitKind::walking), 3, {.sway = 1});
  double squares = 0, widest = 0;
  int count = 0;
  for (double t = 4; t < plain->duration() - 4; t += 1e-2, ++count) {
    squares += log_so3(plain->at(t).R.transpose() * trembling->at(t).R).squaredNorm();
    widest = std::max(widest, (plain->at(t).p - swaying->at(t).p).norm());
  }
  // Three axes, RMS of a sine; the mean stays off by the value at the start.
  const double rms = std::sqrt(squares / count) / kRadPerDeg;
  CHECK(rms > 0.1);
  CHECK(rms < 0.35);
  CHECK(widest == Approx(0.02).epsilon(0.02));
}

TEST_CASE("what realism draws leaves the turns of a walk where they are", "[realism]") {
  const auto plain = make_route_walk(crooked(), {}, with(GaitKind::smooth), 3);
  const auto real = make_route_walk(crooked(), {}, with(GaitKind::smooth), 3, kBody);
  CHECK(plain->duration() == real->duration());
  CHECK((plain->at(10).p - real->at(10).p).norm() < 1e-9);
}
