#include <algorithm>
#include <cmath>
#include <utility>

#include "aslio/experiment/measure.hpp"
#include "aslio/experiment/summary.hpp"

namespace aslio::experiment {

void StepCounts::add(TimeNs step) {
  shortest_ = std::min(shortest_, step);
  longest_ = std::max(longest_, step);
  ++counts_[(step + resolution_ / 2) / resolution_ * resolution_];
  while (counts_.size() > kMaxLengths) coarsen();
}

void StepCounts::coarsen() {
  resolution_ = resolution_ == 1 ? 1000 : resolution_ * 10;
  std::map<TimeNs, std::uint64_t> coarser;
  for (const auto& [step, count] : counts_) coarser[(step + resolution_ / 2) / resolution_ * resolution_] += count;
  counts_ = std::move(coarser);
}

std::optional<RateRange> StepCounts::rates() const {
  if (counts_.empty()) return std::nullopt;
  std::uint64_t total = 0;
  for (const auto& [step, count] : counts_) total += count;
  const auto at = [this](std::uint64_t rank) {
    for (const auto& [step, count] : counts_) {
      if (rank < count) return std::clamp(step, shortest_, longest_);
      rank -= count;
    }
    return longest_;
  };
  const double median = 0.5 * (to_seconds(at((total - 1) / 2)) + to_seconds(at(total / 2)));
  return RateRange{1.0 / to_seconds(longest_), 1.0 / median, 1.0 / to_seconds(shortest_)};
}

void SummaryCollector::on_update(const pipeline::UpdateRecord& record) {
  ++updates_;
  ++by_status_[static_cast<std::size_t>(record.status)];
  const WindowPlan& plan = record.plan;
  if (!first_begin_) {
    first_begin_ = plan.fresh_begin;
  } else if (!plan.partial) {
    steps_.add(plan.end - plan.fresh_begin);
  }
  if (!first_end_) first_end_ = plan.end;
  if (record.state.R.allFinite() && record.state.p.allFinite()) {
    const Vec3& p = record.state.p;
    if (last_position_) path_length_ += (p - *last_position_).norm();
    if (!first_position_) first_position_ = p;
    last_position_ = p;
    if (keeps_poses_) poses_.push_back({plan.end, record.state.pose()});
  } else if (!not_finite_) {
    not_finite_ = plan.end;
  }
  windows_ += plan.end - plan.fresh_begin;
  if (is_weak(record.status)) weak_ += plan.end - plan.fresh_begin;
  const bool initialising = record.status == UpdateStatus::initialising;
  matchable_points_ += record.update->match_points.size();
  bridged_ += record.bridged;
  bias_steps_ += record.bias_step;
  if (record.update->accepted) {
    ++accepted_;
    if (last_accepted_ && plan.end - *last_accepted_ > kMaxSilence && !silent_from_) silent_from_ = last_accepted_;
    last_accepted_ = plan.end;
    // One that was lost by this update, too fast perhaps, is not believed.
    auto learnt = calibration_of(*record.update);
    if (learnt && record.tracking != pipeline::TrackingStatus::lost) calibration_ = learnt;
  }
  // A window that starts the map does so by the points that enter it, be it when they leave the window (`on_exit`).
  const bool starts_map = initialising && (record.inserted.inserted > 0 ||
                                           (record.update->insert && !record.update->points(PointUse::map).empty()));
  if (record.update->accepted || starts_map) {
    covered_ += plan.end - plan.fresh_begin;
  } else if (record.without_view) {
    ++without_view_;
  } else if (!initialising) {
    ++refused_[static_cast<std::size_t>(record.status)];
    if (accepted_ > 0) refused_time_ += plan.end - plan.fresh_begin;
  }
}

std::optional<TimeNs> SummaryCollector::lost_at(TimeNs end) const {
  std::optional<TimeNs> silent = silent_from_;
  if (!last_accepted_) {
    silent = first_end_;
  } else if (!silent && end - *last_accepted_ > kMaxSilence) {
    silent = last_accepted_;
  }
  if (silent && not_finite_) return std::min(*silent, *not_finite_);
  return silent ? silent : not_finite_;
}

void SummaryCollector::fill(Summary& summary, const stream::MeasurementStream& stream, std::optional<TimeNs> data_end,
                            TimeNs max_gap) const {
  summary.counters = stream.counters();
  summary.imu_period_s = to_seconds(stream.imu_period());
  summary.updates = updates_;
  summary.weak_share = windows_ > 0 ? to_seconds(weak_) / to_seconds(windows_) : 0.0;
  summary.updates_by_status = by_status_;
  summary.refused_by_status = refused_;
  summary.updates_without_view = without_view_;
  summary.updates_bridged = bridged_;
  summary.gyro_bias_steps = bias_steps_;
  summary.accepted = accepted_;
  summary.matchable_points = matchable_points_;
  summary.refused_s = to_seconds(refused_time_);
  summary.rate_hz = steps_.rates();
  summary.calibration = calibration_;
  summary.path_length_m = path_length_;
  if (last_position_) summary.end_to_end_m = (*last_position_ - *first_position_).norm();
  // By how much the IMU outlasts the points; of a stream that was not read to its end it says nothing.
  const bool told = stream.finished() && stream.first_point() && stream.first_imu();
  const TimeNs outlasted = told ? stream.last_imu() - stream.last_point() : 0;
  summary.longest_imu_gap_s = to_seconds(std::max(summary.counters.longest_imu_step, -outlasted));
  summary.longest_lidar_gap_s = to_seconds(std::max(summary.counters.longest_point_step, outlasted));
  const auto first = stream.first_point();
  if (!first) return;
  summary.data_s = to_seconds(stream.last_point() - *first);
  if (!first_begin_) return;
  TimeNs covered = covered_;
  if (*first_begin_ - *first <= kInitialisationGrace) covered += std::max<TimeNs>(*first_begin_ - *first, 0);
  const TimeNs end = stream.last_point() + (outlasted > max_gap ? outlasted : 0);
  const TimeNs extent = std::max(data_end.value_or(kTimeMin), end) - *first;
  summary.coverage = extent > 0 ? std::clamp(to_seconds(covered) / to_seconds(extent), 0.0, 1.0) : 0.0;
}

}  // namespace aslio::experiment
