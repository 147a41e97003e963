#include "aslio/evaluation/time_offset.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "aslio/core/errors.hpp"
#include "aslio/evaluation/alignment.hpp"

namespace aslio::evaluation {

namespace {

constexpr std::size_t kMostPoses = 400, kFewestPairs = 20;
constexpr double kNear = 0.5, kFar = 60.0;        // [s]
constexpr double kStep = 0.05;                    // [s] of the search within kNear
constexpr double kSpeedStep = 0.2;                // [s] of the speeds
constexpr double kSmallest = 0.005;               // [s], [m] no offset, and no error, below it is worth a word
constexpr double kClearShare = 0.6;               // of the error that is left: of one that drifts more is
constexpr double kAlike = 0.8, kMoreAlike = 0.2;  // correlations of speeds

class Fit {
 public:
  Fit(const Trajectory& estimate, const Trajectory& reference, TimeNs max_gap)
      : reference_(reference), max_gap_(max_gap) {
    const auto samples = estimate.samples();
    const std::size_t stride = samples.size() / kMostPoses + 1;
    for (std::size_t i = 0; i < samples.size(); i += stride) chosen_.push_back(samples[i]);
  }

  /// RMSE of the positions [m], with `offset` [s] added to the stamps of the reference; infinite where too few match.
  double rmse(double offset) const {
    std::vector<PosePair> pairs;
    for (const StampedPose& pose : chosen_) {
      const auto truth = reference_.pose(pose.t - to_ns(offset), max_gap_);
      if (truth) pairs.push_back({pose.t, pose.T, *truth});
    }
    constexpr double kNone = std::numeric_limits<double>::infinity();
    if (pairs.size() < kFewestPairs || 2 * pairs.size() < chosen_.size()) return kNone;
    try {
      const Pose T = align(Alignment::se3, pairs, std::vector<double>(pairs.size(), 1.0));
      double squares = 0;
      for (const PosePair& pair : pairs) squares += (T * pair.estimate.p - pair.reference.p).squaredNorm();
      return std::sqrt(squares / static_cast<double>(pairs.size()));
    } catch (const DataError&) {  // positions on a line
      return kNone;
    }
  }

  /// The offset within kNear of `centre` that fits best.
  double best_near(double centre) const {
    double best = centre, least = rmse(centre);
    for (double d = -kNear; d <= kNear + 1e-9; d += kStep) {
      const double error = rmse(centre + d);
      if (error < least) {
        least = error;
        best = centre + d;
      }
    }
    return refined(best - kStep, best + kStep);
  }

 private:
  /// By golden sections, to 0.1 ms.
  double refined(double low, double high) const {
    constexpr double kGolden = 0.6180339887498949;
    double a = high - kGolden * (high - low), b = low + kGolden * (high - low);
    double at_a = rmse(a), at_b = rmse(b);
    while (high - low > 1e-4) {
      if (at_a < at_b) {
        high = b;
        b = a;
        at_b = at_a;
        a = high - kGolden * (high - low);
        at_a = rmse(a);
      } else {
        low = a;
        a = b;
        at_a = at_b;
        b = low + kGolden * (high - low);
        at_b = rmse(b);
      }
    }
    return 0.5 * (low + high);
  }

  const Trajectory& reference_;
  TimeNs max_gap_;
  std::vector<StampedPose> chosen_;
};

/// Speeds at the steps of a grid from `begin` [m/s]; NaN where there is no pose.
std::vector<double> speeds(const Trajectory& trajectory, TimeNs begin, std::size_t count, TimeNs max_gap) {
  std::vector<double> out;
  const TimeNs step = to_ns(kSpeedStep);
  auto before = trajectory.pose(begin, max_gap);
  for (std::size_t i = 1; i <= count; ++i) {
    const auto now = trajectory.pose(begin + static_cast<TimeNs>(i) * step, max_gap);
    out.push_back(before && now ? (now->p - before->p).norm() / kSpeedStep : std::nan(""));
    before = now;
  }
  return out;
}

/// Correlation of a[i] with b[i - lag] where both are; 0 of less than half of them.
double correlation(const std::vector<double>& a, const std::vector<double>& b, std::ptrdiff_t lag) {
  double n = 0, sa = 0, sb = 0, saa = 0, sbb = 0, sab = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const std::ptrdiff_t j = static_cast<std::ptrdiff_t>(i) - lag;
    if (j < 0 || j >= static_cast<std::ptrdiff_t>(b.size())) continue;
    const double x = a[i], y = b[static_cast<std::size_t>(j)];
    if (std::isnan(x) || std::isnan(y)) continue;
    n += 1;
    sa += x, sb += y, saa += x * x, sbb += y * y, sab += x * y;
  }
  if (2 * n < static_cast<double>(a.size())) return 0;
  const double va = saa - sa * sa / n, vb = sbb - sb * sb / n;
  return va > 0 && vb > 0 ? (sab - sa * sb / n) / std::sqrt(va * vb) : 0;
}

/// The offset at which the speeds agree, where they do far better than as they stand; else 0.
double far_offset(const Trajectory& estimate, const Trajectory& reference, TimeNs max_gap) {
  constexpr std::size_t kMostSteps = 5000;
  const TimeNs begin = std::max(estimate.begin_time(), reference.begin_time());
  const TimeNs end = std::min(estimate.end_time(), reference.end_time());
  const auto count =
      std::min(kMostSteps, static_cast<std::size_t>(std::max(0.0, to_seconds(end - begin) / kSpeedStep)));
  const auto ours = speeds(estimate, begin, count, kSecond), theirs = speeds(reference, begin, count, max_gap);
  const auto most = std::min(static_cast<std::ptrdiff_t>(kFar / kSpeedStep), static_cast<std::ptrdiff_t>(count / 2));
  const double now = correlation(ours, theirs, 0);
  double best = now;
  std::ptrdiff_t at = 0;
  for (std::ptrdiff_t lag = -most; lag <= most; ++lag) {
    const double value = correlation(ours, theirs, lag);
    if (value > best) {
      best = value;
      at = lag;
    }
  }
  return best > kAlike && best > now + kMoreAlike ? kSpeedStep * static_cast<double>(at) : 0.0;
}

}  // namespace

std::optional<TimeOffset> find_time_offset(const Trajectory& estimate, const Trajectory& reference, TimeNs max_gap) {
  if (estimate.size() < kFewestPairs || reference.size() < 2) return std::nullopt;
  const Fit fit(estimate, reference, max_gap);
  const double before = fit.rmse(0);
  if (!std::isfinite(before) || before < kSmallest) return std::nullopt;
  const double offset = fit.best_near(far_offset(estimate, reference, max_gap));
  const double after = fit.rmse(offset);
  if (std::abs(offset) < kSmallest || !(after < kClearShare * before)) return std::nullopt;
  return TimeOffset{offset, before, after};
}

}  // namespace aslio::evaluation
