#include "aslio/pipeline/range_noise.hpp"

#include <algorithm>
#include <cmath>

namespace aslio::pipeline {

namespace {

/// Slots of time of which one in kSlots is looked at: enough is seen in it, at a quarter of the cost.
constexpr TimeNs kSlot = 4'000'000;
constexpr TimeNs kSlots = 4;
/// A step of time that differs by more than this share from the one before ends a run: a ray between did not return.
constexpr TimeNs kUneven = 4;
/// The longest step between points of a line: those of slower ones are too far apart for a smooth curve [ns].
constexpr TimeNs kLongestStep = kSecond / 2000;
/// Ratios of the histogram: exp(kLowest) to exp(kLowest + kBins * kBinWidth), 1/50 to 60.
constexpr double kLowest = -3.9, kBinWidth = 0.02;
/// Groups before anything is said, and those after which all counts are halved, so that the old is forgotten.
constexpr std::uint32_t kEnough = 400, kMax = 40000;
/// A quantile so low that half of the groups may lie on clutter: it is then the upper limit of the smooth ones' middle.
/// Of a chi-square with 9 degrees of freedom over 9, the root of that quantile.
constexpr double kQuantile = 0.3, kAtQuantile = 0.8428;

// Beyond these the noise differs clearly from what is counted on.
constexpr double kDeadBand = 1.35, kBack = 1.2, kHold = 1.25;
constexpr double kMaxScale = 4, kStep = 0.125;

/// Orthonormal polynomials of degree 1 and 2 over the points of a group.
template <std::size_t N>
struct Polynomials {
  std::array<double, N> first{}, second{};
  Polynomials() {
    double norm_1 = 0, norm_2 = 0;
    constexpr double n = N, mean_square = (n * n - 1) / 12;
    for (std::size_t i = 0; i < N; ++i) {
      const double x = static_cast<double>(i) - 0.5 * (n - 1);
      first[i] = x;
      second[i] = x * x - mean_square;
      norm_1 += first[i] * first[i];
      norm_2 += second[i] * second[i];
    }
    for (std::size_t i = 0; i < N; ++i) {
      first[i] /= std::sqrt(norm_1);
      second[i] /= std::sqrt(norm_2);
    }
  }
};

}  // namespace

void RangeNoiseParams::describe(config::Binder& b, RangeNoiseParams& p) {
  b.optional_real("tuned_for", p.tuned_for, "m", {.min = 1e-4, .max = 1.0}, "lengths are absolute",
                  "range noise that sigma, thickness and kernel width of this file were chosen for: they grow "
                  "with range_sigma of the sensor file");
  b.flag("adapt", p.adapt, "with tuned_for: they grow, too, where a run sees clearly more noise than is declared");
}

void RangeNoiseMeter::observe(std::span<const TimedPoint> points) {
  const auto earlier = [](const TimedPoint& point, TimeNs t) { return point.t < t; };
  for (auto at = points.begin(); at != points.end();) {
    const TimeNs slot = at->t / kSlot;
    if (slot % kSlots != 0) {
      at = std::lower_bound(at + 1, points.end(), (slot - slot % kSlots + kSlots) * kSlot, earlier);
      continue;
    }
    add(*at++);
  }
}

void RangeNoiseMeter::add(const TimedPoint& point) {
  Run& run = runs_[point.line];
  const double x = static_cast<double>(point.x), y = static_cast<double>(point.y), z = static_cast<double>(point.z);
  const double range = std::sqrt(x * x + y * y + z * z);
  const TimeNs step = point.t - run.last;
  run.last = point.t;
  const bool near = range >= sensor_.min_range && range <= sensor_.max_range && step > 0 && step <= kLongestStep;
  if (!near || run.count == 0) {
    run.count = near ? 1 : 0;
    run.range[0] = range;
    return;
  }
  if (run.count > 1 && std::abs(step - run.step) * kUneven > run.step) {
    run.count = 1;
    run.range[0] = range;
    return;
  }
  run.step = step;
  run.range[run.count++] = range;
  if (run.count < kGroup) return;
  judge(run.range);
  run.count = 0;
}

/// eq. NOI-1.
void RangeNoiseMeter::judge(const std::array<double, kGroup>& range) {
  static const Polynomials<kGroup> polynomials;
  double mean = 0;
  for (const double r : range) mean += r / static_cast<double>(kGroup);
  double squares = 0, slope = 0, bend = 0;
  for (std::size_t i = 0; i < kGroup; ++i) {
    const double d = range[i] - mean;
    squares += d * d;
    slope += d * polynomials.first[i];
    bend += d * polynomials.second[i];
  }
  const double rest = std::max(0.0, squares - slope * slope - bend * bend);
  const double sigma = std::sqrt(rest / static_cast<double>(kGroup - 3));
  count(sigma / (sensor_.range_sigma + sensor_.range_sigma_growth * mean));
}

void RangeNoiseMeter::count(double ratio) {
  if (!std::isfinite(ratio)) return;
  const double bin = (std::log(std::max(ratio, 1e-6)) - kLowest) / kBinWidth;
  const auto last = static_cast<double>(kBins - 1);
  ++histogram_[static_cast<std::size_t>(std::clamp(bin, 0.0, last))];
  if (++groups_ < kMax) return;
  groups_ = 0;
  for (std::uint32_t& n : histogram_) {
    n /= 2;
    groups_ += n;
  }
}

std::optional<double> RangeNoiseMeter::ratio() const {
  if (groups_ < kEnough) return std::nullopt;
  const double wanted = kQuantile * static_cast<double>(groups_);
  double below = 0;
  for (std::size_t i = 0; i < kBins; ++i) {
    const auto own = static_cast<double>(histogram_[i]);
    if (below + own >= wanted && own > 0) {
      const double bin = static_cast<double>(i) + (wanted - below) / own;
      return std::exp(kLowest + kBinWidth * bin) / kAtQuantile;
    }
    below += own;
  }
  return std::nullopt;
}

RangeNoise::RangeNoise(const RangeNoiseParams& params, const SensorModel& sensor)
    : params_(params),
      range_sigma_(sensor.range_sigma),
      declared_(params.tuned_for ? sensor.range_sigma / *params.tuned_for : 1.0),
      meter_(sensor) {}

/// eq. NOI-2.
void RangeNoise::observe(std::span<const TimedPoint> points) {
  meter_.observe(points);
  if (!params_.tuned_for || !params_.adapt) return;
  const auto ratio = meter_.ratio();
  if (!ratio) return;
  if (seen_ == 1.0 ? *ratio <= kDeadBand : (*ratio <= kHold * seen_ && kHold * *ratio >= seen_ && *ratio > kBack))
    return;
  seen_ = *ratio > kBack ? std::clamp(std::round(*ratio / kStep) * kStep, 1.0, kMaxScale) : 1.0;
}

std::optional<double> RangeNoise::range_sigma_seen() const {
  const auto ratio = meter_.ratio();
  if (!ratio) return std::nullopt;
  return *ratio * range_sigma_;
}

}  // namespace aslio::pipeline
