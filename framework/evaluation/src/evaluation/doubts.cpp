#include "doubts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace aslio::evaluation {

namespace {

/// Slower references are worth a word: at 5 Hz and 1 m/s^2 a straight line is 5 mm off between two samples [s].
constexpr double kSparseStep = 0.21;

/// Median step between the samples [s].
double usual_step(const Trajectory& trajectory) {
  const auto samples = trajectory.samples();
  if (samples.size() < 2) return 0;
  std::vector<TimeNs> steps;
  for (std::size_t i = 1; i < samples.size(); ++i) steps.push_back(samples[i].t - samples[i - 1].t);
  const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
  std::nth_element(steps.begin(), middle, steps.end());
  return to_seconds(*middle);
}

/// RMS distance [m] of the estimate from straight lines between its own poses at the stamps of the reference: what to
/// interpolate the reference loses, if the estimate moves as the carrier did. Nothing where it has too few poses.
std::optional<double> cost_of_interpolation(const Trajectory& estimate, const Trajectory& reference, TimeNs max_gap) {
  const auto samples = reference.samples();
  double squares = 0, n = 0;
  std::size_t next = 1;
  for (const StampedPose& pose : estimate.samples()) {
    while (next < samples.size() && samples[next].t < pose.t) ++next;
    if (next == samples.size()) break;
    const TimeNs from = samples[next - 1].t, to = samples[next].t;
    if (pose.t < from || to - from > max_gap) continue;
    const auto a = estimate.pose(from), b = estimate.pose(to);
    if (!a || !b) continue;
    const double u = static_cast<double>(pose.t - from) / static_cast<double>(to - from);
    squares += (interpolate(*a, *b, u).p - pose.T.p).squaredNorm();
    n += 1;
  }
  return n > 0 ? std::optional(std::sqrt(squares / n)) : std::nullopt;
}

void warn_of_gaps(const Trajectory& estimate, const Trajectory& reference, TimeNs max_gap, Evaluation& result) {
  const auto samples = reference.samples();
  std::size_t count = 0;
  TimeNs total = 0, longest = 0, at = 0;
  for (std::size_t i = 1; i < samples.size(); ++i) {
    const TimeNs begin = std::max(samples[i - 1].t, estimate.begin_time());
    const TimeNs end = std::min(samples[i].t, estimate.end_time());
    if (samples[i].t - samples[i - 1].t <= max_gap || end <= begin) continue;
    ++count;
    total += end - begin;
    if (end - begin <= longest) continue;
    longest = end - begin;
    at = begin;
  }
  if (count == 0) return;
  result.warnings.push_back(
      fmt::format("the reference has {} gaps of more than {:g} s, {:.1f} s in all, the longest of {:.1f} s from {:.3f} "
                  "s on: the poses there are not measured",
                  count, to_seconds(max_gap), to_seconds(total), to_seconds(longest), to_seconds(at)));
}

/// A limit of the error [m] and the points below it.
struct Step {
  double below;
  double points;
};
constexpr std::array<Step, 4> kHilti2022 = {{{0.01, 10}, {0.03, 6}, {0.06, 3}, {0.10, 1}}};
constexpr std::array<Step, 6> kHilti2023 = {{{0.005, 20}, {0.01, 10}, {0.03, 6}, {0.06, 5}, {0.10, 3}, {0.40, 1}}};

double points_of(std::span<const Step> steps, double error) {
  for (const Step& step : steps) {
    if (error < step.below) return step.points;
  }
  return 0;
}

}  // namespace

void warn_of_reference(const Trajectory& estimate, const Trajectory& reference, Evaluation& result) {
  if (result.options.rule != Rule::interpolated) return;
  const TimeNs max_gap = to_ns(result.options.max_reference_gap);
  warn_of_gaps(estimate, reference, max_gap, result);
  const double step = usual_step(reference);
  if (step < kSparseStep) return;
  const auto cost = cost_of_interpolation(estimate, reference, max_gap);
  if (!cost) return;
  result.warnings.push_back(
      fmt::format("the reference has {:.2g} Hz: to interpolate it may cost {:.3f} m (RMS, by the motion of the "
                  "estimate), which the errors hold; `association: at_reference` measures at its stamps instead",
                  1 / step, *cost));
}

void warn_of_time_offset(const Trajectory& estimate, const Trajectory& reference, Evaluation& result) {
  result.time_offset = find_time_offset(estimate, reference, to_ns(result.options.max_reference_gap));
  if (!result.time_offset) return;
  const TimeOffset& found = *result.time_offset;
  result.warnings.push_back(
      fmt::format("the stamps of the reference look {:.3f} s too {}: {:+.3f} s added to them, the positions fit to "
                  "{:.3f} m in place of {:.3f} m; nothing was shifted. If the clocks differ, set `time_offset: {:.3f}`",
                  std::abs(found.seconds), found.seconds > 0 ? "early" : "late", found.seconds, found.rmse_after,
                  found.rmse_before, found.seconds));
}

double score_of(Scoring scoring, std::span<const PosePair> pairs, const Pose& alignment, std::size_t reference_poses) {
  const std::span<const Step> steps = scoring == Scoring::hilti_2022 ? std::span<const Step>(kHilti2022) : kHilti2023;
  double points = 0;
  for (const PosePair& pair : pairs)
    points += points_of(steps, (alignment * pair.estimate.p - pair.reference.p).norm());
  return 100 * points / (steps.front().points * static_cast<double>(std::max(reference_poses, pairs.size())));
}

}  // namespace aslio::evaluation
