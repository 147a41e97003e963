// The smoother: motion inside a window that the IMU tells wrongly, slices that stay while they are in the window, and
// points that move with them.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "plugins/estimators/room_filter.hpp"

using namespace aslio;
using namespace aslio::test;

namespace {

const std::string kSmoother = "estimator={type: smoother, noise: physical}";

double off_the_path(const Update& update, const TurningRoom& motion, const WindowPlan& plan) {
  double worst = 0;
  for (TimeNs t = plan.fresh_begin; t <= plan.end; t += (plan.end - plan.fresh_begin) / 20) {
    const Pose found = update.trajectory->pose(t), truth = motion.at(t);
    worst = std::max({worst, (found.p - truth.p).norm(), log_so3(found.R.transpose() * truth.R).norm()});
  }
  return worst;
}

double off_the_walls(const std::vector<Vec3>& points) {
  double sum = 0;
  for (const Vec3& p : points) {
    const double inside = std::min({4 - std::abs(p.x()), 3 - std::abs(p.y()), 1.5 - std::abs(p.z())});
    sum += std::abs(inside);
  }
  return sum / static_cast<double>(points.size());
}

}  // namespace

TEST_CASE(
    "smoother: every part of a window has a state, and the path between them is the truth") {  // eqs. SMO-1, SMO-2
  const TurningRoom motion{.rate = Vec3(0.5, -0.4, 2.0), .gyro_error = Vec3(0, 0, 0.04), .drift = Vec3(0.6, 0.2, 0)};
  for (const int parts : {1, 3, 7}) {
    Filter filter({kSmoother, "estimator.noise=fastlio"}, 3.0);
    filter.build_map(1);
    CAPTURE(parts);
    for (std::uint32_t k = 0; k < 8; ++k) {
      RoomWindow room(kRoomEpoch + k * kTenth, kTenth, motion, k + 2);
      cut(room, parts);
      const Update& update = filter.update(room);
      REQUIRE(update.accepted);
      CHECK(update.trajectory->dof() == 6 * (parts + 1));
      CHECK(update.states.size() >= 20);
      for (std::size_t i = 1; i < update.states.size(); ++i) CHECK(update.states[i].t > update.states[i - 1].t);
      if (k >= 2) CHECK(off_the_path(update, motion, room.window.plan) < 0.004);
    }
  }
}

TEST_CASE("smoother: slices count while they reach into the window, and not after") {  // eq. SMO-4
  const TurningRoom motion{.rate = Vec3(0, 0, 0.5), .drift = Vec3(0.4, 0.2, 0)};
  Filter filter({kSmoother}, 3.0);
  filter.build_map(1);
  constexpr TimeNs step = kTenth / 4;
  for (std::uint32_t k = 0; k < 10; ++k) {
    RoomWindow room(kRoomEpoch + k * step, step, motion, k + 2, 800);
    room.window.plan.history_begin = std::max(kRoomEpoch, room.window.plan.end - kTenth);
    const Update& update = filter.update(room);
    REQUIRE(update.accepted);
    const std::uint32_t kept = std::min(k, 3U);
    CHECK(update.history_matches <= kept * 800);
    CHECK(update.history_matches >= kept * 700);
    if (k >= 4) CHECK((update.state.p - motion.at(update.state.t).p).norm() < 0.004);
  }
  // A window without history: none of them is left.
  CHECK(filter.update(RoomWindow(kRoomEpoch + 10 * step, step, motion, 12)).history_matches == 0);
}

TEST_CASE("smoother: slices of earlier updates match nothing that entered the map with them or later") {  // eq. HIS-1
  const TurningRoom motion{.rate = Vec3(0, 0, 0.5), .drift = Vec3(0.4, 0.2, 0)};
  constexpr TimeNs step = kTenth / 4;
  for (const std::uint32_t stamp : {1U, 2U, 4U}) {
    CAPTURE(stamp);
    Filter filter({kSmoother}, 3.0);
    filter.build_map(stamp);  // as if inserted at that update
    for (std::uint32_t k = 2; k < 10; ++k) {
      RoomWindow room(kRoomEpoch + (k - 2) * step, step, motion, k, 800);
      // Half of the slice of update k - 2 has left; the rest is still matched, so that its stamp is too young.
      room.window.plan.history_begin = std::max(kRoomEpoch, room.window.plan.fresh_begin - 3 * step / 2);
      const Update& update = filter.update(room);
      CAPTURE(k);
      REQUIRE(update.accepted);
      CHECK(update.fresh_matches > 700);
      const std::uint32_t oldest = std::max(2U, k - 2);
      const std::uint32_t kept = k - oldest;
      CHECK(update.history_matches <= kept * 800);
      CHECK((update.history_matches > kept * 700) == (kept > 0 && stamp < oldest));
      if (stamp >= oldest) CHECK(update.history_matches == 0);
    }
  }
}

TEST_CASE("smoother: points go where the slices that measured them go, until they leave") {
  const TurningRoom motion{.rate = Vec3(0, 0, 0.5), .drift = Vec3(1.5, -0.8, 0)};
  // A pose is not sure of itself after one look: later ones move it.
  Filter filter({kSmoother, "estimator.sigma=0.3", "estimator.max_iterations=2", "estimator.min_matches=1"}, 3.0);
  filter.build_map(1);
  RoomWindow first(kRoomEpoch, kTenth / 4, motion, 2, 60);
  const Update& update = filter.update(first);
  REQUIRE(update.accepted);
  REQUIRE(update.revision != nullptr);
  const PointRevision* revision = update.revision;
  const std::vector<WorldPoint> points(update.map_points.begin(), update.map_points.end());
  const auto places = [&] {
    std::vector<Vec3> out;
    for (const WorldPoint& point : points) out.push_back(revision->place(point));
    return out;
  };
  const std::vector<Vec3> at_once = places();
  for (std::size_t i = 0; i < points.size(); ++i) REQUIRE((at_once[i] - points[i].p_W).norm() < 1e-9);
  RoomWindow second(kRoomEpoch + kTenth / 4, kTenth / 4, motion, 3, 3000);
  second.window.plan.history_begin = kRoomEpoch;
  REQUIRE(filter.update(second).accepted);
  const std::vector<Vec3> smoothed = places();
  CAPTURE(off_the_walls(at_once), off_the_walls(smoothed));
  CHECK(off_the_walls(smoothed) < 0.7 * off_the_walls(at_once));
  RoomWindow third(kRoomEpoch + kTenth / 2, kTenth / 4, motion, 4, 3000);
  REQUIRE(filter.update(third).accepted);
  const std::vector<Vec3> left = places();
  for (std::size_t i = 0; i < points.size(); ++i) REQUIRE(left[i] == points[i].p_W);
}

TEST_CASE("smoother: a refused step ends the chain, and the next one goes on from the prediction") {
  const TurningRoom motion{.rate = Vec3(0, 0, 0.5)};
  Filter filter({kSmoother});
  filter.build_map(1);
  constexpr TimeNs step = kTenth / 4;
  for (std::uint32_t k = 0; k < 6; ++k) {
    RoomWindow room(kRoomEpoch + k * step, step, motion, k + 2, k == 3 ? 2 : 800);
    room.window.plan.history_begin = kRoomEpoch;
    const Update& update = filter.update(room);
    CHECK(update.accepted == (k != 3));
    CHECK((update.history_matches > 0) == (k == 1 || k == 2 || k == 3 || k == 5));  // told of a refused step, too
    CHECK((update.state.p - motion.at(update.state.t).p).norm() < 0.005);
    CHECK(update.P.allFinite());
  }
}

TEST_CASE("smoother: impossible IMU data does not outlive its window") {
  for (const double reading : {std::numeric_limits<double>::infinity(), 1e200}) {
    Filter filter({kSmoother});
    filter.build_map(1);
    REQUIRE(filter.update(RoomWindow(kRoomEpoch, kTenth, Pose{}, 2)).accepted);
    RoomWindow broken(kRoomEpoch + kTenth, kTenth, Pose{}, 3);
    broken.window.plan.history_begin = kRoomEpoch;
    broken.imu[3].acc.x() = reading;
    const Update& update = filter.update(broken);
    CHECK_FALSE(update.accepted);
    CHECK_FALSE(update.insert);
    CHECK(update.P.allFinite());
    for (const WorldPoint& point : update.map_points) REQUIRE(point.p_W.allFinite() == update.state.p.allFinite());
    if (std::isfinite(reading)) continue;
    CHECK(update.status == UpdateStatus::non_finite);
    CHECK(filter.update(RoomWindow(kRoomEpoch + 2 * kTenth, kTenth, Pose{}, 4)).accepted);
  }
}

TEST_CASE("smoother: matches are counted, not the rows of their residuals, also when they are too few") {
  Filter filter({"estimator={type: smoother, residual: {type: point_to_point}, min_matches: 1000}"});
  filter.build_map(1);
  const Update& found = filter.update(RoomWindow(kRoomEpoch, kTenth, Pose{}, 2, 2000));
  REQUIRE(found.accepted);
  const auto accepted = static_cast<std::uint32_t>(
      std::count_if(found.matches.begin(), found.matches.end(), [](const MatchRecord& m) { return m.accepted; }));
  CHECK(found.fresh_matches == Approx(accepted).epsilon(0.01));  // before and after the last step
  CHECK(found.fresh_matches <= 2000);
  double squares = 0;
  for (const MatchRecord& m : found.matches)
    if (m.accepted) squares += static_cast<double>(m.residual) * static_cast<double>(m.residual);
  CHECK(found.residual_rms == Approx(std::sqrt(squares / accepted)).epsilon(1e-4));

  const Update& few = filter.update(RoomWindow(kRoomEpoch + kTenth, kTenth, Pose{}, 3, 900));
  CHECK(few.status == UpdateStatus::few_matches);  // of 2700 rows
  CHECK(few.fresh_matches > 0);
  CHECK(few.fresh_matches <= 900);
}

TEST_CASE("smoother: goes on from the velocity and biases that it is told, whatever was before") {
  for (const bool refused_before : {false, true}) {
    CAPTURE(refused_before);
    Filter filter({kSmoother});
    filter.build_map(1);
    REQUIRE(filter.update(RoomWindow(kRoomEpoch, kTenth, Pose{}, 2)).accepted);
    if (refused_before) CHECK_FALSE(filter.update(RoomWindow(kRoomEpoch + kTenth, kTenth, Pose{}, 3, 2)).accepted);
    const TimeNs begin = kRoomEpoch + (refused_before ? 2 : 1) * kTenth;
    const NavState before = filter.estimator->state();
    InertialEstimate told{before.v + Vec3(0.3, 0, 0), Vec3(0.01, 0, 0), Vec3(0, 0.1, 0)};
    filter.estimator->adopt(told);
    RoomWindow room(begin, kTenth, Pose{}, 4);
    room.window.plan.history_begin = begin - kTenth / 2;
    const NavState ahead = filter.estimator->predict(room.imu);
    const Update& update = filter.update(room);
    CHECK((update.prior.p - ahead.p).norm() < 1e-12);
    CHECK((update.prior.v - ahead.v).norm() < 1e-12);
    CHECK(update.prior.b_w == told.b_w);
    REQUIRE(update.accepted);
    CHECK(update.history_matches == 0);  // of slices that had another velocity
  }
}
