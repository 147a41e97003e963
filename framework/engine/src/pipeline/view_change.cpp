#include "aslio/pipeline/view_change.hpp"

#include <algorithm>
#include <cmath>

#include "octahedral.hpp"

namespace aslio::pipeline {

ViewChange::ViewChange(const SensorModel& sensor)
    : sensor_(sensor), slot_(std::max(kShortestSlot, to_ns(sensor.sweep_period))), blind_(slot_ * 5 / 2) {}

void ViewChange::forget() {
  now_.fill({});
  before_.fill({});
  slot_begin_ = last_point_ = kTimeMin;
}

std::optional<double> ViewChange::add(std::span<const TimedPoint> points, const TrajectoryModel& poses, TimeNs t) {
  ended_ = false;
  if (points.empty()) return std::nullopt;
  if (last_point_ > kTimeMin && points.front().t - last_point_ > blind_) forget();
  last_point_ = points.back().t;
  const std::size_t stride = points.size() / kMaxPoints + 1;
  TimeNs posed = kTimeMin;
  Eigen::Matrix3f R = Eigen::Matrix3f::Identity();
  for (std::size_t i = 0; i < points.size(); i += stride) {
    const TimedPoint& point = points[i];
    const Eigen::Vector3f p(point.x, point.y, point.z);
    const float range = p.norm();
    if (!(range >= static_cast<float>(sensor_.min_range) && range <= static_cast<float>(sensor_.max_range))) continue;
    if (posed == kTimeMin || point.t - posed > kPose) {
      posed = point.t;
      R = (poses.pose(point.t).R * sensor_.T_imu_lidar.R).cast<float>();
    }
    const Eigen::Vector3f d = R * p;
    const float sum = d.cwiseAbs().sum();
    if (!std::isfinite(sum)) return std::nullopt;
    if (!(sum > 0)) continue;
    Cell& cell = now_[octahedral_cell(d, sum, kSide)];
    cell.sum += std::log(range);
    ++cell.n;
  }
  if (slot_begin_ == kTimeMin) slot_begin_ = points.front().t;
  ended_ = t - slot_begin_ >= slot_ - kSlack;
  if (!ended_) return std::nullopt;
  const auto change = compare();
  // What a blind slot did not see stays to be compared with.
  const bool seen = std::any_of(now_.begin(), now_.end(), [](const Cell& c) { return c.n > 0; });
  if (seen) before_ = now_;
  now_.fill({});
  slot_begin_ = t;
  return change;
}

std::optional<double> ViewChange::compare() const {
  double sum = 0;
  int n = 0;
  for (std::size_t i = 0; i < now_.size(); ++i) {
    const Cell &a = now_[i], &b = before_[i];
    if (a.n == 0 || b.n == 0) continue;
    const double change =
        static_cast<double>(a.sum) / static_cast<double>(a.n) - static_cast<double>(b.sum) / static_cast<double>(b.n);
    sum += std::min(std::abs(change), kMax);
    ++n;
  }
  return n < kMin ? std::nullopt : std::optional(sum / n);
}

}  // namespace aslio::pipeline
