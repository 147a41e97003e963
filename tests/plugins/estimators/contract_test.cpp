// What every registered estimator owes the loop, with its defaults.
#include <catch2/catch.hpp>

#include "plugins/estimators/room_filter.hpp"
#include "plugins/estimators/watched_map.hpp"

using namespace aslio;
using namespace aslio::test;

namespace {

std::vector<std::string> estimators() { return under_test(stages_under_test(), Estimator::family); }

Filter made(const std::string& type) { return Filter({"estimator=" + type}); }

void check_result(const Update& update, const RoomWindow& room) {
  CHECK(update.state.t == room.window.plan.end);
  CHECK(update.matches.size() == update.match_points.size());
  for (const MatchRecord& match : update.matches) REQUIRE((match.matched || !match.accepted));
  REQUIRE(update.trajectory != nullptr);
  CHECK((update.trajectory->pose(update.state.t).p - update.state.p).norm() < 1e-9);
  REQUIRE_FALSE(update.states.empty());
  CHECK(update.states.back().p == update.state.p);
  CHECK(update.P.allFinite());
  for (const WorldPoint& point : update.map_points) REQUIRE(point.p_W.allFinite());
}

/// Largest difference between the columns of the Jacobian at t and central differences.
double slope_error(const TrajectoryModel& trajectory, TimeNs t) {
  constexpr double step = 1e-5;
  Eigen::MatrixXd jacobian;
  trajectory.jacobian(t, jacobian);
  REQUIRE(jacobian.rows() == 6);
  REQUIRE(jacobian.cols() == trajectory.dof());
  const Pose here = trajectory.pose(t);
  const Eigen::VectorXd still = Eigen::VectorXd::Zero(trajectory.dof());
  CHECK((trajectory.moved(t, still).p - here.p).norm() < 1e-12);
  CHECK((trajectory.moved(t, still).R - here.R).norm() < 1e-12);
  double worst = 0;
  for (int i = 0; i < trajectory.dof(); ++i) {
    Eigen::VectorXd xi = still;
    xi[i] = step;
    const Pose up = trajectory.moved(t, xi), down = trajectory.moved(t, -xi);
    Vec6 slope;
    slope << log_so3(here.R.transpose() * up.R) - log_so3(here.R.transpose() * down.R), up.p - down.p;
    worst = std::max(worst, (jacobian.col(i) - slope / (2 * step)).norm());
  }
  return worst;
}

}  // namespace

TEST_CASE("every estimator: with an empty map it waits, and places its points at the prior") {
  for (const std::string& type : estimators()) {
    CAPTURE(type);
    Filter filter = made(type);
    const RoomWindow room(kRoomEpoch, kTenth, Pose{}, 1);
    const Update& update = filter.update(room);
    CHECK(update.status == UpdateStatus::initialising);
    CHECK_FALSE(update.accepted);
    CHECK(update.insert);
    CHECK(update.map_points.size() == 1000);
    CHECK((update.state.p - update.prior.p).norm() == 0.0);
    check_result(update, room);
  }
}

// What maps need that tell the faces of a wall apart (eq. MAP-4).
TEST_CASE(
    "every estimator searches from where the sensor is, and tells of its points in which direction they are seen") {
  for (const std::string& type : estimators()) {
    CAPTURE(type);
    Filter filter = made(type);
    filter.build_map(1);
    WatchedMap map(*filter.map);
    // 13 cm in all: far more than the limits below leave to one that looks from the origin.
    const TurningRoom motion{.rate = Vec3(0, 0, 0.5), .drift = Vec3(0.4, 0.2, 0)};
    for (std::uint32_t k = 0; k < 3; ++k) {
      CAPTURE(k);
      const RoomWindow room(kRoomEpoch + k * kTenth, kTenth, motion, k + 2);
      const Update& update = filter.estimator->update(room.window, {}, {filter.samplers, map, filter.history});
      REQUIRE_FALSE(update.map_points.empty());
      for (const WorldPoint& point : update.map_points) {
        const Vec3 seen = (point.p_W - update.state.p).normalized();
        // 1 deg in the packing, and 4 cm of motion within the window at 1.5 m.
        REQUIRE((point.view.vector().cast<double>() - seen).norm() < 0.05);
      }
      CHECK((map.searches > 0 || filter.estimator->uses_features()));
      for (const auto& viewpoint : map.viewpoints) REQUIRE(viewpoint.has_value());
      if (k > 0 && !map.viewpoints.empty()) CHECK((*map.viewpoints.back() - update.state.p).norm() < 0.05);
      map.viewpoints.clear();
      map.searches = 0;
    }
  }
}

TEST_CASE("every estimator follows an even motion in a known room, with either map of points") {
  const TurningRoom motion{.rate = Vec3(0, 0, 0.5), .drift = Vec3(0.4, 0.2, 0)};
  const std::vector<std::string> types = estimators();
  for (std::size_t i = 0; i < 2 * types.size(); ++i) {
    const std::string& type = types[i / 2];
    const std::string map = i % 2 == 0 ? "map={type: voxel_hash}" : "map={type: ikd_tree}";
    CAPTURE(type, map);
    Filter filter({"estimator=" + type, map}, 3.0);
    filter.build_map(1);
    for (std::uint32_t k = 0; k < 15; ++k) {
      const TimeNs end = kRoomEpoch + (k + 1) * kTenth;
      const RoomWindow room(end - kTenth, kTenth, motion, k + 2);
      const Update& update = filter.update(room);
      CAPTURE(k);
      REQUIRE(update.accepted);
      check_result(update, room);
      if (k < 5) continue;
      CHECK((update.state.p - motion.at(end).p).norm() < 0.03);
      CHECK(log_so3(update.state.R.transpose() * motion.at(end).R).norm() < 0.01);
      CHECK((update.state.v - motion.drift).norm() < 0.3);
    }
  }
}

TEST_CASE("every estimator: same windows, same bits for any number of threads") {
  const TurningRoom motion{.rate = Vec3(0, 0, 0.5), .drift = Vec3(0.4, 0.2, 0)};
  for (const std::string& type : estimators()) {
    CAPTURE(type);
    std::vector<std::uint64_t> digests[3];
    for (const int threads : {1, 2, 3}) {
      Filter filter({"estimator=" + type}, 0.05, false, Vec3(0, 0, -kStandardGravity), threads);
      filter.build_map(1);
      for (std::uint32_t k = 0; k < 4; ++k) {
        const RoomWindow room(kRoomEpoch + k * kTenth, kTenth, motion, k + 2);
        digests[threads - 1].push_back(pipeline::state_digest(filter.update(room).state));
      }
    }
    CHECK(digests[0] == digests[1]);
    CHECK(digests[0] == digests[2]);
  }
}

TEST_CASE("every estimator: soon after an accepted update, points that match nothing may enter the map") {
  // Unseen space can only become known by inserting it (eq. IESKF-8).
  const TurningRoom motion{.rate = Vec3(0, 0, 0.5)};
  for (const std::string& type : estimators()) {
    CAPTURE(type);
    Filter filter = made(type);
    filter.build_map(1);
    for (std::uint32_t k = 0; k < 5; ++k) {
      REQUIRE(filter.update(RoomWindow(kRoomEpoch + k * kTenth, kTenth, motion, k + 2)).accepted);
    }
    const Update& unseen = filter.update(RoomWindow(kRoomEpoch + 5 * kTenth, kTenth, motion, 7, 2));
    CHECK(unseen.status == UpdateStatus::few_matches);
    CHECK(unseen.insert);
  }
}

TEST_CASE("every estimator goes on from a velocity and biases that it is told") {
  const TurningRoom motion{.rate = Vec3(0, 0, 0.5)};
  for (const std::string& type : estimators()) {
    CAPTURE(type);
    Filter filter = made(type);
    filter.build_map(1);
    for (std::uint32_t k = 0; k < 3; ++k) filter.update(RoomWindow(kRoomEpoch + k * kTenth, kTenth, motion, k + 2));
    const RoomWindow next(kRoomEpoch + 3 * kTenth, kTenth, motion, 5);
    const NavState before = filter.estimator->state(), ahead = filter.estimator->predict(next.imu);
    const InertialEstimate told{before.v + Vec3(0.2, 0, 0), before.b_w + Vec3(0, 0, 0.01), before.b_a};
    filter.estimator->adopt(told);
    const NavState& now = filter.estimator->state();
    CHECK(now.v == told.v);
    CHECK(now.b_w == told.b_w);
    CHECK(now.p == before.p);
    CHECK(now.R == before.R);
    if (!filter.estimator->uses_imu()) continue;
    const NavState then = filter.estimator->predict(next.imu);
    CHECK((then.p - ahead.p - Vec3(0.02, 0, 0)).norm() < 1e-3);
    CHECK(filter.update(next).accepted);
  }
}

TEST_CASE("every estimator: same windows, same bits, a refused step keeps the prior, predict changes nothing") {
  const TurningRoom motion{.rate = Vec3(0, 0, 0.5)};
  for (const std::string& type : estimators()) {
    CAPTURE(type);
    std::vector<std::uint64_t> digests[2];
    for (auto& run : digests) {
      Filter filter = made(type);
      filter.build_map(1);
      for (std::uint32_t k = 0; k < 4; ++k) {
        const RoomWindow room(kRoomEpoch + k * kTenth, kTenth, motion, k + 2);
        const NavState before = filter.estimator->state();
        filter.estimator->predict(room.imu);
        CHECK(pipeline::state_digest(filter.estimator->state()) == pipeline::state_digest(before));
        run.push_back(pipeline::state_digest(filter.update(room).state));
      }
      const RoomWindow thin(kRoomEpoch + 4 * kTenth, kTenth, motion, 6, 2);
      const Update& refused = filter.update(thin);
      CHECK_FALSE(refused.accepted);
      CHECK(refused.status == UpdateStatus::few_matches);
      CHECK(refused.state.p == refused.prior.p);
      CHECK(refused.state.R == refused.prior.R);
    }
    CHECK(digests[0] == digests[1]);
  }
}

TEST_CASE("every estimator: reset() begins anew, at rest or in motion, whatever was before") {
  const TurningRoom motion{.rate = Vec3(0, 0, 0.5), .drift = Vec3(0.4, 0.2, 0)};
  const auto digests = [&](Filter& filter) {
    std::vector<std::uint64_t> out;
    for (std::uint32_t k = 0; k < 8; ++k) {
      const Update& update = filter.update(RoomWindow(kRoomEpoch + k * kTenth, kTenth, motion, k + 2));
      out.push_back(pipeline::state_digest(update.state));
      out.push_back(std::hash<double>{}(update.P.trace()));
      if (k == 7) CHECK(update.accepted);
    }
    return out;
  };
  for (const std::string& type : estimators()) {
    for (const InitialMode mode : {InitialMode::static_start, InitialMode::dynamic_start}) {
      CAPTURE(type, mode == InitialMode::static_start);
      Filter once = made(type), again = made(type);
      for (Filter* filter : {&once, &again}) {
        filter->build_map(1);
        filter->initial.mode = mode;
        filter->estimator->reset(filter->initial);
      }
      const TurningRoom other{.rate = Vec3(0, 0.1, -0.3), .drift = Vec3(-0.3, 0.1, 0)};
      for (std::uint32_t k = 0; k < 6; ++k) again.update(RoomWindow(kRoomEpoch + k * kTenth, kTenth, other, k + 2));
      CHECK_FALSE(again.update(RoomWindow(kRoomEpoch + 6 * kTenth, kTenth, other, 8, 2)).accepted);
      again.estimator->reset(again.initial);
      CHECK(digests(again) == digests(once));
    }
  }
}

TEST_CASE("every estimator: the Jacobian of its trajectory agrees with central differences all over a window") {
  const TurningRoom motion{.rate = Vec3(0.3, -0.2, 0.8), .drift = Vec3(0.4, 0.2, 0)};
  for (const std::string& type : estimators()) {
    CAPTURE(type);
    Filter filter = made(type);
    filter.build_map(1);
    // The second window: in the first there is hardly a correction that could be spread over it.
    filter.update(RoomWindow(kRoomEpoch, kTenth, motion, 2));
    const RoomWindow room(kRoomEpoch + kTenth, kTenth, motion, 3);
    const Update& update = filter.update(room);
    REQUIRE(update.accepted);
    const TrajectoryModel& trajectory = *update.trajectory;
    for (const TimeNs after : {TimeNs{1}, kTenth / 7, kTenth / 2, 9 * kTenth / 10, kTenth}) {
      CAPTURE(after);
      CHECK(slope_error(trajectory, kRoomEpoch + kTenth + after) < 1e-6);
    }
    Eigen::MatrixXd jacobian;
    trajectory.jacobian(room.window.plan.end, jacobian);
    // The last six unknowns are the pose at the end.
    CHECK((jacobian.rightCols<6>() - Mat6::Identity()).norm() < 1e-9);
  }
}
