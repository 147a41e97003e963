// What was seen a moment ago is where the run's own motion puts it, or it is not (eq. MON-6).
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <limits>
#include <random>
#include <vector>

#include "aslio/core/lie.hpp"
#include "aslio/pipeline/view_check.hpp"

namespace aslio::pipeline::view_check_test {

namespace {

constexpr TimeNs kEpoch = 1'700'000'000 * kSecond;

/// A hall of 30 m by 20 m with pillars.
double cast(const Vec3& from, const Vec3& ray) {
  double range = std::numeric_limits<double>::infinity();
  const Vec3 low(-15, -10, -1.5), high(15, 10, 4.5);
  for (int axis = 0; axis < 3; ++axis) {
    const double wall = ray[axis] > 0 ? high[axis] : low[axis];
    if (ray[axis] != 0) range = std::min(range, (wall - from[axis]) / ray[axis]);
  }
  for (int i = -2; i <= 2; ++i) {
    for (const double y : {-4.0, 5.0}) {
      const Vec3 inverse = ray.cwiseInverse();
      const Vec3 a = (Vec3(5.0 * i - 0.4, y - 0.4, -1.5) - from).cwiseProduct(inverse);
      const Vec3 b = (Vec3(5.0 * i + 0.4, y + 0.4, 4.5) - from).cwiseProduct(inverse);
      const double enter = a.cwiseMin(b).maxCoeff(), leave = a.cwiseMax(b).minCoeff();
      if (enter > 0 && enter < leave) range = std::min(range, enter);
    }
  }
  return range;
}

/// A motion, and the poses that the run believes.
class Motion final : public TrajectoryModel {
 public:
  explicit Motion(std::function<Pose(double)> pose) : pose_(std::move(pose)) {}
  Pose pose(TimeNs t) const override { return pose_(to_seconds(t - kEpoch)); }
  int dof() const override { return 6; }
  Pose moved(TimeNs, const Eigen::VectorXd&) const override { return {}; }
  void jacobian(TimeNs, Eigen::MatrixXd&) const override {}

 private:
  std::function<Pose(double)> pose_;
};

/// Largest share after `after` s of 2 s of data, in windows of `window`; -1: none was found. `view`: its width [deg] by
/// the time [s].
double worst(const Motion& truth, const Motion& believed, TimeNs window, double after,
             const std::function<double(double)>& view, const SensorModel& sensor = {}) {
  ViewCheck check(sensor);
  std::mt19937 engine(101);
  const auto uniform = [&](double a, double b) { return a + (b - a) * static_cast<double>(engine() % 100'000) / 1e5; };
  double out = -1;
  const TimeNs slot = std::max(kSecond / 10, to_ns(sensor.sweep_period));
  TimeNs begin = kEpoch;
  for (TimeNs end = kEpoch + window; end <= kEpoch + 2 * kSecond; end += window) {
    std::vector<TimedPoint> points;
    const auto count = static_cast<int>(100'000 * to_seconds(window));
    const double view_deg = view(to_seconds(end - kEpoch));
    const double height = view_deg < 180 ? std::sin(view_deg / 360 * 3.14159) : 0.7;
    for (int i = 0; i < count; ++i) {
      const TimeNs t = end - window + (i + 1) * (window / count);
      const double azimuth = uniform(-view_deg, view_deg) * 3.14159 / (view_deg < 180 ? 360 : 180);
      const double z = uniform(-height, height), c = std::sqrt(1 - z * z);
      const Vec3 ray(c * std::cos(azimuth), c * std::sin(azimuth), z);
      const Pose T = truth.pose(t);
      const Eigen::Vector3f p = ((cast(T.p, T.R * ray) + uniform(-0.03, 0.03)) * ray).cast<float>();
      points.push_back({.x = p.x(), .y = p.y(), .z = p.z(), .t = t});
    }
    const bool ends = end - begin >= slot - kSecond / 200;
    if (ends) begin = end;
    const auto share = check.add(points, believed, end, ends);
    if (share && to_seconds(end - kEpoch) > after) out = std::max(out, share->share);
  }
  return out;
}

double worst(const Motion& truth, const Motion& believed, TimeNs window, double after, double view_deg = 180,
             const SensorModel& sensor = {}) {
  return worst(
      truth, believed, window, after, [=](double) { return view_deg; }, sensor);
}

Motion walk(double speed, double rate) {
  return Motion([=](double t) { return Pose{exp_so3(rate * t * Vec3::UnitZ()), Vec3(-5 + speed * t, 0.5, 0)}; });
}

}  // namespace

TEST_CASE("view check: what the motion explains is explained, however it is cut into windows") {
  for (const TimeNs window : {kSecond / 10, kSecond / 50, kSecond / 125}) {
    CAPTURE(to_seconds(window));
    CHECK(worst(walk(0, 0), walk(0, 0), window, 0) >= 0);
    CHECK(worst(walk(0, 0), walk(0, 0), window, 0) < 0.03);
    CHECK(worst(walk(1.5, 0), walk(1.5, 0), window, 0) < 0.06);
    CHECK(worst(walk(1.0, 3.0), walk(1.0, 3.0), window, 0) < 0.08);
    CHECK(worst(walk(6.0, 0.5), walk(6.0, 0.5), window, 0) < 0.1);
  }
}

TEST_CASE("view check: a piece of the data that is missing is not explained") {
  // 4 s of a walk are cut out after 1 s.
  const auto jump = [](double by, double turn, double at = 1.0) {
    return Motion([=](double t) {
      const double off = t > at ? 1.0 : 0.0;
      return Pose{exp_so3(off * turn * Vec3::UnitZ()), Vec3(-5 + t + off * by, 0.5, 0)};
    });
  };
  for (const double view : {180.0, 70.0}) {
    CAPTURE(view);
    CHECK(worst(jump(4.0, 0), walk(1.0, 0), kSecond / 10, 1.0, view) > 0.2);
    CHECK(worst(jump(3.0, 1.0), walk(1.0, 0), kSecond / 10, 1.0, view) > 0.2);
    // The slot within which it is missing shows both places: none of its directions is a surface.
    CHECK(worst(jump(4.0, 0, 1.05), walk(1.0, 0), kSecond / 10, 1.1, view) > 0.15);
  }
}

TEST_CASE("view check: nothing is judged where less than half of the view is seen again") {
  // In a slot a view of 70 deg sweeps 185 deg, of which the next one sees 70 again; seen all round, all of it stays.
  const Motion truth = walk(1.0, 20.0), late = walk(0, 20.0);
  CHECK(worst(truth, truth, kSecond / 10, 0.5, 70) == -1);
  CHECK(worst(truth, late, kSecond / 10, 0.5, 70) == -1);
  CHECK(worst(truth, truth, kSecond / 10, 0.5) >= 0);
}

TEST_CASE("view check: little of the view of the last second is as little as of the slot before") {
  // From 0.5 s on something takes most of the view; then 4 m of the walk are missing from `cut` on.
  const auto jump = [](double cut) {
    return Motion([=](double t) { return Pose{Mat3::Identity(), Vec3(-5 + t + (t > cut ? 4.0 : 0.0), 0.5, 0)}; });
  };
  const auto narrowing = [](double t) { return t < 0.55 ? 120.0 : 40.0; };
  CHECK(worst(jump(0.9), jump(9), kSecond / 10, 0.6, narrowing) < 0.1);
  // A second later the narrow view is the usual one.
  CHECK(worst(jump(1.75), jump(9), kSecond / 10, 1.6, narrowing) > 0.2);
}

TEST_CASE("view check: who walks by within 2 m is not a motion that the run does not know") {
  // For 0.3 s somebody fills 50 deg of the view; what lies behind him stays where it was.
  int answers = 0;  // of the slots that see him come, stay and go
  const auto share = [&](double range) {
    answers = 0;
    const Motion still = walk(0, 0);
    ViewCheck check(SensorModel{});
    std::mt19937 engine(102);
    const auto uniform = [&](double a, double b) {
      return a + (b - a) * static_cast<double>(engine() % 100'000) / 1e5;
    };
    double out = -1;
    for (TimeNs end = kEpoch + kSecond / 10; end <= kEpoch + kSecond; end += kSecond / 10) {
      const double t = to_seconds(end - kEpoch);
      const bool there = t > 0.45 && t < 0.75;
      std::vector<TimedPoint> points;
      for (int i = 0; i < 6000; ++i) {
        const double azimuth = uniform(-0.6, 0.6), z = uniform(-0.5, 0.5), c = std::sqrt(1 - z * z);
        const Vec3 ray(c * std::cos(azimuth), c * std::sin(azimuth), z);
        const bool hit = there && std::abs(azimuth) < 0.44;
        const Eigen::Vector3f p = ((hit ? range : cast(still.pose(end).p, ray)) * ray).cast<float>();
        points.push_back({.x = p.x(), .y = p.y(), .z = p.z(), .t = end - kSecond / 10 + (i + 1) * 10'000});
      }
      if (const auto seen = check.add(points, still, end, true)) {
        out = std::max(out, seen->share);
        answers += t > 0.45 && t < 0.85 ? 1 : 0;
      }
    }
    return out;
  };
  CHECK(share(0.8) < 0.01);
  CHECK(answers == 4);
  CHECK(share(3.0) > 0.3);  // a thing that large and that far off is no person
}

TEST_CASE("view check: a turn that the run does not follow is not explained") {
  CHECK(worst(walk(0, 2.0), walk(0, 0), kSecond / 10, 0.5) > 0.1);
}

TEST_CASE("view check: a slot is a sweep, and after a silence nothing is compared") {
  SensorModel slow;
  slow.sweep_period = 0.5;
  CHECK(worst(walk(1.0, 0), walk(1.0, 0), kSecond / 10, 0.9, 180, slow) >= 0);
  SensorModel sensor;
  sensor.min_range = 0.5;
  ViewCheck check(sensor);
  const Motion still = walk(0, 0);
  std::vector<TimedPoint> points;
  for (int i = 0; i < 4000; ++i) {
    const double a = 0.01 * i, z = 0.6 * std::sin(0.37 * i), c = std::sqrt(1 - z * z);
    points.push_back({.x = static_cast<float>(5 * c * std::cos(a)),
                      .y = static_cast<float>(5 * c * std::sin(a)),
                      .z = static_cast<float>(5 * z),
                      .t = kEpoch + (i + 1) * 25'000});
  }
  CHECK_FALSE(check.add(points, still, kEpoch + kSecond / 10, true));
  for (TimedPoint& p : points) p.t += kSecond;
  CHECK_FALSE(check.add(points, still, kEpoch + 11 * kSecond / 10, true));
  for (TimedPoint& p : points) p.t += kSecond / 10;
  const auto again = check.add(points, still, kEpoch + 12 * kSecond / 10, true);
  REQUIRE(again);
  CHECK(again->share == 0.0);
  CHECK_FALSE(again->skips);
  // A lens that is covered: points nearer than min_range are no view.
  std::vector<TimedPoint> covered = points;
  for (TimedPoint& p : covered) p.x = p.y = p.z = 0.001F;
  for (int i = 1; i <= 6; ++i) {
    for (TimedPoint& p : covered) p.t += kSecond / 10;
    CHECK_FALSE(check.add(covered, still, kEpoch + (12 + i) * kSecond / 10, true));
  }
  for (TimedPoint& p : points) p.t += 7 * kSecond / 10;
  CHECK_FALSE(check.add(points, still, kEpoch + 19 * kSecond / 10, true));
}

}  // namespace aslio::pipeline::view_check_test
