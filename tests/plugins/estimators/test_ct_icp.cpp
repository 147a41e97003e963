// Elastic registration: a window whose motion differs from the one before, its priors, and velocity and biases with an
// IMU.
#include <catch2/catch.hpp>
#include <limits>

#include "plugins/estimators/room_filter.hpp"

using namespace aslio;
using namespace aslio::test;

namespace {

const std::string kLidar = "estimator={type: ct_icp, prediction: constant_velocity}";
const std::string kImu = "estimator={type: ct_icp, prediction: imu}";

double turn(const Pose& a, const Pose& b) { return log_so3(a.R.transpose() * b.R).norm(); }

/// Largest distance of the path from the truth within the last window.
double off_the_path(const Update& update, const TurningRoom& motion, TimeNs begin) {
  double worst = 0;
  for (TimeNs t = begin; t <= begin + kTenth; t += kTenth / 10) {
    worst = std::max(worst, (update.trajectory->pose(t).p - motion.at(t).p).norm());
    worst = std::max(worst, turn(update.trajectory->pose(t), motion.at(t)));
  }
  return worst;
}

}  // namespace

TEST_CASE("ct_icp finds the motion inside a window that nothing foretold") {  // eq. CT-3
  const TurningRoom motion{.rate = Vec3(0.2, -0.1, 0.6), .drift = Vec3(0.8, -0.4, 0.1)};
  Filter elastic({kLidar, "estimator.max_iterations=10"}),
      stiff({kLidar, "estimator.displacement=1e6", "estimator.turn=1e6"});
  for (Filter* filter : {&elastic, &stiff}) filter->build_map(1);
  const Update& update = elastic.update(RoomWindow(kRoomEpoch, kTenth, motion, 2));
  REQUIRE(update.accepted);
  CHECK(update.status == UpdateStatus::ok);
  CHECK(update.trajectory->dof() == 12);
  CHECK(off_the_path(update, motion, kRoomEpoch) < 0.005);
  // Held to the prediction, which says that the sensor rests, it cannot.
  const Update& held = stiff.update(RoomWindow(kRoomEpoch, kTenth, motion, 2));
  CHECK(off_the_path(held, motion, kRoomEpoch) > 0.03);
  CHECK((held.trajectory->pose(kRoomEpoch).p - held.trajectory->pose(kRoomEpoch + kTenth).p).norm() < 1e-3);
}

TEST_CASE("ct_icp: priors hold the begin where the window before ended") {  // eq. CT-3
  // The sensor rests 5 cm and 2 degrees from where it was thought to be: the whole window moves, unless its begin is
  // held.
  const Pose truth{exp_so3(Vec3(0, 0, 0.03)), Vec3(0.05, -0.03, 0)};
  Filter open({kLidar, "estimator.max_iterations=10"});
  Filter held({kLidar, "estimator.max_iterations=10", "estimator.location=1e6", "estimator.orientation=1e6"});
  for (Filter* filter : {&open, &held}) filter->build_map(1);
  const RoomWindow room(kRoomEpoch, kTenth, truth, 2);
  CHECK((open.update(room).state.p - truth.p).norm() < 0.01);
  const Update& first = held.update(room);
  CHECK(first.trajectory->pose(kRoomEpoch).p.norm() < 1e-3);
  CHECK(turn(first.trajectory->pose(kRoomEpoch), Pose{}) < 1e-3);
}

TEST_CASE("ct_icp with an IMU learns velocity and gyro bias from the poses it finds") {  // eq. CT-4
  const Vec3 rate(0, 0, 0.5), bias(0.01, -0.02, 0.015);
  const TurningRoom motion{.rate = rate, .drift = Vec3(0.5, -0.3, 0)};
  Filter filter({kImu, "estimator.noise=physical"}, 3.0);
  filter.build_map(1);
  CHECK(filter.estimator->uses_imu());
  for (std::uint32_t k = 0; k < 30; ++k) {
    const TimeNs end = kRoomEpoch + (k + 1) * kTenth;
    RoomWindow room(end - kTenth, kTenth, motion, k + 2);
    for (ImuSample& sample : room.imu) sample.gyro += bias;
    const Update& update = filter.update(room);
    REQUIRE(update.accepted);
    if (k < 5) continue;
    CHECK((update.state.p - motion.at(end).p).norm() < 0.01);
    CHECK((update.state.v - motion.drift).norm() < 0.06);
  }
  CHECK((filter.estimator->state().b_w - bias).norm() < 0.004);
}

TEST_CASE("ct_icp: history points hang on the end, and a window of other points with them") {
  const Pose truth{exp_so3(Vec3(0, 0, 0.01)), Vec3(0.03, 0.02, 0)};
  std::vector<HistoryPoint> points;
  for (const WorldPoint& p : wall_points(500)) {
    points.push_back({.p_W = p.p_W, .t = kRoomEpoch, .range = 3.0F, .sequence = 1});
  }
  Filter without({kLidar}), with({kLidar});
  for (Filter* filter : {&without, &with}) filter->build_map(1);
  const RoomWindow room(kRoomEpoch, kTenth, truth, 6);
  const Update& plain = without.update(room);
  const Update& helped = with.update(room, {.points = points, .max_stamp = 5});
  CHECK(plain.history_matches == 0);
  CHECK(helped.history_points == 500);
  CHECK(helped.history_matches > 300);
  // They lie where the prior is right: they pull towards it.
  CHECK(helped.state.p.norm() < plain.state.p.norm());
  Filter young({kLidar});
  young.build_map(1);
  CHECK(young.update(room, {.points = points, .max_stamp = 0}).history_matches == 0);
}

TEST_CASE("ct_icp: impossible IMU data does not outlive its window") {
  Filter filter({kImu});
  filter.build_map(1);
  RoomWindow broken(kRoomEpoch, kTenth, Pose{}, 2);
  broken.imu[3].acc.x() = std::numeric_limits<double>::infinity();
  const Update& update = filter.update(broken);
  CHECK(update.status == UpdateStatus::non_finite);
  CHECK_FALSE(update.insert);
  CHECK(update.state.p.allFinite());
  CHECK(filter.update(RoomWindow(kRoomEpoch + kTenth, kTenth, Pose{}, 3)).accepted);
}

TEST_CASE("with IMU: after a start in motion the map begins anew until the velocity is found") {  // eq. INI-3
  const TurningRoom motion{.drift = Vec3(1.0, 0.5, 0)};
  for (const std::string& type : {kImu, std::string("estimator={type: smoother}")}) {
    CAPTURE(type);
    Filter filter({type});
    filter.build_map(1);
    const InitialState initial = start_in_motion();
    filter.estimator->reset(initial);
    for (std::uint32_t k = 0; k < 8; ++k) {
      const TimeNs end = kRoomEpoch + (k + 1) * kTenth;
      const Update& update = filter.update(RoomWindow(end - kTenth, kTenth, motion, k + 2));
      CAPTURE(k);
      REQUIRE(update.accepted);
      CHECK(update.restart_map == (k < 5));
      if (k < 5) CHECK(update.state.b_w == initial.state.b_w);
      if (k >= 3) CHECK((update.state.v - motion.drift).norm() < 0.1);
    }
    CHECK(filter.estimator->state().b_w != initial.state.b_w);
  }
}
