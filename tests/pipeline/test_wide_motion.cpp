// What stands in for IMU readings that are missing or not believed (eq. WID-1).
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <numbers>

#include "../../framework/engine/src/pipeline/wide_motion.hpp"

using namespace aslio;
using namespace aslio::pipeline;

namespace {

constexpr TimeNs kNow = 1'700'000'000 * kSecond, kWindow = kSecond / 10;

/// Distance along a ray from inside a room of 12 x 8 x 3 m with two pillars.
double range_in_room(const Vec3& from, const Vec3& ray) {
  const Vec3 half(6, 4, 1.5);
  double nearest = std::numeric_limits<double>::infinity();
  for (int i = 0; i < 3; ++i) {
    if (ray[i] != 0) nearest = std::min(nearest, ((ray[i] > 0 ? half[i] : -half[i]) - from[i]) / ray[i]);
  }
  for (const Vec3& pillar : {Vec3(3, 1.5, 0), Vec3(-2, -2, 0)}) {
    const Vec3 low = pillar - Vec3(0.3, 0.3, 1.5), high = pillar + Vec3(0.3, 0.3, 1.5);
    const Vec3 a = (low - from).cwiseQuotient(ray), b = (high - from).cwiseQuotient(ray);
    const double enter = a.cwiseMin(b).maxCoeff(), leave = a.cwiseMax(b).minCoeff();
    if (enter > 0 && enter < leave) nearest = std::min(nearest, enter);
  }
  return nearest;
}

/// Goes at an even velocity and turns about z.
struct Walker {
  Vec3 v = Vec3(1.2, 0.3, 0);
  double rate = 0;
  Pose pose(double t) const { return {exp_so3(rate * t * Vec3::UnitZ()), t * v}; }
  NavState state(double t) const {
    NavState out;
    out.t = kNow + to_ns(t);
    out.R = pose(t).R;
    out.p = pose(t).p;
    out.v = v;
    out.g = Vec3(0, 0, -kStandardGravity);
    return out;
  }
};

/// 6400 points of a sweep of 16 lines that begins `from` s after kNow.
std::vector<TimedPoint> sweep(const Walker& walker, double from) {
  std::vector<TimedPoint> points;
  for (int k = 1; k <= 400; ++k) {
    const double t = from + k * to_seconds(kWindow) / 400;
    const Pose T = walker.pose(t);
    for (int line = 0; line < 16; ++line) {
      const double azimuth = 2 * std::numbers::pi * k / 400, height = (2.0 * line - 15) * std::numbers::pi / 180;
      const Vec3 ray(std::cos(azimuth) * std::cos(height), std::sin(azimuth) * std::cos(height), std::sin(height));
      const Vec3 p = range_in_room(T.p, T.R * ray) * ray;
      TimedPoint point;
      point.x = static_cast<float>(p.x());
      point.y = static_cast<float>(p.y());
      point.z = static_cast<float>(p.z());
      point.t = kNow + to_ns(t);
      points.push_back(point);
    }
  }
  return points;
}

SensorModel sensor() {
  SensorModel out;
  out.min_range = 0.3;
  out.max_range = 60;
  return out;
}

/// Two readings of one who does not turn, at both ends of a window that begins at kNow.
std::vector<ImuSample> readings_at_rest(std::uint8_t faults = 0) {
  const Vec3 up(0, 0, kStandardGravity);
  return {{kNow, Vec3::Zero(), up, faults}, {kNow + kWindow, Vec3::Zero(), up, faults}};
}

Window window_of(const std::vector<TimedPoint>& points, const std::vector<ImuSample>& imu, TimeNs gap) {
  Window window;
  window.plan.fresh_begin = kNow;
  window.plan.end = kNow + kWindow;
  window.fresh = points;
  window.imu = imu;
  window.imu_gap = gap;
  return window;
}

/// Shows it the room over the half second before kNow.
void show(WideMotion& wide, const Walker& walker) {
  for (int k = -5; k < 0; ++k) {
    const double from = k * to_seconds(kWindow);
    const auto raw = sweep(walker, from);
    std::vector<WorldPoint> placed;
    for (const TimedPoint& p : raw) {
      WorldPoint point;
      point.p_W = walker.pose(to_seconds(p.t - kNow)) * Vec3(p.x, p.y, p.z);
      point.t = p.t;
      placed.push_back(point);
    }
    Window window;
    window.plan.fresh_begin = kNow + to_ns(from);
    window.plan.end = window.plan.fresh_begin + kWindow;
    Update update;
    update.accepted = true;
    update.match_points = placed;
    wide.observe(window, update);
  }
}

double turned(std::span<const ImuSample> imu) {
  double turn = 0;
  for (std::size_t i = 1; i < imu.size(); ++i) {
    turn += 0.5 * to_seconds(imu[i].t - imu[i - 1].t) * (imu[i].gyro.z() + imu[i - 1].gyro.z());
  }
  return turn;
}

}  // namespace

TEST_CASE("wide motion: over a gap of the IMU the points say how the sensor turned") {
  for (const double rate : {0.0, 1.0, -2.0, 3.5}) {
    const Walker walker{.rate = rate};
    WideMotion wide(sensor());
    show(wide, walker);
    const auto points = sweep(walker, 0);
    const auto imu = readings_at_rest();
    Window window = window_of(points, imu, kSecond);
    CAPTURE(rate);
    // What the last updates turned by is no help here: it stopped.
    REQUIRE(wide.mend(window, walker.state(0), Vec3::Zero()));
    CHECK(std::abs(turned(window.imu) - rate * to_seconds(kWindow)) < 0.01);
    CHECK(window.imu.front().t == kNow);
    CHECK(window.imu.back().t == kNow + kWindow);
    CHECK(window.imu_gap == 0);
    CHECK((window.imu.front().faults & imu_fault::gyro_dead) != 0);
    CHECK((window.imu.front().faults & imu_fault::acc_dead) != 0);
  }
}

TEST_CASE("wide motion: of an axis at the end of its range only the rate is replaced") {
  const Walker walker{.rate = 3.5};
  WideMotion wide(sensor());
  show(wide, walker);
  const auto points = sweep(walker, 0);
  auto imu = readings_at_rest(imu_fault::clipped(false, 2));
  for (ImuSample& s : imu) s.gyro.z() = 2.0;
  Window window = window_of(points, imu, 0);
  REQUIRE(wide.mend(window, walker.state(0), Vec3(0, 0, 2.0)));
  CHECK(std::abs(turned(window.imu) - 0.35) < 0.01);
  for (const ImuSample& s : window.imu) {
    CHECK(s.acc == imu.front().acc);
    CHECK(s.faults == imu.front().faults);
  }
}

TEST_CASE("wide motion: readings that are believed stay, and so do all where nothing was seen before") {
  const Walker walker{.rate = 2.0};
  const auto points = sweep(walker, 0);
  const auto imu = readings_at_rest();
  WideMotion wide(sensor());
  Window unseen = window_of(points, imu, kSecond);
  CHECK_FALSE(wide.mend(unseen, walker.state(0), Vec3::Zero()));
  CHECK(unseen.imu.data() == imu.data());
  CHECK(unseen.imu_gap == kSecond);
  show(wide, walker);
  Window believed = window_of(points, imu, 0);
  CHECK_FALSE(wide.mend(believed, walker.state(0), Vec3::Zero()));
  CHECK(believed.imu.data() == imu.data());
  wide.forget();
  CHECK_FALSE(wide.mend(unseen, walker.state(0), Vec3::Zero()));
}

TEST_CASE("wide motion: a window with hardly a point binds nothing") {
  const Walker walker{.rate = 2.0};
  WideMotion wide(sensor());
  show(wide, walker);
  auto points = sweep(walker, 0);
  points.resize(20);
  const auto imu = readings_at_rest();
  Window window = window_of(points, imu, kSecond);
  CHECK_FALSE(wide.mend(window, walker.state(0), Vec3::Zero()));
  CHECK(window.imu.data() == imu.data());
}
