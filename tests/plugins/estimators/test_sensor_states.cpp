// What may be estimated of the sensor file: the mounting of the LiDAR, and the scale of the accelerometer (IESKF-9).
#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cmath>
#include <string>

#include "aslio/core/angles.hpp"
#include "plugins/estimators/room_filter.hpp"

using namespace aslio;
using namespace aslio::test;

namespace {

/// Turns about all axes on the spot, from rest.
Mat3 attitude(double s) {
  const double up = std::min(s * s, 1.0);
  return exp_so3(up * Vec3(0.3 * std::sin(1.7 * s), 0.25 * std::sin(2.3 * s), 0.9 * std::sin(1.1 * s)));
}

/// A window of that motion, seen by a LiDAR that is mounted as `mounted` on the IMU; the accelerometer reads
/// `acc_scale` too much of everything.
RoomWindow& turning(RoomWindow& room, TimeNs begin, const Pose& mounted, double acc_scale) {
  const auto seconds = [](TimeNs t) { return to_seconds(t - kRoomEpoch); };
  for (ImuSample& sample : room.imu) {
    const double s = seconds(sample.t), h = 1e-4;
    sample.gyro = log_so3(attitude(s - h).transpose() * attitude(s + h)) / (2 * h);
    sample.acc = (1 + acc_scale) * (attitude(s).transpose() * Vec3(0, 0, kStandardGravity));
  }
  const auto directions = all_around(static_cast<int>(room.fresh.size()));
  for (std::size_t i = 0; i < room.fresh.size(); ++i) {
    TimedPoint& point = room.fresh[i];
    point.t = begin + static_cast<TimeNs>(i + 1) * kTenth / static_cast<TimeNs>(room.fresh.size());
    const Pose T{attitude(seconds(point.t)) * mounted.R, attitude(seconds(point.t)) * mounted.p};
    const Vec3& d = directions[i * 1009 % room.fresh.size()];
    const Vec3 p = wall_distance(T.p, T.R * d) * d;
    point.x = static_cast<float>(p.x());
    point.y = static_cast<float>(p.y());
    point.z = static_cast<float>(p.z());
  }
  return room;
}

struct Learnt {
  Update update;
  SensorEstimate sensor;
  double turned = 0;  ///< error of the attitude relative to that at the start [rad]
};

/// After six seconds in a room that nobody knew, with a sensor file that says that the LiDAR sits on the IMU.
Learnt after(const std::vector<std::string>& keys, const Pose& mounted, double acc_scale = 0) {
  std::vector<std::string> all = {"estimator.noise=physical"};
  all.insert(all.end(), keys.begin(), keys.end());
  Filter filter(all, 0.01, true);
  Learnt out;
  for (int k = 0; k < 60; ++k) {
    const TimeNs begin = kRoomEpoch + k * kTenth;
    RoomWindow room(begin, kTenth, Pose{}, static_cast<std::uint32_t>(k + 1), 2000);
    out.update = filter.update(turning(room, begin, mounted, acc_scale));
    REQUIRE((k == 0 || out.update.accepted));
    filter.map->insert(out.update.points(PointUse::map), static_cast<std::uint32_t>(k + 1));
    const Mat3 truth = attitude(to_seconds(room.window.plan.end - kRoomEpoch));
    out.turned = log_so3(truth.transpose() * out.update.state.R).norm();
  }
  if (out.update.sensor) out.sensor = *out.update.sensor;
  return out;
}

}  // namespace

TEST_CASE("extrinsic: a LiDAR that is turned and shifted against the sensor file is found") {  // eq. IESKF-9
  const Pose mounted{exp_so3(kRadPerDeg * Vec3(0.4, -0.6, 0.5)), Vec3(0.01, -0.012, 0.008)};
  for (const std::string rule : {"rigid", "linear", "state"}) {
    CAPTURE(rule);
    const Learnt full = after({"estimator.extrinsic=full", "estimator.deskew_correction=" + rule}, mounted);
    const Vec3 turn_off = log_so3(mounted.R.transpose() * full.sensor.T_imu_lidar.R) / kRadPerDeg;
    const Vec3 shift_off = full.sensor.T_imu_lidar.p - mounted.p;
    CAPTURE(turn_off.transpose(), shift_off.transpose());
    // Less than a third of 0.88 deg and 17.5 mm is left, also where early points of a window count less.
    CHECK(turn_off.norm() < 0.29);
    CHECK(shift_off.norm() < 0.0058);
    CHECK(full.sensor.sigma_rotation.maxCoeff() < 0.15 * kRadPerDeg);
    CHECK(full.sensor.sigma_rotation.minCoeff() > 0);
  }
}

TEST_CASE("extrinsic: rotation leaves the translation as the sensor file has it, and none leaves all") {
  const Pose mounted{exp_so3(kRadPerDeg * Vec3(0.4, -0.6, 0.5)), Vec3::Zero()};
  const Learnt rotation = after({"estimator.extrinsic=rotation"}, mounted);
  CHECK(rotation.sensor.T_imu_lidar.p == Vec3::Zero());
  CHECK(rotation.sensor.sigma_translation == Vec3::Zero());
  CHECK(log_so3(mounted.R.transpose() * rotation.sensor.T_imu_lidar.R).norm() < 0.2 * kRadPerDeg);
  const Learnt none = after({}, mounted);
  CHECK(!none.update.sensor);
}

TEST_CASE("extrinsic: a sensor file that is right stays so, within what is claimed") {
  const Learnt full = after({"estimator.extrinsic=full"}, Pose{});
  const Vec3 turn = log_so3(full.sensor.T_imu_lidar.R);
  CHECK(turn.norm() < 0.1 * kRadPerDeg);
  CHECK(full.sensor.T_imu_lidar.p.norm() < 0.002);
}

TEST_CASE("acc_scale: what the accelerometer reads too much is found where gravity turns in its axes") {
  const Learnt scaled = after({"estimator.acc_scale=true"}, Pose{}, 0.01);
  CAPTURE(scaled.sensor.acc_scale.transpose(), scaled.sensor.sigma_acc_scale.transpose());
  CHECK(scaled.sensor.acc_scale.z() == Approx(0.01).margin(0.003));
  CHECK(scaled.sensor.sigma_acc_scale.z() < 0.005);
  CHECK(scaled.sensor.T_imu_lidar.p == Vec3::Zero());
}

TEST_CASE("a start forgets what was learnt of the sensors") {
  Filter filter({"estimator.extrinsic=full"});
  filter.build_map(1);
  const RoomWindow room(kRoomEpoch, kTenth, Pose{exp_so3(Vec3(0.004, 0, 0)), Vec3::Zero()}, 2);
  const Update& update = filter.update(room);
  REQUIRE(update.sensor);
  filter.estimator->reset(filter.initial);
  const RoomWindow again(kRoomEpoch, kTenth, Pose{}, 3);
  REQUIRE(filter.update(again).sensor);
  CHECK(filter.update(again).sensor->T_imu_lidar.p.norm() < 1e-3);
}
