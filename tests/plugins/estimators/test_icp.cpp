// Registration without IMU: the pose of a room, a motion that goes on, the learnt threshold, windows with nothing to
// match.
#include <catch2/catch.hpp>

#include "plugins/estimators/room_filter.hpp"

using namespace aslio;
using namespace aslio::test;

namespace {

double turn(const Pose& a, const Pose& b) { return log_so3(a.R.transpose() * b.R).norm(); }

}  // namespace

TEST_CASE("icp finds the pose from which the room was measured") {  // eq. ICP-1
  for (const std::string residual : {"point_to_point", "{type: point_to_plane, planes: neighbours}"}) {
    CAPTURE(residual);
    Filter filter({"estimator={type: icp, residual: " + residual + "}"});
    filter.build_map(1);
    const Pose truth{exp_so3(Vec3(0.02, -0.03, 0.04)), Vec3(0.15, -0.1, 0.05)};
    const Update& update = filter.update(RoomWindow(kRoomEpoch, kTenth, truth, 2));
    REQUIRE(update.accepted);
    CHECK(update.status == UpdateStatus::ok);  // eq. ICP-3
    CHECK((update.state.p - truth.p).norm() < 0.01);
    CHECK(turn(update.state.pose(), truth) < 0.01);
    CHECK(update.fresh_matches == 1000);
    CHECK(update.matches.size() == 1000);
    CHECK(update.residual_rms < 0.08);
    CHECK(update.spectrum[0] > 0);
  }
}

TEST_CASE("icp: a motion goes on as it did, and points are de-skewed with it") {  // eq. TRJ-2
  const TurningRoom motion{.rate = Vec3(0, 0, 0.8), .drift = Vec3(0.5, 0.3, 0)};
  Filter filter({"estimator={type: icp}"});
  filter.build_map(1);
  for (std::uint32_t k = 0; k < 12; ++k) {
    const TimeNs end = kRoomEpoch + (k + 1) * kTenth;
    const Update& update = filter.update(RoomWindow(end - kTenth, kTenth, motion, k + 2));
    REQUIRE(update.accepted);
    const Pose truth = motion.at(end);
    CAPTURE(k, update.state.p, truth.p);
    if (k < 5) continue;  // the motion has been learnt
    CHECK((update.state.p - truth.p).norm() < 0.02);
    CHECK(turn(update.state.pose(), truth) < 0.01);
    CHECK((update.prior.p - truth.p).norm() < 0.05);  // foretold
    CHECK((update.state.v - motion.drift).norm() < 0.25);
    // A point of the middle of the window lies on the wall from which it came.
    CHECK((update.trajectory->pose(end - kTenth / 2).p - motion.at(end - kTenth / 2).p).norm() < 0.02);
  }
}

TEST_CASE("icp: the threshold follows what the prediction was off by") {  // eq. ICP-2
  const std::string narrow = "estimator={type: icp, initial_threshold: 0.05, max_iterations: 30}";
  const Vec3 jump(0.3, 0.2, 0);
  Filter fresh({narrow}), experienced({narrow}), wide({"estimator={type: icp, max_iterations: 30}"});
  for (Filter* filter : {&fresh, &experienced, &wide}) filter->build_map(1);
  CHECK(wide.update(RoomWindow(kRoomEpoch, kTenth, Pose{.p = jump}, 2)).fresh_matches == 1000);
  const std::uint32_t few = fresh.update(RoomWindow(kRoomEpoch, kTenth, Pose{.p = jump}, 2)).fresh_matches;
  CHECK(few < 900);
  // It has been wrong by a decimetre before: it looks farther now.
  const Vec3 first(0.1, 0.08, 0);
  REQUIRE(experienced.update(RoomWindow(kRoomEpoch, kTenth, Pose{.p = first}, 2)).accepted);
  CHECK((experienced.estimator->state().p - first).norm() < 0.03);
  const RoomWindow second(kRoomEpoch + kTenth, kTenth, Pose{.p = first + jump}, 3);
  CHECK(experienced.update(second).fresh_matches > few + 50);
}

TEST_CASE("icp: windows with nothing to match go on as before, for a second") {
  const TurningRoom motion{.drift = Vec3(0.5, 0, 0)};
  Filter filter({"estimator={type: icp}"});
  filter.build_map(1);
  std::uint32_t k = 0;
  for (; k < 4; ++k) filter.update(RoomWindow(kRoomEpoch + k * kTenth, kTenth, motion, k + 2));
  const NavState last = filter.estimator->state();
  for (; k < 16; ++k) {
    const Update& update = filter.update(RoomWindow(kRoomEpoch + k * kTenth, kTenth, motion, k + 2, 5));
    CAPTURE(k);
    CHECK(update.status == UpdateStatus::few_matches);
    CHECK_FALSE(update.accepted);
    CHECK(update.state.p == update.prior.p);
    CHECK(update.insert == (k < 14));
  }
  CHECK((filter.estimator->state().p - (last.p + 1.2 * last.v)).norm() < 0.05);
}

TEST_CASE("icp takes no IMU data") {
  Filter filter({"estimator={type: icp}"});
  filter.build_map(1);
  CHECK_FALSE(filter.estimator->uses_imu());
  RoomWindow room(kRoomEpoch, kTenth, Pose{}, 2);
  room.window.imu = {};
  CHECK(filter.update(room).accepted);
  const std::vector<ImuSample> times{{.t = kRoomEpoch + kTenth}, {.t = kRoomEpoch + 2 * kTenth}};
  CHECK(filter.estimator->predict(times).t == kRoomEpoch + 2 * kTenth);
}

TEST_CASE("icp: matches are recorded as they were accepted, although the update teaches another threshold") {
  Filter filter({"estimator={type: icp, residual: {type: point_to_point, gate: 0.05}}"});
  filter.build_map(1);
  for (std::uint32_t k = 0; k < 4; ++k) {
    const Pose at{Mat3::Identity(), Vec3(0.15 * k, 0, 0)};
    const Update& found = filter.update(RoomWindow(kRoomEpoch + k * kTenth, kTenth, at, k + 2));
    REQUIRE(found.accepted);
    const auto accepted =
        std::count_if(found.matches.begin(), found.matches.end(), [](const MatchRecord& m) { return m.accepted; });
    CHECK(found.fresh_matches == static_cast<std::uint32_t>(accepted));
  }
}
