// The monitor: what is usual raises no alarm, what does not fit is named.
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "aslio/pipeline/monitor.hpp"

using namespace aslio;
using namespace aslio::pipeline;
using Catch::Matchers::Contains;

namespace {

constexpr TimeNs kTenth = kSecond / 10;

/// A sensor that stays where it is.
class Still final : public TrajectoryModel {
 public:
  Pose pose(TimeNs) const override { return {}; }
  int dof() const override { return 6; }
  Pose moved(TimeNs, const Eigen::VectorXd&) const override { return {}; }
  void jacobian(TimeNs, Eigen::MatrixXd&) const override {}
};

/// Windows of 0.1 s in a round room, whose update fits as well as ever unless something is changed.
struct Play {
  Monitor monitor{SensorModel{}};
  Still still;
  TimeNs t = 1'700'000'000 * kSecond;
  double room = 5.0;  ///< its radius [m]
  /// Factor of the range of a direction, `late`: in the second half of the window.
  std::function<double(double z, bool late)> scale = [](double, bool) { return 1.0; };
  int n_points = 3000;
  double view = 1.0;  ///< share of the sphere that is seen, from +z on
  Vec3 rate = Vec3::Zero();
  Update update;
  std::vector<MatchRecord> matches = std::vector<MatchRecord>(100, MatchRecord{true, 0.01F, true});
  std::vector<TimedPoint> points;
  std::vector<ImuSample> imu;
  int count = 0;

  Play() {
    monitor.begin(true);
    update.status = UpdateStatus::ok;
    update.accepted = true;
    update.residual_rms = 0.02;
    update.nis = 1.0;
    update.trajectory = &still;
    update.P.diagonal().setConstant(1e-6);
  }

  const MonitorSignals& next() {
    points.clear();
    for (int i = 0; i < n_points; ++i) {
      const int k = static_cast<int>(i * 7919LL % n_points);  // all over the sphere, at any time of the window
      const double a = 2.39996 * k, z = 1.0 - view * (2.0 * k + 1.0) / n_points;
      const double c = std::sqrt(1.0 - z * z);
      TimedPoint p;
      const double range = room * scale(z, 2 * i >= n_points);
      p.x = static_cast<float>(range * c * std::cos(a));
      p.y = static_cast<float>(range * c * std::sin(a));
      p.z = static_cast<float>(range * z);
      p.t = t + (i + 1) * (kTenth / n_points);
      points.push_back(p);
    }
    imu.assign(2, ImuSample{});
    imu[0].t = t;
    imu[1].t = t + kTenth;
    imu[0].gyro = imu[1].gyro = rate;
    imu[0].faults = imu[1].faults = faults;
    // Small corrections that change their sign, as noise makes them.
    const double sign = ++count % 2 == 0 ? 1.0 : -1.0;
    if (!pulled) update.state.v = Vec3(sign * 1e-3, 0, 0);
    update.matches = matches;
    Window window;
    window.plan.fresh_begin = t;
    window.plan.end = t + kTenth;
    window.fresh = points;
    window.imu = imu;
    window.imu_gap = imu_gap;
    t += kTenth;
    return monitor.observe(window, update, OverlapScore{.value = 0.9});
  }
  void calm(int times) {
    while (times-- > 0) {
      next();
      CHECK_FALSE(monitor.alarm());
    }
  }
  bool pulled = false;
  TimeNs imu_gap = 0;
  std::uint8_t faults = 0;  ///< of the IMU samples
};

}  // namespace

// eq. MON-1.
TEST_CASE("monitor: what is usual is no alarm, also where it changes slowly") {
  Play play;
  for (int i = 0; i < 200; ++i) {
    play.update.residual_rms = 0.02 * (1.0 + 0.005 * i);
    play.room = 5.0 * (1.0 + 0.005 * i);
    play.next();
    REQUIRE_FALSE(play.monitor.alarm());
  }
  CHECK(play.monitor.report().alarms == 0);
  CHECK(play.monitor.report().implausible.empty());
}

// eq. MON-2.
TEST_CASE("monitor: a view that changes as a whole is an alarm within two tenths of a second") {
  Play play;
  play.calm(20);
  play.room = 9.0;
  play.next();
  CHECK(play.monitor.alarm());
  CHECK(play.monitor.report().alarms == 1);
  CHECK_THAT(play.monitor.alarm().value_or(""),
             Contains("of the surfaces seen before are not where the motion of the run puts them"));
}

TEST_CASE("monitor: the view alone tells it as well, where something stands in for the gyro") {
  Play play;
  play.faults = imu_fault::gyro_clipped;
  play.calm(20);
  play.room = 9.0;
  CHECK(std::isnan(play.next().unexplained));
  CHECK_THAT(play.monitor.alarm().value_or(""), Contains("of the view changed at once"));
}

TEST_CASE("monitor: after a time without points another view is no alarm") {
  Play play;
  play.calm(20);
  play.room = 9.0;
  play.t += kSecond;
  play.calm(10);
}

// eq. MON-3.
TEST_CASE("monitor: residuals that rise while the points pull the state are an alarm, residuals alone are not") {
  Play play;
  play.calm(30);
  play.update.residual_rms = 0.06;
  play.calm(20);
  Play pulled;
  pulled.calm(30);
  pulled.pulled = true;
  pulled.update.residual_rms = 0.1;
  for (std::size_t i = 0; i < 40; ++i) pulled.matches[i] = MatchRecord{};
  pulled.update.state.v = Vec3(0.1, 0, 0);
  int windows = 0;
  while (!pulled.monitor.alarm() && windows < 10) {
    pulled.next();
    ++windows;
  }
  CHECK(windows <= 5);
  CHECK_THAT(pulled.monitor.alarm().value_or(""), Contains("the points no longer fit"));
}

TEST_CASE("monitor: a part of the map that is met again some centimetres off is no alarm") {
  Play closing;
  closing.calm(30);
  closing.pulled = true;
  closing.update.residual_rms = 0.08;  // all points still find their surface
  closing.update.state.v = Vec3(0.1, 0, 0);
  closing.calm(6);
  closing.update.state.v = Vec3(0.01, 0, 0);
  closing.calm(20);
}

/// A run that stands in the room and claims to move ever faster.
class Phantom final : public TrajectoryModel {
 public:
  double acceleration = 0;  ///< along x [m/s^2]
  TimeNs begin = 0;
  Pose pose(TimeNs t) const override {
    const double age = to_seconds(t - begin);
    return {Mat3::Identity(), Vec3(0.5 * acceleration * age * age, 0, 0)};
  }
  int dof() const override { return 6; }
  Pose moved(TimeNs, const Eigen::VectorXd&) const override { return {}; }
  void jacobian(TimeNs, Eigen::MatrixXd&) const override {}
};

// eq. MON-6.
TEST_CASE("monitor: a motion of the run that the view does not show is an alarm once the points fit worse") {
  for (const bool worse : {true, false}) {
    Play play;
    Phantom phantom;
    play.update.trajectory = &phantom;
    play.room = 4.0;
    play.view = 0.2;
    play.n_points = 20000;  // some in every direction, wherever the phantom puts them
    play.calm(30);
    phantom.begin = play.t;
    std::string reason;
    for (int i = 0; i < 20 && reason.empty(); ++i) {
      if (worse && i == 10) std::fill_n(play.matches.begin(), 60, MatchRecord{});
      phantom.acceleration = 12.0;  // as of an accelerometer whose bias has changed
      play.next();
      reason = play.monitor.alarm().value_or("");
    }
    CAPTURE(worse, reason);
    if (worse) CHECK_THAT(reason, Contains("the run moves as the view does not"));
    if (!worse) CHECK(reason.find("as the view does not") == std::string::npos);
  }
}

// eq. MON-6.
TEST_CASE("monitor: a cut within a sweep is an alarm one sweep later") {
  Play play;
  play.n_points = 30000;
  play.view = 0.3;  // z from 0.4 on
  play.calm(20);
  // A sixth of the view is nearer from the middle of a sweep on.
  const auto moved = [](double z) { return z < 0.502 ? 0.72 : 1.0; };
  play.scale = [&](double z, bool late) { return late ? moved(z) : 1.0; };
  CHECK(play.next().unexplained < 0.05);  // a direction that shows both is no surface, and what is left is where it was
  CHECK_FALSE(play.monitor.alarm());
  play.scale = [&](double z, bool) { return moved(z); };
  const MonitorSignals after = play.next();
  CHECK(after.unexplained > 0.11);
  CHECK(after.view_jump < 2.2);
  CHECK_THAT(play.monitor.alarm().value_or(""), Contains("not where the motion of the run puts them"));
}

// eq. MON-6.
TEST_CASE("monitor: a run that finds itself again after refused updates moves as no view shows, and may") {
  for (const int refused : {0, 2, 5}) {
    CAPTURE(refused);
    Play play;
    Phantom phantom;
    play.update.trajectory = &phantom;
    play.room = 4.0;
    play.view = 0.2;
    play.n_points = 20000;
    play.calm(20);
    play.update.accepted = false;
    play.update.status = UpdateStatus::few_matches;
    play.calm(refused);
    play.update.accepted = true;
    play.update.status = UpdateStatus::ok;
    phantom.begin = play.t;
    phantom.acceleration = 300.0;  // 1.5 m in the first window
    std::string reason;
    for (int i = 0; i < 3 && reason.empty(); ++i) {
      play.next();
      reason = play.monitor.alarm().value_or("");
    }
    CAPTURE(reason);
    CHECK(reason.empty() == (refused > 2));
    if (refused <= 2) continue;
    phantom.acceleration = 0;  // a second later it holds no longer
    play.calm(10);
    phantom.begin = play.t;
    phantom.acceleration = 300.0;
    for (int i = 0; i < 3 && reason.empty(); ++i) {
      play.next();
      reason = play.monitor.alarm().value_or("");
    }
    CHECK_FALSE(reason.empty());
  }
}

TEST_CASE("monitor: points that contradict the gyro's turn name the extrinsic") {
  Play play;
  play.rate = Vec3(0, 0, 0.5);
  play.calm(12);
  play.update.state.R = exp_so3(Vec3(0, 0, -0.02));  // of 0.05 rad per window
  for (int i = 0; i < 20 && !play.monitor.alarm(); ++i) play.next();
  CHECK_THAT(play.monitor.alarm().value_or(""), Contains("check T_imu_lidar"));
  Play without;
  without.monitor.begin(false);  // a prior that knows nothing of the gyro
  without.rate = Vec3(0, 0, 0.5);
  without.calm(12);
  without.update.state.R = exp_so3(Vec3(0, 0, -0.02));
  without.calm(20);
}

// eq. MON-4.
TEST_CASE("monitor: a learnt state beyond what a part can have is implausible, with several sigma of evidence") {
  Play play;
  play.calm(12);
  play.update.state.S_w(0, 0) = -0.025;
  const int at = block::s;
  play.update.P(at, at) = 0.02 * 0.02;
  play.calm(10);
  CHECK(play.monitor.report().implausible.empty());  // as good as unknown
  play.update.P(at, at) = 0.004 * 0.004;
  play.calm(10);
  CHECK_THAT(play.monitor.report().implausible, Contains("-2.5 +- 0.4 %") && Contains("check T_imu_lidar"));
  play.update.state.S_w(0, 0) = 1.49;
  for (int i = 0; i < 3; ++i) play.next();
  CHECK_THAT(play.monitor.alarm().value_or(""), Contains("+149 +- 0.4 %"));
}

TEST_CASE("monitor: a delay, a bias of the gyro and one of the accelerometer are named") {
  const auto text = [](const std::function<void(NavState&)>& change) {
    Play play;
    change(play.update.state);
    play.next();
    return play.monitor.report().implausible;
  };
  CHECK_THAT(text([](NavState& x) { x.imu_delay = 0.021; }), Contains("IMU delay +21 +- 1 ms"));
  CHECK_THAT(text([](NavState& x) { x.b_w.y() = 0.2; }), Contains("gyro bias +0.2"));
  CHECK_THAT(text([](NavState& x) { x.b_a.z() = -2; }), Contains("accelerometer bias -2"));
  CHECK(text([](NavState& x) { x.imu_delay = 0.004; }).empty());
}

TEST_CASE("monitor: the direction that is not bound is named, once it lasts for a second") {
  Play play;
  play.update.unobservable = true;
  play.update.weakest << 0, 0.1, 0, 0.99, 0.1, 0;
  play.calm(9);
  CHECK(unbound_text(play.monitor.report()).empty());
  play.calm(5);
  CHECK(unbound_text(play.monitor.report()) == "translation along x of the body is not bound (1.4 s)");
  play.update.weakest << 0.1, 0, 0.99, 0, 0.1, 0;
  play.calm(20);
  CHECK_THAT(unbound_text(play.monitor.report()), Contains("yaw is not bound (2.0 s)"));
}

TEST_CASE("monitor: nothing is usual within the first second, nor after a new start") {
  Play play;
  play.calm(20);
  play.monitor.begin(true);
  play.room = 9.0;
  play.update.residual_rms = 0.2;
  play.calm(8);
}

// eq. MON-5.
TEST_CASE(
    "monitor: a long gap of the IMU after which nothing matches is an alarm, one that the points bridge is none") {
  for (const bool matches : {true, false}) {
    for (const double gap : {0.4, 0.6}) {
      CAPTURE(matches, gap);
      Play play;
      play.calm(20);
      play.imu_gap = to_ns(gap);
      play.update.accepted = matches;
      play.update.status = matches ? UpdateStatus::ok : UpdateStatus::few_matches;
      play.next();
      CHECK(play.monitor.alarm().has_value() == (!matches && gap > 0.5));
    }
  }
}

TEST_CASE("monitor: of a gyro that is dead the alarm says so, and one at the end of its range is not compared") {
  for (const std::uint8_t faults : {imu_fault::gyro_dead, imu_fault::clipped(false, 2)}) {
    const bool dead = faults == imu_fault::gyro_dead;
    CAPTURE(dead);
    Play play;
    play.calm(20);
    play.rate = Vec3(0, 0, 1);
    play.faults = faults;
    play.update.prior.R = exp_so3(Vec3(0, 0, -0.05));  // the points find half of the turn
    bool alarm = false;
    for (int i = 0; i < 30 && !alarm; ++i) {
      play.next();
      alarm = play.monitor.alarm().has_value();
    }
    CHECK(alarm == dead);
    if (dead) CHECK_THAT(play.monitor.alarm().value_or(""), Contains("stuck or dead"));
  }
}
