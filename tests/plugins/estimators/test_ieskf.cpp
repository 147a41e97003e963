// The filter over whole windows: a room at rest, with and without history, with nothing to match, with impossible IMU
// data.
#include <catch2/catch.hpp>
#include <limits>
#include <map>
#include <span>

#include "plugins/estimators/room_filter.hpp"
#include "plugins/estimators/watched_map.hpp"

using namespace aslio;
using namespace aslio::test;

namespace {

std::vector<HistoryPoint> old_points(int count) {
  std::vector<HistoryPoint> out;
  for (const WorldPoint& p : wall_points(count)) {
    out.push_back({.p_W = p.p_W + Vec3(0.004, -0.003, 0.002),
                   .t = kRoomEpoch,
                   .range = static_cast<float>(p.p_W.norm()),
                   .sequence = 5});
  }
  return out;
}

double pose_trace(const StateMatrix& P) { return P.topLeftCorner<6, 6>().trace(); }

bool same_state(const NavState& a, const NavState& b) { return pipeline::state_digest(a) == pipeline::state_digest(b); }

}  // namespace

TEST_CASE("the filter finds the pose from which the room was measured") {
  Filter filter({}, 3.0);
  filter.build_map(1);
  const Pose truth{exp_so3(Vec3(0.002, -0.003, 0.004)), Vec3(0.05, -0.03, 0.02)};
  const Update& update = filter.update(RoomWindow(kRoomEpoch, kTenth, truth, 2));
  REQUIRE(update.status == UpdateStatus::ok);
  REQUIRE(update.accepted);
  CHECK((update.state.p - truth.p).norm() < 1e-3);
  CHECK(log_so3(update.state.R.transpose() * truth.R).norm() < 1e-3);
  CHECK(update.residual_rms < 0.012);  // planes across the edges of the room
  CHECK(update.fresh_matches > 700);
  CHECK(update.history_matches == 0);
  CHECK(update.prior.p.norm() < 1e-3);
  CHECK((update.trajectory->pose(kRoomEpoch + kTenth).p - update.state.p).norm() < 1e-12);
}

TEST_CASE("association: at every iteration, again on convergence, or once") {
  for (const std::string rule : {"every_iteration", "on_convergence", "once"}) {
    CAPTURE(rule);
    Filter filter({"estimator.association=" + rule, "estimator.max_iterations=10"}, 3.0);
    filter.build_map(1);
    WatchedMap map(*filter.map);
    const Pose truth{exp_so3(Vec3(0.02, -0.01, 0.03)), Vec3(0.15, -0.1, 0.1)};
    const RoomWindow room(kRoomEpoch, kTenth, truth, 2);
    const Update& update = filter.estimator->update(room.window, {}, {filter.samplers, map, filter.history});
    REQUIRE(update.accepted);
    CHECK(update.iterations > 1);
    if (rule == "every_iteration") CHECK(map.searches == update.iterations);
    if (rule == "once") CHECK(map.searches == 1);
    if (rule == "on_convergence") {
      CHECK(map.searches >= 2);
      CHECK(map.searches < update.iterations);
    }
    if (rule != "once") CHECK((update.state.p - truth.p).norm() < 2e-3);
  }
}

TEST_CASE("association on convergence: neighbours are searched for the last iteration where asked") {  // eq. IESKF-11
  const auto searches = [](const std::vector<std::string>& overrides) {
    std::vector<std::string> all{"estimator.association=on_convergence", "estimator.max_iterations=4"};
    all.insert(all.end(), overrides.begin(), overrides.end());
    Filter filter(all, 3.0);
    filter.build_map(1);
    WatchedMap map(*filter.map);
    const Pose truth{exp_so3(Vec3(0.02, -0.01, 0.03)), Vec3(0.15, -0.1, 0.1)};
    const RoomWindow room(kRoomEpoch, kTenth, truth, 2);
    REQUIRE(filter.estimator->update(room.window, {}, {filter.samplers, map, filter.history}).iterations == 4);
    return map.searches;
  };
  // Steps that never count as converged.
  const std::string strict = "estimator.converged_m=1e-12";
  CHECK(searches({strict}) == 1);
  CHECK(searches({strict, "estimator.search_last=true"}) == 2);
}

TEST_CASE("convergence of the state asks for short steps of the velocity, too") {  // eq. IESKF-11
  const auto iterations = [](const std::string& rule) {
    Filter filter({"estimator.association=every_iteration", "estimator.max_iterations=50",
                   "estimator.converged=" + rule, "estimator.converged_m=0.002"},
                  3.0);
    filter.build_map(1);
    const Pose truth{exp_so3(Vec3(0.02, -0.01, 0.03)), Vec3(0.15, -0.1, 0.1)};
    const Update& update = filter.update(RoomWindow(kRoomEpoch, kTenth, truth, 2));
    REQUIRE(update.accepted);
    return update.iterations;
  };
  // The velocity moves ten times as far as the position: it is what 0.1 s of it have moved.
  CHECK(iterations("state") > iterations("pose"));
}

TEST_CASE("what a gate has left out stays out until neighbours are searched again, where asked") {
  const auto matches = [](const std::string& association, const std::string& gate_again) {
    Filter filter({"estimator.association=" + association, "estimator.max_iterations=10",
                   "estimator.gate_again=" + gate_again, "estimator.residual.max_residual=0.1"},
                  3.0);
    filter.build_map(1);
    const Pose truth{exp_so3(Vec3(0.02, -0.01, 0.03)), Vec3(0.12, -0.08, 0.06)};
    const Update& update = filter.update(RoomWindow(kRoomEpoch, kTenth, truth, 2));
    REQUIRE(update.accepted);
    return update.fresh_matches;
  };
  CHECK(matches("once", "false") < matches("once", "true") - 50);
  CHECK(matches("every_iteration", "false") == matches("every_iteration", "true"));
}

TEST_CASE("the start has FAST-LIO2's variances where asked") {  // eq. INI-8
  const auto start = [](const std::string& rule) {
    Filter filter({"estimator.start_covariance=" + rule, "estimator.noise=physical", "estimator.gravity=s2"});
    return StateMatrix(filter.update(RoomWindow(kRoomEpoch, kTenth, Pose{}, 1)).P);  // over an empty map: propagated
  };
  const StateMatrix published = start("fastlio"), measured = start("measured");
  CHECK(published(block::v + 2, block::v + 2) == Approx(1.0).epsilon(0.02));  // level: what the tilt adds, too
  CHECK(published(block::theta, block::theta) == Approx(1.0).epsilon(0.02));
  CHECK(published(block::b_w, block::b_w) == Approx(1e-4).epsilon(0.02));
  CHECK(published(block::b_a, block::b_a) == Approx(1e-3).epsilon(0.02));
  CHECK(published(block::g, block::g) == Approx(1e-5 * kStandardGravity * kStandardGravity).epsilon(0.02));
  CHECK(published(block::g + 2, block::g + 2) == Approx(0.0).margin(1e-9));
  CHECK(measured(block::b_a, block::b_a) == Approx(0.04).epsilon(0.02));
  CHECK(measured(block::theta, block::theta) < 1e-3);
}

TEST_CASE("predict says what the next update starts from and changes nothing") {
  Filter filter;
  filter.build_map(1);
  RoomWindow room(kRoomEpoch, kTenth, Pose{}, 2);
  for (ImuSample& s : room.imu) s.gyro = Vec3(0.1, 0.2, 0.3);
  const NavState before = filter.estimator->state();
  const NavState predicted = filter.estimator->predict(room.imu);
  CHECK(same_state(filter.estimator->state(), before));
  CHECK(same_state(filter.update(room).prior, predicted));
}

TEST_CASE("a history whose only neighbours are of its own window carries exactly no information") {  // eq. HIS-1
  // A new room: everything in the map was inserted within the window (update 5), the history may match up to 4.
  const RoomWindow room(kRoomEpoch, kTenth, Pose{Mat3::Identity(), Vec3(0.01, 0.02, 0)}, 6);
  const std::vector<HistoryPoint> points = old_points(500);
  Filter without, new_room, old_room;
  for (Filter* filter : {&without, &new_room, &old_room}) filter->build_map(5);
  const Update& plain = without.update(room);
  const Update& no_neighbours = new_room.update(room, {.points = points, .max_stamp = 4});
  CHECK(no_neighbours.history_points == 500);
  CHECK(no_neighbours.history_matches == 0);
  CHECK(same_state(no_neighbours.state, plain.state));
  CHECK(no_neighbours.P == plain.P);
  // The same points against a map that is old enough do count.
  const Update& with_neighbours = old_room.update(room, {.points = points, .max_stamp = 5});
  CHECK(with_neighbours.history_matches > 300);
  CHECK_FALSE(same_state(with_neighbours.state, plain.state));
}

TEST_CASE("history at full weight: counting all of it as new evidence is more certain than what the gain allows") {
  const RoomWindow room(kRoomEpoch, kTenth, Pose{}, 6);
  const std::vector<HistoryPoint> points = old_points(2000);
  const auto certainty = [&](HistoryCovariance rule) {
    Filter filter({}, 3.0);
    filter.build_map(1);
    const Update& update = filter.update(room, {.points = points, .max_stamp = 5, .covariance = rule});
    REQUIRE(update.status == UpdateStatus::ok);
    REQUIRE(update.history_matches > update.fresh_matches);
    return pose_trace(update.P);
  };
  const double all = certainty(HistoryCovariance::all);
  const double fresh_alone = certainty(HistoryCovariance::new_only);
  const double joseph = certainty(HistoryCovariance::joseph);
  CHECK(all < 0.5 * fresh_alone);       // more than twice the evidence that there is
  CHECK(joseph > 0.999 * fresh_alone);  // no gain is better than the optimal one for the fresh points
}

TEST_CASE("with nothing to match the points go on entering the map while dead reckoning is good") {  // eq. IESKF-8
  // The map holds something, but nothing within reach.
  const auto last_insertion = [](const std::vector<std::string>& overrides, bool imu_is_known) {
    Filter filter(overrides, 0.01, imu_is_known);
    const WorldPoint far{.p_W = Vec3(80, 0, 0)};
    filter.update(RoomWindow(kRoomEpoch, kTenth, Pose{}, 1));  // the empty map: the last time all was well
    filter.map->insert({&far, 1}, 1);
    TimeNs last = 0;
    bool stopped = false;
    for (std::uint32_t k = 1; k < 20; ++k) {
      const RoomWindow room(kRoomEpoch + k * kTenth, kTenth, Pose{}, k + 1);
      const Update& update = filter.update(room);
      REQUIRE(update.status == UpdateStatus::few_matches);
      REQUIRE_FALSE(update.accepted);
      CHECK(same_state(update.state, update.prior));
      CHECK_FALSE((stopped && update.insert));  // once too uncertain, for good
      stopped = !update.insert;
      if (update.insert) last = room.window.plan.end - (kRoomEpoch + kTenth);
    }
    return to_seconds(last);
  };
  // With the sensor's own noise and biases known, time decides: 1 s.
  CHECK(last_insertion({"estimator.noise=physical"}, true) == Approx(1.0));
  // With biases unknown by 0.2 m/s^2 and the vertical by as much, 0.1 m is exceeded 0.8 s after, 0.9 s from the start.
  CHECK(last_insertion({"estimator.noise=physical"}, false) == Approx(0.7));
  // With inflated noise the attitude is uncertain by 1 deg after 0.6 s: 0.32 rad/s sqrt(0.005 s * 0.6 s).
  CHECK(last_insertion({"estimator.noise=fastlio"}, true) == Approx(0.6));
}

TEST_CASE("after a match the time of good dead reckoning begins again") {
  Filter filter({"estimator.noise=physical"}, 0.01);
  filter.update(RoomWindow(kRoomEpoch, kTenth, Pose{}, 1));
  filter.build_map(1);
  for (std::uint32_t k = 1; k <= 15; ++k) {
    REQUIRE(filter.update(RoomWindow(kRoomEpoch + k * kTenth, kTenth, Pose{}, k + 1)).accepted);
  }
  filter.map->clear();
  const WorldPoint far{.p_W = Vec3(80, 0, 0)};
  filter.map->insert({&far, 1}, 1);
  CHECK(filter.update(RoomWindow(kRoomEpoch + 16 * kTenth, kTenth, Pose{}, 17)).insert);
}

TEST_CASE("a state that the IMU drives beyond all numbers is refused and rolled back") {
  const double huge =
      GENERATE(std::numeric_limits<double>::infinity(), std::numeric_limits<double>::quiet_NaN(), 1e200);
  const bool empty_map = GENERATE(false, true);
  const std::string rule = GENERATE("rigid", "linear", "asymptotic", "state");
  CAPTURE(huge, empty_map, rule);
  Filter filter({"estimator.deskew_correction=" + rule});
  if (!empty_map) filter.build_map(1);
  const NavState before = filter.estimator->state();
  RoomWindow room(kRoomEpoch, kTenth, Pose{}, 2);
  room.imu[7].gyro.y() = huge;
  const Update& update = filter.update(room);
  CHECK(update.status == UpdateStatus::non_finite);
  CHECK_FALSE(update.accepted);
  CHECK_FALSE(update.insert);
  CHECK(update.P.allFinite());
  CHECK(update.state.t == room.window.plan.end);
  NavState expected = before;
  expected.t = update.state.t;
  CHECK(same_state(update.state, expected));
  CHECK(same_state(update.prior, expected));
  REQUIRE(update.states.size() == 1);
  CHECK(update.trajectory->pose(kRoomEpoch + kTenth / 2).p.allFinite());
  for (const WorldPoint& p : update.points(PointUse::map)) REQUIRE(p.p_W.allFinite());
  // The next window is as good as if nothing had been.
  if (empty_map) filter.build_map(1);
  CHECK(filter.update(RoomWindow(kRoomEpoch + kTenth, kTenth, Pose{}, 3)).accepted);
}

TEST_CASE("a window without IMU data keeps the state and its covariance") {
  Filter filter;
  filter.build_map(1);
  RoomWindow room(kRoomEpoch, kTenth, Pose{}, 2);
  room.window.imu = {};
  const Update& update = filter.update(room);
  CHECK(update.prior.p == Vec3::Zero());
  CHECK(update.state.t == room.window.plan.end);
  CHECK(update.states.size() == 1);
  CHECK(update.status == UpdateStatus::ok);

  Filter unmatched({}, 0.01, true);  // over an empty map the covariance is the predicted one: that of the start, INI-4
  const StateMatrix& P = unmatched.update(room).P;
  for (int i = 0; i < 6; ++i) CHECK(P(i, i) == Approx(1e-8).epsilon(1e-9));
  CHECK(P.isDiagonal(1e-9));
}

TEST_CASE("attitude noise over a window: the density times its length, at any IMU rate, more in turns when so chosen") {
  // eqs. MOT-3, MOT-5. The map is empty, so that the covariance is the predicted one.
  const auto growth = [](const char* noise, std::size_t every, double rate) {  // eqs. MOT-3, MOT-5
    Filter filter({std::string("estimator.noise=") + noise}, 0.01, true);
    RoomWindow room(kRoomEpoch, kTenth, Pose{}, 1);
    std::vector<ImuSample> imu;
    for (std::size_t i = 0; i < room.imu.size(); i += every) imu.push_back(room.imu[i]);
    for (ImuSample& s : imu) s.gyro.z() = rate;
    room.window.imu = imu;
    return filter.update(room).P(2, 2) - 1e-8 - 1e-8 * 0.1 * 0.1;  // less the start and the bias
  };
  const double density = SensorModel{}.gyro_noise;
  CHECK(growth("physical", 1, 0) == Approx(density * density * 0.1).epsilon(0.01));
  CHECK(growth("physical", 4, 0) == Approx(density * density * 0.1).epsilon(0.01));
  CHECK(growth("rate_scaled", 1, 0) == Approx(density * density * 0.1).epsilon(0.01));
  const double scale_error = 0.01 * 4.5;
  CHECK(growth("rate_scaled", 1, 4.5) ==
        Approx((density * density + scale_error * scale_error * 0.1) * 0.1).epsilon(0.01));
}

TEST_CASE("a single wall in view: the update counts, and is marked degenerate") {  // eq. IESKF-7
  Filter filter({}, 3.0);
  filter.build_map(1);
  RoomWindow room(kRoomEpoch, kTenth, Pose{}, 2, 3000);
  std::erase_if(room.fresh, [](const TimedPoint& p) {
    return p.x < 3.99F || std::abs(p.y) > 2 || std::abs(p.z) > 1;  // away from the corners
  });
  room.window.fresh = room.fresh;
  const Update& update = filter.update(room);
  REQUIRE(update.fresh_matches > 50);
  CHECK(update.accepted);
  CHECK(update.status == UpdateStatus::degenerate);
  // Along the wall, up it, and turning about its normal: nothing is known.
  for (std::size_t i = 0; i < 3; ++i) CHECK(update.spectrum[i] < 1.0);
  CHECK(update.spectrum[3] > 100.0);
}

TEST_CASE(
    "after an update that left a direction open, the accelerometer is trusted less until the next one") {  // eq. MOT-7
  // Growth of the variance of the velocity over a window in which nothing matches, after one in which much or a wall
  // did.
  const auto growth = [](bool wall, const char* density) {
    Filter filter({"estimator.noise=physical", std::string("estimator.degenerate_acc_noise=") + density}, 0.01, true);
    filter.build_map(1);
    RoomWindow seen(kRoomEpoch, kTenth, Pose{}, 2, 3000);
    if (wall)
      std::erase_if(seen.fresh,
                    [](const TimedPoint& p) { return p.x < 3.99F || std::abs(p.y) > 2 || std::abs(p.z) > 1; });
    seen.window.fresh = seen.fresh;
    const Update first = filter.update(seen);
    REQUIRE(first.status == (wall ? UpdateStatus::degenerate : UpdateStatus::ok));
    RoomWindow next(kRoomEpoch + kTenth, kTenth, Pose{}, 3, 3000);
    next.window.fresh = {};
    return filter.update(next).P(7, 7) - first.P(7, 7);
  };
  const double density = SensorModel{}.acc_noise, more = 0.05;
  const double without = growth(true, "0"), with = growth(true, "0.05");
  CHECK(with - without == Approx((more * more - density * density) * 0.1).epsilon(0.02));
  CHECK(growth(false, "0.05") == Approx(growth(false, "0")).epsilon(1e-9));
  CHECK(growth(true, "1e-4") == Approx(without).epsilon(1e-9));  // never less than the sensor's own
}

namespace {

/// RMS distance [m] of the points for the map from the nearest wall.
double off_the_walls(const Update& update) {
  const Vec3 half(4, 3, 1.5);
  double sum = 0;
  for (const WorldPoint& p : update.points(PointUse::map)) {
    const double off = (half - p.p_W.cwiseAbs()).cwiseAbs().minCoeff();
    sum += off * off;
  }
  return std::sqrt(sum / static_cast<double>(update.points(PointUse::map).size()));
}

}  // namespace

TEST_CASE("deskew_correction: within one window of a turn, the gyro's error shows") {  // eq. DSK-2
  TurningRoom motion;
  motion.rate = Vec3(0, 0, 3.0);
  motion.gyro_error = Vec3(0, 0, 0.02);
  std::map<std::string, double> off, scale;
  for (const std::string rule : {"rigid", "linear", "asymptotic", "state"}) {
    CAPTURE(rule);
    Filter filter({"estimator.deskew_correction=" + rule, "estimator.gyro_calibration=full", "estimator.noise=physical",
                   "estimator.max_iterations=10"});
    filter.build_map(1);
    const RoomWindow room(kRoomEpoch, kTenth, motion, 2);
    const Update& update = filter.update(room);
    REQUIRE(update.accepted);
    off[rule] = off_the_walls(update);
    scale[rule] = update.state.S_w(2, 2);
    // Points lie where the trajectory says.
    const TimedPoint& raw = room.fresh.front();
    const Vec3 expected = update.trajectory->pose(raw.t) * Vec3(raw.x, raw.y, raw.z);
    CHECK((update.points(PointUse::map).front().p_W - expected).norm() < 1e-5);
    CHECK((update.trajectory->pose(kRoomEpoch + kTenth).p - update.state.p).norm() < 1e-12);
  }
  CAPTURE(off, scale);
  CHECK(off["rigid"] > 0.0015);  // 0.006 rad from begin to end
  CHECK(off["linear"] < 0.4 * off["rigid"]);
  CHECK(off["asymptotic"] < 0.4 * off["rigid"]);
  CHECK(off["state"] < 0.4 * off["rigid"]);
  CHECK(std::abs(scale["state"] - 0.02) < 0.002);
}

TEST_CASE("deskew_correction state: within one window, the velocity shows") {  // eq. DSK-3
  TurningRoom motion;
  motion.drift = Vec3(0.5, -0.3, 0.1);
  for (const std::string rule : {"rigid", "state"}) {
    CAPTURE(rule);
    Filter filter({"estimator.deskew_correction=" + rule, "estimator.noise=physical", "estimator.max_iterations=10"},
                  3.0);
    filter.build_map(1);
    const Update& update = filter.update(RoomWindow(kRoomEpoch, kTenth, motion, 2));
    REQUIRE(update.accepted);
    const double error = (update.state.v - motion.drift).norm();
    if (rule == "state") CHECK(error < 0.01);
    if (rule == "rigid") CHECK(error > 0.05);  // the end alone says where the mean of the window was
    CHECK((off_the_walls(update) < 0.002) == (rule == "state"));
  }
}

TEST_CASE("the states inside a window are on its corrected path, and know what its end knows") {  // eqs. DSK-2, DSK-3
  const TurningRoom motion{.rate = Vec3(0, 0, 3.0), .gyro_error = Vec3(0, 0, 0.02), .drift = Vec3(0.5, -0.3, 0.1)};
  for (const std::string rule : {"rigid", "linear", "asymptotic", "state"}) {
    CAPTURE(rule);
    Filter filter(
        {"estimator.deskew_correction=" + rule, "estimator.gyro_calibration=full", "estimator.noise=physical"}, 3.0);
    filter.build_map(1);
    const RoomWindow room(kRoomEpoch, kTenth, motion, 2);
    std::vector<Vec3> predicted;
    for (std::size_t n = 2; n <= room.imu.size(); ++n) {
      predicted.push_back(filter.estimator->predict(std::span(room.imu).first(n)).v);
    }
    const Update& update = filter.update(room);
    REQUIRE(update.accepted);
    REQUIRE(update.states.size() == predicted.size());
    const Vec3 faster = update.state.v - update.prior.v;
    REQUIRE(faster.norm() > 0.1);
    REQUIRE(update.state.b_w != update.prior.b_w);
    for (std::size_t i = 0; i < update.states.size(); ++i) {
      const NavState& inside = update.states[i];
      CAPTURE(i);
      CHECK(inside.t == room.imu[i + 1].t);
      const Pose there = update.trajectory->pose(inside.t);
      CHECK((inside.p - there.p).norm() < 1e-12);
      CHECK((inside.R - there.R).norm() < 1e-12);
      CHECK(inside.b_w == update.state.b_w);
      CHECK(inside.S_w == update.state.S_w);
      if (rule == "state") continue;  // read again with what has been found
      const double share = rule == "rigid" ? 1.0 : static_cast<double>(i + 1) / static_cast<double>(predicted.size());
      CHECK((inside.v - predicted[i] - share * faster).norm() < 1e-12);
    }
  }
}

TEST_CASE("a refused update leaves no trace of its iterations") {
  TurningRoom motion;
  motion.rate = Vec3(0, 0, 2.0);
  motion.gyro_error = Vec3(0, 0, 0.02);
  for (const std::string rule : {"rigid", "linear", "state"}) {
    CAPTURE(rule);
    Filter filter({"estimator.deskew_correction=" + rule, "estimator.min_matches=1000000"});
    filter.build_map(1);
    const RoomWindow room(kRoomEpoch, kTenth, motion, 2);
    const Update& update = filter.update(room);
    REQUIRE(!update.accepted);
    CHECK(same_state(update.state, update.prior));
    CHECK((update.trajectory->pose(kRoomEpoch + kTenth).p - update.prior.p).norm() < 1e-12);
    CHECK((update.trajectory->pose(kRoomEpoch).p).norm() < 1e-12);
    CHECK((update.trajectory->pose(kRoomEpoch).R - Mat3::Identity()).norm() < 1e-9);
  }
}
