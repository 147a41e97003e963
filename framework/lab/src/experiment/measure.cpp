#include "aslio/experiment/measure.hpp"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <vector>

#include "aslio/evaluation/alignment.hpp"

namespace aslio::experiment {

evaluation::Options measuring_options(const Trajectory& reference, evaluation::Rule rule) {
  evaluation::Options options;
  options.rule = rule;
  const auto samples = reference.samples();
  if (samples.size() < 2) return options;
  std::vector<TimeNs> steps;
  steps.reserve(samples.size() - 1);
  for (std::size_t i = 1; i < samples.size(); ++i) steps.push_back(samples[i].t - samples[i - 1].t);
  const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
  std::nth_element(steps.begin(), middle, steps.end());
  constexpr double kMaxGap = 1e9;  // [s] in nanoseconds it still fits
  options.max_reference_gap = std::clamp(2.5 * to_seconds(*middle), options.max_reference_gap, kMaxGap);
  return options;
}

std::optional<HeadlineRpe> headline_rpe(const evaluation::Evaluation& evaluation) {
  std::optional<evaluation::RelativeError> shortest;
  for (const auto& error : evaluation.rpe) {
    if (error.unit != evaluation::DeltaUnit::metres || (shortest && shortest->delta <= error.delta)) continue;
    shortest = error;
  }
  // Not over the next one that has pairs: another method's would be over this one.
  if (!shortest || shortest->pairs == 0) return std::nullopt;
  return HeadlineRpe{shortest->translation_rmse, shortest->delta};
}

namespace {

/// Rigid alignment of the positions seen so far, from running sums: an alignment over the whole run would spread an
/// error at its end over its beginning, and one by orientations would mind a constant rotation between the bodies.
class RunningAlignment {
 public:
  void add(const Vec3& estimate, const Vec3& truth) {
    n_ += 1.0;
    estimate_ += estimate;
    truth_ += truth;
    cross_ += truth * estimate.transpose();
  }
  /// Distance between the aligned estimate and the truth.
  double error(const Vec3& estimate, const Vec3& truth) const {
    const Vec3 mean_estimate = estimate_ / n_;
    const Vec3 mean_truth = truth_ / n_;
    const Mat3 covariance = cross_ / n_ - mean_truth * mean_estimate.transpose();
    const Eigen::JacobiSVD<Mat3> svd(covariance, Eigen::ComputeFullU | Eigen::ComputeFullV);
    const double sign = svd.matrixU().determinant() * svd.matrixV().determinant() < 0 ? -1.0 : 1.0;
    const Mat3 R = svd.matrixU() * Vec3(1, 1, sign).asDiagonal() * svd.matrixV().transpose();
    return (R * (estimate - mean_estimate) - (truth - mean_truth)).norm();
  }

 private:
  double n_ = 0;
  Vec3 estimate_ = Vec3::Zero(), truth_ = Vec3::Zero();
  Mat3 cross_ = Mat3::Zero();
};

/// Path of the reference up to each of its samples [m].
std::vector<double> travelled(const Trajectory& reference) {
  std::vector<double> path;
  for (const StampedPose& sample : reference.samples()) {
    const double step = path.empty() ? 0 : (sample.T.p - reference.samples()[path.size() - 1].T.p).norm();
    path.push_back(path.empty() ? 0 : path.back() + step);
  }
  return path;
}

/// Path at a moment, held at both ends.
double path_at(const Trajectory& reference, const std::vector<double>& path, TimeNs t) {
  const auto samples = reference.samples();
  const auto after = std::upper_bound(samples.begin(), samples.end(), t,
                                      [](TimeNs moment, const StampedPose& sample) { return moment < sample.t; });
  const auto k = static_cast<std::size_t>(after - samples.begin());
  if (k == 0 || k == samples.size()) return k == 0 ? 0 : path.back();
  const double share = to_seconds(t - samples[k - 1].t) / to_seconds(samples[k].t - samples[k - 1].t);
  return path[k - 1] + share * (path[k] - path[k - 1]);
}

/// Lays the estimate on the reference by the poses of its first second that the reference covers.
std::optional<Pose> laid_on(std::span<const StampedPose> poses, const Trajectory& reference, TimeNs max_gap) {
  Mat3 rotations = Mat3::Zero();
  std::vector<evaluation::PosePair> pairs;
  for (const StampedPose& estimate : poses) {
    if (!pairs.empty() && estimate.t > pairs.front().t + kSecond) break;
    const auto truth = reference.pose(estimate.t, max_gap);
    if (!truth) continue;
    pairs.push_back({estimate.t, estimate.T, *truth});
    rotations += truth->R * estimate.T.R.transpose();
  }
  if (pairs.empty()) return std::nullopt;
  const Mat3 R = evaluation::nearest_rotation(rotations);
  Vec3 shift = Vec3::Zero();
  for (const evaluation::PosePair& pair : pairs) shift += pair.reference.p - R * pair.estimate.p;
  return Pose{R, shift / static_cast<double>(pairs.size())};
}

double laid_error(const Pose& laid, const StampedPose& estimate, const Pose& truth) {
  return (laid.R * estimate.T.p + laid.p - truth.p).norm();
}

bool is_off(double error, double path) { return error > kDivergedError && error > kDivergedShare * path; }

TimeNs reference_gap(const Trajectory& reference) {
  return to_ns(measuring_options(reference, evaluation::Rule::interpolated).max_reference_gap);
}

}  // namespace

std::optional<double> failed_after(std::span<const StampedPose> poses, const Trajectory& reference,
                                   std::optional<TimeNs> other, bool positions_only) {
  if (reference.samples().size() < 2) return std::nullopt;
  const TimeNs max_gap = reference_gap(reference);
  const std::vector<double> path = travelled(reference);
  const auto share = [&](TimeNs t) { return path.back() > 0 ? path_at(reference, path, t) / path.back() : 0.0; };
  if (positions_only) {
    const auto found = find_divergence(poses, reference);
    const TimeNs at = std::min(found ? found->first : kTimeMax, other.value_or(kTimeMax));
    return found || other ? std::optional(share(at)) : std::nullopt;
  }
  const auto laid = laid_on(poses, reference, max_gap);
  if (!laid) return other ? std::optional(share(*other)) : std::optional(0.0);
  for (const StampedPose& estimate : poses) {
    if (other && estimate.t >= *other) break;
    const auto truth = reference.pose(estimate.t, max_gap);
    if (!truth) continue;
    if (is_off(laid_error(*laid, estimate, *truth), path_at(reference, path, estimate.t))) return share(estimate.t);
  }
  return other ? std::optional(share(*other)) : std::nullopt;
}

DivergenceWatch::DivergenceWatch(const Trajectory& reference, bool positions_only)
    : reference_(reference),
      positions_only_(positions_only),
      max_gap_(reference_gap(reference)),
      path_(travelled(reference)) {}

std::optional<std::pair<TimeNs, std::string>> DivergenceWatch::look(std::span<const StampedPose> poses) {
  if (poses.size() == looked_) return std::nullopt;
  looked_ = poses.size();
  if (reference_.samples().size() < 2) return std::nullopt;
  const TimeNs now = poses.back().t;
  if (positions_only_) {
    if (now < next_) return std::nullopt;
    next_ = now + kSecond;
    const auto found = find_divergence(poses, reference_);
    return found && now > found->first + kMaxSilence ? found : std::nullopt;
  }
  if (!laid_) {
    for (; seen_ < poses.size() && !first_; ++seen_) {
      if (reference_.pose(poses[seen_].t, max_gap_)) first_ = poses[seen_].t;
    }
    if (!first_ || now <= *first_ + kSecond) return std::nullopt;
    laid_ = laid_on(poses, reference_, max_gap_);
    seen_ = 0;
  }
  for (; seen_ < poses.size() && !failed_; ++seen_) {
    if (off_limits(poses[seen_])) failed_ = poses[seen_].t;
  }
  if (!failed_ || now <= *failed_ + kMaxSilence || now < next_) return std::nullopt;
  next_ = now + kSecond;
  return find_divergence(poses, reference_);
}

bool DivergenceWatch::off_limits(const StampedPose& estimate) const {
  const auto truth = reference_.pose(estimate.t, max_gap_);
  return truth && is_off(laid_error(*laid_, estimate, *truth), path_at(reference_, path_, estimate.t));
}

std::optional<std::pair<TimeNs, std::string>> find_divergence(std::span<const StampedPose> poses,
                                                              const Trajectory& reference) {
  const TimeNs max_gap = reference_gap(reference);
  const auto samples = reference.samples();
  std::size_t next = 0;  // of the reference's samples, not yet part of the path
  double path = 0;       // [m] since the first matched pose, to the last sample before the current one
  bool started = false;
  Vec3 last = Vec3::Zero();  // end of the path
  RunningAlignment alignment;
  for (const StampedPose& estimate : poses) {
    const auto truth = reference.pose(estimate.t, max_gap);
    if (!truth) continue;
    if (!started) {
      started = true;
      last = truth->p;
      while (next < samples.size() && samples[next].t <= estimate.t) ++next;
    }
    for (; next < samples.size() && samples[next].t <= estimate.t; ++next) {
      path += (samples[next].T.p - last).norm();
      last = samples[next].T.p;
    }
    const double travelled = path + (truth->p - last).norm();
    alignment.add(estimate.T.p, truth->p);
    const double error = alignment.error(estimate.T.p, truth->p);
    if (!is_off(error, travelled)) continue;
    return std::pair{estimate.t, fmt::format("the position is {:.2f} m from the reference after {:.2f} m of path, more "
                                             "than {:.0f} m and {:.0f} %",
                                             error, travelled, kDivergedError, 100 * kDivergedShare)};
  }
  return std::nullopt;
}

}  // namespace aslio::experiment
