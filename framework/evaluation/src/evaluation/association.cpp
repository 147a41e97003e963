#include "aslio/evaluation/association.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "aslio/core/errors.hpp"

namespace aslio::evaluation {

namespace {

// Differences in double: stamps read with a wrong unit may be so far apart that int64 overflows.
double seconds_between(TimeNs from, TimeNs to) { return 1e-9 * (static_cast<double>(to) - static_cast<double>(from)); }

std::string range_text(const Trajectory& trajectory) {
  return fmt::format("{:.3f} s to {:.3f} s ({} poses)", to_seconds(trajectory.begin_time()),
                     to_seconds(trajectory.end_time()), trajectory.size());
}

bool overlap(const Trajectory& a, const Trajectory& b) {
  return a.begin_time() <= b.end_time() && b.begin_time() <= a.end_time();
}

/// The likely reason why two time ranges do not meet.
std::string mismatch_cause(const Trajectory& estimate, const Trajectory& reference) {
  const double ratio = seconds_between(estimate.begin_time(), estimate.end_time()) /
                       seconds_between(reference.begin_time(), reference.end_time());
  for (const double factor : {1e3, 1e6, 1e9}) {
    const char* unit = factor == 1e3 ? "ms" : factor == 1e6 ? "us" : "ns";
    const auto near = [&](double value) { return value > 0.7 * factor && value < 1.4 * factor; };
    if (near(ratio))
      return fmt::format("the estimate lasts {:.0e} times longer: are its stamps in {} (set its `time_unit`)?", factor,
                         unit);
    if (near(1.0 / ratio))
      return fmt::format("the reference lasts {:.0e} times longer: are its stamps in {} (set its `time_unit`)?", factor,
                         unit);
  }
  return fmt::format(
      "the estimate begins {:+.3f} s from the reference: is one of them in another clock (shift its "
      "stamps by this constant, `time_offset` of the reference) or of another recording?",
      seconds_between(reference.begin_time(), estimate.begin_time()));
}

void require_poses(const Trajectory& estimate, const Trajectory& reference) {
  if (estimate.empty()) throw DataError("the estimate has no pose: the run wrote nothing to evaluate");
  if (reference.empty()) throw DataError("the reference has no pose: is it the right file?");
}

void require_matches(const Association& association, const Trajectory& estimate, const Trajectory& reference,
                     const std::string& limit, const std::string& remedy) {
  if (!association.pairs.empty()) return;
  const std::string ranges =
      fmt::format("the estimate is from {}, the reference from {}", range_text(estimate), range_text(reference));
  if (!overlap(estimate, reference)) {
    throw DataError(fmt::format("estimate and reference have no time in common: {}; {}", ranges,
                                mismatch_cause(estimate, reference)));
  }
  throw DataError(fmt::format("no estimated pose has a reference {}: {}; {}", limit, ranges, remedy));
}

/// Share of the reference's duration inside gaps of the estimate of at most `max_gap`. eq. EVAL-1
double covered_share(const Trajectory& estimate, const Trajectory& reference, TimeNs max_gap) {
  const double duration = seconds_between(reference.begin_time(), reference.end_time());
  if (duration <= 0.0)
    return reference.begin_time() >= estimate.begin_time() && reference.begin_time() <= estimate.end_time();
  double covered = 0.0;
  const auto samples = estimate.samples();
  for (std::size_t i = 1; i < samples.size(); ++i) {
    if (samples[i].t - samples[i - 1].t > max_gap) continue;
    const TimeNs begin = std::max(samples[i - 1].t, reference.begin_time());
    const TimeNs end = std::min(samples[i].t, reference.end_time());
    if (end > begin) covered += seconds_between(begin, end);
  }
  return std::min(1.0, covered / duration);
}

/// Whether both neighbours of `t` are at most `most` away.
bool has_neighbours(std::span<const StampedPose> samples, TimeNs t, TimeNs most) {
  if (most == kTimeMax) return true;
  const auto next = std::lower_bound(samples.begin(), samples.end(), t,
                                     [](const StampedPose& sample, TimeNs time) { return sample.t < time; });
  if (next == samples.end()) return false;
  if (next->t == t) return true;
  return next->t - t <= most && next != samples.begin() && t - (next - 1)->t <= most;
}

/// Index of the sample nearest to `t`, the earlier of two equally near.
std::size_t nearest(std::span<const StampedPose> samples, TimeNs t) {
  const auto next = std::lower_bound(samples.begin(), samples.end(), t,
                                     [](const StampedPose& sample, TimeNs time) { return sample.t < time; });
  const auto index = static_cast<std::size_t>(next - samples.begin());
  if (index == samples.size()) return index - 1;
  if (index > 0 && seconds_between(samples[index - 1].t, t) <= seconds_between(t, samples[index].t)) return index - 1;
  return index;
}

/// Steps of the grid from `t`, where the trajectory has no pose, that may be left out: those before its next sample.
/// Years may lie between two samples. Pre: `t` is not behind the end.
TimeNs steps_without_pose(const Trajectory& trajectory, TimeNs t, TimeNs period) {
  const auto samples = trajectory.samples();
  const auto next = std::lower_bound(samples.begin(), samples.end(), t,
                                     [](const StampedPose& sample, TimeNs time) { return sample.t < time; });
  return std::max<TimeNs>(0, (next->t - t - 1) / period);
}

}  // namespace

Association associate_interpolated(const Trajectory& estimate, const Trajectory& reference, TimeNs max_reference_gap,
                                   TimeNs max_estimate_gap, TimeNs max_neighbour) {
  require_poses(estimate, reference);
  Association result;
  result.estimate_poses = estimate.size();
  for (const StampedPose& sample : estimate.samples()) {
    if (!has_neighbours(reference.samples(), sample.t, max_neighbour)) continue;
    const auto truth = reference.pose(sample.t, max_reference_gap);
    if (truth) result.pairs.push_back({sample.t, sample.T, *truth});
  }
  require_matches(result, estimate, reference,
                  fmt::format("between two samples at most {} s apart", to_seconds(max_reference_gap)),
                  "use a denser reference");
  result.covered = covered_share(estimate, reference, max_estimate_gap);
  return result;
}

Association associate_at_reference(const Trajectory& estimate, const Trajectory& reference, TimeNs max_estimate_gap) {
  require_poses(estimate, reference);
  Association result;
  result.estimate_poses = reference.size();
  for (const StampedPose& truth : reference.samples()) {
    const auto ours = estimate.pose(truth.t, max_estimate_gap);
    if (ours) result.pairs.push_back({truth.t, *ours, truth.T});
  }
  require_matches(result, estimate, reference,
                  fmt::format("at which it has poses at most {} s apart", to_seconds(max_estimate_gap)),
                  "use an estimate without gaps");
  result.covered = covered_share(estimate, reference, max_estimate_gap);
  return result;
}

Association associate_nearest(const Trajectory& estimate, const Trajectory& reference, TimeNs max_difference,
                              TimeNs max_estimate_gap) {
  require_poses(estimate, reference);
  const bool reference_shorter = reference.size() < estimate.size();
  const auto shorter = (reference_shorter ? reference : estimate).samples();
  const auto longer = (reference_shorter ? estimate : reference).samples();
  Association result;
  result.estimate_poses = shorter.size();
  for (const StampedPose& sample : shorter) {
    const StampedPose& other = longer[nearest(longer, sample.t)];
    if (std::abs(seconds_between(sample.t, other.t)) > to_seconds(max_difference)) continue;
    const StampedPose& ours = reference_shorter ? other : sample;
    const StampedPose& truth = reference_shorter ? sample : other;
    result.pairs.push_back({ours.t, ours.T, truth.T});
  }
  require_matches(result, estimate, reference, fmt::format("within {} s", to_seconds(max_difference)),
                  "interpolate (without --evo), or use a denser reference");
  result.covered = covered_share(estimate, reference, max_estimate_gap);
  return result;
}

std::vector<PosePair> associate_on_grid(const Trajectory& estimate, const Trajectory& reference, TimeNs period,
                                        TimeNs max_reference_gap, TimeNs max_estimate_gap) {
  std::vector<PosePair> pairs;
  if (estimate.empty() || reference.empty() || !overlap(estimate, reference)) return pairs;
  const TimeNs begin = std::max(estimate.begin_time(), reference.begin_time());
  const TimeNs end = std::min(estimate.end_time(), reference.end_time());
  const TimeNs past = begin % period;
  for (TimeNs t = past == 0 ? begin : past > 0 ? begin + (period - past) : begin - past; t <= end; t += period) {
    const auto ours = estimate.pose(t, max_estimate_gap);
    const auto truth = reference.pose(t, max_reference_gap);
    if (ours && truth) {
      pairs.push_back({t, *ours, *truth});
    } else {
      t += steps_without_pose(ours ? reference : estimate, t, period) * period;
    }
  }
  return pairs;
}

}  // namespace aslio::evaluation
