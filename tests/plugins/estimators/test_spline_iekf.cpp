// The filter of a recursive spline in a room: a motion that swings, with and without IMU, and what may go wrong.
#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "plugins/estimators/room_filter.hpp"

using namespace aslio;
using namespace aslio::test;

namespace {

/// Swings by 0.6 m and 0.5 rad from rest at the origin, at up to 1.1 m/s, 2.2 m/s^2 and 0.7 rad/s.
struct Swing {
  static Pose at(double s) {
    const double yaw = 0.4 * (1 - std::cos(1.3 * s)), roll = 0.1 * (1 - std::cos(2 * s));
    return {exp_so3(yaw * Vec3::UnitZ()) * exp_so3(roll * Vec3::UnitX()),
            Vec3(0.5 * (1 - std::cos(2 * s)), 0.3 * (1 - std::cos(1.5 * s)), 0.05 * (1 - std::cos(3 * s)))};
  }
  static Vec3 velocity(double s) { return {std::sin(2 * s), 0.45 * std::sin(1.5 * s), 0.15 * std::sin(3 * s)}; }
  static ImuSample imu(double s, const Vec3& b_w, const Vec3& b_a) {
    const double yaw_rate = 0.52 * std::sin(1.3 * s), roll = 0.1 * (1 - std::cos(2 * s));
    const Vec3 rate =
        exp_so3(-roll * Vec3::UnitX()) * (yaw_rate * Vec3::UnitZ()) + 0.2 * std::sin(2 * s) * Vec3::UnitX();
    const Vec3 a(2 * std::cos(2 * s), 0.675 * std::cos(1.5 * s), 0.45 * std::cos(3 * s));
    return {0, rate + b_w, at(s).R.transpose() * (a + Vec3(0, 0, kStandardGravity)) + b_a};
  }
};

/// What the sensor sees of the room over 0.1 s of the swing.
struct SwingWindow : RoomWindow {
  SwingWindow(std::uint32_t k, const Vec3& b_w, const Vec3& b_a, std::uint32_t sequence)
      : RoomWindow(kRoomEpoch + k * kTenth, kTenth, TurningRoom{}, sequence) {
    for (TimedPoint& point : fresh) {
      const Vec3 d = Vec3(point.x, point.y, point.z).normalized();
      const Pose T = Swing::at(to_seconds(point.t - kRoomEpoch));
      const Vec3 p = wall_distance(T.p, T.R * d) * d;
      point.x = static_cast<float>(p.x());
      point.y = static_cast<float>(p.y());
      point.z = static_cast<float>(p.z());
    }
    for (ImuSample& sample : imu) {
      const TimeNs t = sample.t;
      sample = Swing::imu(to_seconds(t - kRoomEpoch), b_w, b_a);
      sample.t = t;
    }
  }
};

const std::string kExactPlanes = "residual: {type: point_to_plane, plane_threshold: 0.005}";

/// The estimator with `keys`, in the known room.
struct SplineFilter : Filter {
  explicit SplineFilter(const std::string& keys)
      : Filter({"estimator={type: spline_iekf, " + keys + ", " + kExactPlanes + "}"}) {
    build_map(1);
  }
};

}  // namespace

// eqs. SPL-4, SPL-8.
TEST_CASE("the recursive spline follows a swing without noise to millimetres, with and without IMU") {
  const bool imu = GENERATE(true, false);
  const double interval = GENERATE(0.01, 0.025);
  CAPTURE(imu, interval);
  SplineFilter filter("sigma: 0.02, acceleration_noise: 20, gyro_variance: 1e-4, acc_variance: 0.01, imu: " +
                      std::string(imu ? "true" : "false") + ", interval: " + std::to_string(interval));
  const Vec3 b_w(0.0012, -0.001, 0.0015), b_a(0.05, -0.04, 0.06);
  for (std::uint32_t k = 0; k < 40; ++k) {
    const SwingWindow room(k, b_w, b_a, k + 2);
    const Update& update = filter.update(room);
    CAPTURE(k);
    REQUIRE(update.accepted);
    CHECK(update.states.back().t == room.window.plan.end);
    CHECK(update.P.block<9, 9>(block::b_w, block::b_w).isZero() == !imu);
    if (k < 5) continue;
    for (const NavState& state : update.states) {
      const double s = to_seconds(state.t - kRoomEpoch);
      REQUIRE((state.p - Swing::at(s).p).norm() < 0.003);
      REQUIRE(log_so3(state.R.transpose() * Swing::at(s).R).norm() < 0.002);
      REQUIRE((state.v - Swing::velocity(s)).norm() < 0.15);
    }
    for (const WorldPoint& p : update.map_points) {
      REQUIRE(std::abs((p.p_W.cwiseAbs() - Vec3(4, 3, 1.5)).maxCoeff()) < 0.01);
    }
  }
  const NavState& end = filter.estimator->state();
  if (imu) CHECK((end.b_w - b_w).norm() < 0.0008);
  if (!imu) CHECK(end.b_w.norm() + end.b_a.norm() == 0.0);
}

TEST_CASE("the recursive spline says how well it knows its pose") {
  SplineFilter filter("sigma: 0.02");
  double squares = 0;
  int count = 0;
  for (std::uint32_t k = 0; k < 20; ++k) {
    const Update& update = filter.update(SwingWindow(k, Vec3::Zero(), Vec3::Zero(), k + 2));
    REQUIRE(update.accepted);
    const Mat3 P = update.P.block<3, 3>(block::p, block::p);
    CHECK(P.trace() < 3 * 0.02 * 0.02);
    const Vec3 off = update.state.p - Swing::at(to_seconds(update.state.t - kRoomEpoch)).p;
    squares += off.dot(P.inverse() * off) / 3;
    ++count;
    CHECK(update.nis > 0);
    CHECK(update.nis < 1.5);
  }
  CHECK(squares / count < 3);  // the data have no noise: no more than what is claimed
}

TEST_CASE("the recursive spline goes on through a gap of the IMU, and ignores readings at the end of the range") {
  const bool gap = GENERATE(true, false);
  CAPTURE(gap);
  SplineFilter filter("sigma: 0.02, acceleration_noise: 20");
  for (std::uint32_t k = 0; k < 20; ++k) {
    SwingWindow room(k, Vec3::Zero(), Vec3::Zero(), k + 2);
    if (k >= 8 && k < 12) {
      if (gap) room.window.imu = {};
      if (!gap) {
        for (ImuSample& sample : room.imu) {
          sample.gyro.y() = 35;
          sample.acc.z() = -30;
          sample.faults = imu_fault::clipped(false, 1) | imu_fault::clipped(true, 2);
        }
      }
    }
    const Update& update = filter.update(room);
    CAPTURE(k);
    REQUIRE(update.accepted);
    if (k >= 5) CHECK((update.state.p - Swing::at(to_seconds(update.state.t - kRoomEpoch)).p).norm() < 0.005);
  }
}

TEST_CASE("the recursive spline: no points, points that are not numbers, and a window over a long gap") {
  const bool imu = GENERATE(true, false);
  CAPTURE(imu);
  SplineFilter filter("imu: " + std::string(imu ? "true" : "false"));
  for (std::uint32_t k = 0; k < 3; ++k)
    REQUIRE(filter.update(SwingWindow(k, Vec3::Zero(), Vec3::Zero(), k + 2)).accepted);

  SwingWindow empty(3, Vec3::Zero(), Vec3::Zero(), 5);
  empty.window.fresh = {};
  const Update& unseen = filter.update(empty);
  CHECK(unseen.status == UpdateStatus::few_matches);
  CHECK(unseen.map_points.empty());
  CHECK(unseen.state.t == empty.window.plan.end);
  CHECK((unseen.state.p - Swing::at(0.4).p).norm() < 0.03);

  SwingWindow bad(4, Vec3::Zero(), Vec3::Zero(), 6);
  for (std::size_t i = 0; i < bad.fresh.size(); i += 10) bad.fresh[i].x = std::numeric_limits<float>::quiet_NaN();
  const Update& seen = filter.update(bad);
  CHECK(seen.accepted);
  CHECK(seen.P.allFinite());
  CHECK((seen.state.p - Swing::at(0.5).p).norm() < 0.03);

  RoomWindow late(kRoomEpoch + 5 * kTenth, 1000 * kSecond, Pose{}, 7, 0);
  late.window.imu = {};
  const Update& after = filter.update(late);
  CHECK_FALSE(after.accepted);
  CHECK_FALSE(after.insert);
  CHECK(after.state.t == late.window.plan.end);
  CHECK(after.state.p.allFinite());
  CHECK(after.P.allFinite());
}

TEST_CASE("the recursive spline takes all points of an update, however few it takes at a time") {
  NavState ends[2];
  for (const int batch : {7, 500}) {
    SplineFilter filter("sigma: 0.02, batch_points: " + std::to_string(batch));
    for (std::uint32_t k = 0; k < 6; ++k) {
      const Update& update = filter.update(SwingWindow(k, Vec3::Zero(), Vec3::Zero(), k + 2));
      REQUIRE(update.accepted);
      CHECK(update.fresh_matches > 2000);
    }
    ends[batch == 7 ? 0 : 1] = filter.estimator->state();
  }
  CHECK((ends[0].p - ends[1].p).norm() < 0.002);
  CHECK((ends[0].v - ends[1].v).norm() < 0.05);
}

// eqs. INI-3, SPL-10.
TEST_CASE("the recursive spline finds the velocity of a start in motion") {
  const TurningRoom motion{.rate = Vec3(0, 0, 0.2), .drift = Vec3(0.8, -0.3, 0)};
  Filter filter({"estimator={type: spline_iekf}"});
  filter.initial = start_in_motion();
  filter.estimator->reset(filter.initial);
  for (std::uint32_t k = 0; k < 12; ++k) {
    const RoomWindow room(kRoomEpoch + k * kTenth, kTenth, motion, k + 1);
    const Update& update = filter.update(room);
    CHECK(update.restart_map == (k >= 1 && k < 6));
    if (update.restart_map) filter.map->clear();
    filter.map->insert(update.map_points, k + 1);
  }
  CHECK((filter.estimator->state().v - motion.drift).norm() < 0.1);
}
