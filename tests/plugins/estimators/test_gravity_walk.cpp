// Gravity that turns against the map (eq. MOT-8), in the estimators that take `gravity_walk`.
#include <catch2/catch.hpp>
#include <cmath>

#include "aslio/core/angles.hpp"
#include "plugins/estimators/room_filter.hpp"

using namespace aslio;
using namespace aslio::test;

namespace {

constexpr int kGravity = 15;  // first row of its block

std::vector<std::string> estimator(const std::string& type, const std::string& walk, const std::string& gravity) {
  return {"estimator={type: " + type + ", noise: physical, gravity: " + gravity + ", gravity_walk: " + walk + "}"};
}

/// Growth of the covariance of gravity over a window in which nothing is seen.
Mat3 growth(const std::string& type, const std::string& walk, const std::string& gravity) {
  Filter filter(estimator(type, walk, gravity), 0.01, true);
  filter.build_map(1);
  const Mat3 before = filter.update(RoomWindow(kRoomEpoch, kTenth, Pose{}, 2, 3000)).P.block<3, 3>(kGravity, kGravity);
  RoomWindow blind(kRoomEpoch + kTenth, kTenth, Pose{}, 3, 3000);
  blind.window.fresh = {};
  const Update& update = filter.update(blind);
  REQUIRE_FALSE(update.accepted);
  return update.P.block<3, 3>(kGravity, kGravity) - before;
}

/// Angle [deg] between the gravity that is found and the true one after 4 s at rest in a room, while the true one turns
/// by 0.1 deg/s against the walls.
double missed(const std::string& type, const std::string& walk) {
  Filter filter(estimator(type, walk, "s2"), 0.01, true);
  filter.build_map(1);
  Vec3 g = Vec3::Zero();
  for (std::uint32_t k = 0; k < 40; ++k) {
    RoomWindow room(kRoomEpoch + k * kTenth, kTenth, Pose{}, k + 2, 3000);
    for (ImuSample& sample : room.imu) {
      const double angle = 0.1 * kRadPerDeg * to_seconds(sample.t - kRoomEpoch);
      g = kStandardGravity * Vec3(std::sin(angle), 0, -std::cos(angle));
      sample.acc = -g;
    }
    REQUIRE(filter.update(room).accepted);
  }
  return std::acos(filter.estimator->state().g.normalized().dot(g.normalized())) / kRadPerDeg;
}

}  // namespace

TEST_CASE("gravity_walk: its direction grows uncertain with time, its length does not") {  // eq. MOT-8
  for (const char* type : {"ieskf", "smoother"}) {
    CAPTURE(type);
    const double variance = std::pow(0.5 * kRadPerDeg * kStandardGravity, 2) * 0.1;  // of 0.5 deg/sqrt(s) over 0.1 s
    const Mat3 grown = growth(type, "0.5", "s2");
    CHECK(grown(0, 0) == Approx(variance).epsilon(0.01));
    CHECK(grown(1, 1) == Approx(variance).epsilon(0.01));
    CHECK(std::abs(grown(2, 2)) < 0.01 * variance);
    CHECK(growth(type, "0", "s2").norm() < 1e-3 * variance);
    CHECK(growth(type, "0.5", "fixed").norm() == 0);
    const Mat3 free = growth(type, "0.5", "free");
    CHECK(free(0, 0) == Approx(variance).epsilon(0.01));
    CHECK(std::abs(free(2, 2)) < 0.01 * variance);
  }
}

TEST_CASE("gravity_walk: gravity that turns against the map is followed") {  // eq. MOT-8
  for (const char* type : {"ieskf", "smoother"}) {
    CAPTURE(type);
    CHECK(missed(type, "0.1") < 0.1);
    CHECK(missed(type, "0") > 0.2);
  }
}
