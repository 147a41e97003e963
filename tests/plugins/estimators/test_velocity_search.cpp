// A start in motion (eq. INI-3): how long, and how well, the velocity is sought.
#include <catch2/catch.hpp>
#include <cmath>
#include <utility>

#include "aslio/toolkit/velocity_search.hpp"

using namespace aslio;

namespace {

InitialState in_motion() {
  InitialState initial;
  initial.mode = InitialMode::dynamic_start;
  initial.sigma_velocity = 3.0;
  initial.state.b_a = Vec3(0.1, 0.2, 0.3);
  return initial;
}

WindowPlan window(TimeNs begin, TimeNs length) {
  WindowPlan plan;
  plan.fresh_begin = begin;
  plan.end = begin + length;
  return plan;
}

/// Updates until the search is over, and the velocity's standard deviation then [m/s].
std::pair<int, double> search(TimeNs length) {
  VelocitySearch velocity;
  velocity.begin(in_motion());
  NavState state;
  int updates = 0;
  for (TimeNs t = 0; velocity.active(); t += length, ++updates) {
    REQUIRE(updates < 1000);
    velocity.step(window(t, length), state);
  }
  return {updates, velocity.sigma_velocity()};
}

}  // namespace

TEST_CASE("velocity search: as long and as well for short windows as for long ones") {  // eq. INI-3
  const auto [five, at_10_hz] = search(kSecond / 10);
  CHECK(five == 5);
  CHECK(at_10_hz == Approx(0.05));  // 3 * 0.4^5 is less
  CHECK(search(99'900'000).first == 5);
  const auto [nine, at_20_hz] = search(kSecond / 20);
  CHECK(nine == 9);
  CHECK(at_20_hz == Approx(0.05));
  const auto [many, at_125_hz] = search(kSecond / 125);
  CHECK(many == 57);
  CHECK(at_125_hz == Approx(0.05));
  CHECK(search(10 * kSecond).first == 5);  // longer windows, or gaps: each is one look
}

TEST_CASE("velocity search: doubt shrinks with time, and all but the velocity is as at the start") {  // eq. INI-3
  VelocitySearch velocity;
  velocity.begin(in_motion());
  NavState state;
  state.v = Vec3(1, 2, 3);
  state.b_a = Vec3(5, 5, 5);
  state.imu_delay = 0.1;
  velocity.step(window(0, kSecond / 20), state);
  CHECK(velocity.sigma_velocity() == Approx(3.0 * std::sqrt(0.4)));
  velocity.step(window(kSecond / 20, kSecond / 20), state);
  CHECK(velocity.sigma_velocity() == Approx(3.0 * 0.4));
  CHECK(state.v == Vec3(1, 2, 3));
  CHECK(state.b_a == in_motion().state.b_a);
  CHECK(state.imu_delay == 0.0);
}

TEST_CASE("velocity search: a start at rest has none") {  // eq. INI-3
  InitialState initial = in_motion();
  initial.mode = InitialMode::static_start;
  VelocitySearch velocity;
  velocity.begin(initial);
  CHECK_FALSE(velocity.active());
}
