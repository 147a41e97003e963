#include "wide_motion.hpp"

#include <algorithm>

#include "aslio/core/spread.hpp"
#include "inertial_path.hpp"

namespace aslio::pipeline {

namespace {

constexpr TimeNs kMemory = 2 * kSecond;
constexpr double kPointsPerSecond = 15000;  // that are kept
constexpr std::size_t kMinPoints = 60;
constexpr TimeNs kKnot = 10'000'000;
// What the readings do not say, in a walk or a hand: v is known by the last update.
constexpr MotionSigma kUnread = {1e-3, 5.0, 2.0};

ConstantMotion known_motion(const NavState& at) {
  ConstantMotion out;
  out.v = at.R.transpose() * at.v;
  out.g = at.R.transpose() * at.g;
  return out;
}

/// Readings without their biases, for a path.
std::vector<ImuSample> unbiased(std::span<const ImuSample> imu, const NavState& at) {
  std::vector<ImuSample> out(imu.begin(), imu.end());
  for (ImuSample& s : out) {
    s.gyro -= at.b_w;
    s.acc -= at.b_a;
  }
  return out;
}

/// The same readings with knots so near to each other that a turn between them is small.
std::vector<ImuSample> with_knots(std::span<const ImuSample> imu) {
  std::vector<ImuSample> out;
  for (std::size_t i = 0; i + 1 < imu.size(); ++i) {
    const ImuSample &a = imu[i], &b = imu[i + 1];
    const auto steps = std::max<TimeNs>(1, (b.t - a.t + kKnot - 1) / kKnot);
    for (TimeNs k = 0; k < steps; ++k) {
      const double u = static_cast<double>(k) / static_cast<double>(steps);
      ImuSample s = a;
      s.t = a.t + (b.t - a.t) * k / steps;
      s.gyro = (1 - u) * a.gyro + u * b.gyro;
      s.acc = (1 - u) * a.acc + u * b.acc;
      if (k > 0) s.faults = a.faults | b.faults;
      out.push_back(s);
    }
  }
  out.push_back(imu.back());
  return out;
}

/// Adds the rate that the points say the readings lack, in the axes of I at the begin.
void correct_rate(std::vector<ImuSample>& imu, const NavState& at, const Vec3& rate) {
  Mat3 R = Mat3::Identity();
  Vec3 before = imu.front().gyro;
  for (std::size_t i = 0; i < imu.size(); ++i) {
    const Vec3 reading = imu[i].gyro;
    if (i > 0) {
      const Vec3 w = 0.5 * (before + reading) - at.b_w + R.transpose() * rate;
      R = R * exp_so3(to_seconds(imu[i].t - imu[i - 1].t) * w);
    }
    before = reading;
    imu[i].gyro += R.transpose() * rate;
  }
}

/// Makes the accelerometer read `acc` [m/s^2], in the axes of I at the begin, along the turn that the gyro reads.
void set_acceleration(std::vector<ImuSample>& imu, const NavState& at, const Vec3& acc) {
  const Vec3 force = acc - at.R.transpose() * at.g;
  Mat3 R = Mat3::Identity();
  for (std::size_t i = 0; i < imu.size(); ++i) {
    if (i > 0) {
      R = R * exp_so3(to_seconds(imu[i].t - imu[i - 1].t) * (0.5 * (imu[i - 1].gyro + imu[i].gyro) - at.b_w));
    }
    imu[i].acc = at.b_a + R.transpose() * force;
  }
}

/// What an IMU reads that turns evenly and does not accelerate.
std::vector<ImuSample> even(std::span<const ImuSample> imu, const NavState& at, const Vec3& rate) {
  std::vector<ImuSample> out(imu.begin(), imu.end());
  for (ImuSample& s : out) s.gyro = rate + at.b_w;
  set_acceleration(out, at, Vec3::Zero());
  return out;
}

/// Whether the accelerometer says as little as the gyro does.
bool acceleration_unread(const Window& window) {
  return window.imu_gap >= WideMotion::kLongGap ||
         std::any_of(window.imu.begin(), window.imu.end(),
                     [](const ImuSample& s) { return (s.faults & imu_fault::acc_dead) != 0; });
}

}  // namespace

void WideMotion::observe(const Window& window, const Update& update) {
  const auto points = update.points(PointUse::match);
  const double length = to_seconds(window.plan.end - window.plan.fresh_begin);
  const auto most = static_cast<std::size_t>(kPointsPerSecond * std::clamp(length, 1e-3, 0.5));
  const std::size_t taken = std::min(most, points.size());
  StratifiedPick choice(taken, points.size(), 0);
  for (std::size_t k = 0; k < taken; ++k) {
    const WorldPoint& p = points[choice.next()];
    seen_.push_back({p.t, p.p_W});
  }
  while (!seen_.empty() && seen_.front().t < window.plan.end - kMemory) seen_.pop_front();
}

bool WideMotion::doubtful(const Window& window) {
  if (window.imu_gap >= kLongGap) return true;
  constexpr auto bad = imu_fault::gyro_dead | imu_fault::gyro_clipped;
  return std::any_of(window.imu.begin(), window.imu.end(), [](const ImuSample& s) { return (s.faults & bad) != 0; });
}

void WideMotion::load_reference(const NavState& at) {
  const Pose B_from_W = at.pose().inverse();
  reference_.clear();
  for (const Seen& s : seen_) {
    SweepPoint p;
    p.q = p.y = B_from_W * s.p_W;
    if (p.q.norm() <= kMaxRange) reference_.push_back(p);
  }
}

std::vector<SweepPoint> WideMotion::load_points(const Window& window, const NavState& at,
                                                std::span<const ImuSample> imu) const {
  const std::vector<ImuSample> readings = unbiased(imu, at);
  InertialPath path(readings, window.plan.fresh_begin);
  CellIndex taken;
  std::vector<SweepPoint> all;
  for (const TimedPoint& p : window.fresh) {
    const Vec3 p_L(p.x, p.y, p.z);
    const double range = p_L.norm();
    if (!(range >= sensor_.min_range && range <= std::min(sensor_.max_range, kMaxRange))) continue;
    const Vec3 p_I = sensor_.T_imu_lidar * p_L;
    const auto cell = cell_of(p_I, 4.0);
    if (!cell || taken.find(pack(*cell)) != CellIndex::kNone) continue;
    taken.insert(pack(*cell), 0);
    all.push_back(path.point(p_I, p.t));
  }
  std::vector<SweepPoint> out;
  const std::size_t most = std::min(kQueryPoints, all.size());
  StratifiedPick choice(most, all.size(), 0);
  for (std::size_t k = 0; k < most; ++k) out.push_back(all[choice.next()]);
  return out;
}

void WideMotion::build(const ConstantMotion& known, const RegistrationLevel& level) {
  cells_.build(reference_, known, level.edge, level.softness);
}

double WideMotion::fit(const Window& window, const NavState& at, const Guess& guess) {
  const ConstantMotion known = known_motion(at);
  build(known, kLevels[1]);
  return agreement(load_points(window, at, guess.imu), known, cells_, true);
}

void WideMotion::refine(const Window& window, const NavState& at, Guess& guess) {
  const ConstantMotion known = known_motion(at);
  const std::vector<SweepPoint> points = load_points(window, at, guess.imu);
  ConstantMotion motion = known;
  for (const RegistrationLevel& level : kLevels) {
    build(known, level);
    for (int i = 0; i < level.iterations; ++i) {
      MotionNormal sum;
      sum.add_prior(motion, known, kUnread);
      sum.add_matches(points, motion, cells_);
      if (sum.step(motion) < 1e-3) break;
    }
  }
  correct_rate(guess.imu, at, motion.e);
  // Half of what the points say; the second pass finds half of it left, so a quarter in all. With all of it the
  // velocity swings from window to window.
  if (acceleration_unread(window)) set_acceleration(guess.imu, at, 0.5 * (motion.g - known.g));
}

// eq. WID-1.
bool WideMotion::mend(Window& window, const NavState& at, const Vec3& rate) {
  if (window.imu.size() < 2 || !doubtful(window)) return false;
  load_reference(at);
  if (reference_.size() < kMinPoints || load_points(window, at, window.imu).size() < kMinPoints) return false;
  const std::vector<ImuSample> readings = with_knots(window.imu);
  Guess best{readings, 0};
  const double before = best.fit = fit(window, at, best);
  Guess steady{even(readings, at, rate), 0};
  steady.fit = fit(window, at, steady);
  if (steady.fit > best.fit) best = steady;
  for (int pass = 0; pass < 2; ++pass) refine(window, at, best);  // the second one where the first is linear
  if (!(fit(window, at, best) > before)) return false;
  imu_ = std::move(best.imu);
  if (window.imu_gap >= kLongGap) {  // bridged, by what is known to be no reading
    for (ImuSample& s : imu_) s.faults |= imu_fault::gyro_dead | imu_fault::acc_dead;
    window.imu_gap = 0;
  }
  window.imu = imu_;
  return true;
}

}  // namespace aslio::pipeline
