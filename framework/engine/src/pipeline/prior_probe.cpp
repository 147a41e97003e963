#include "prior_probe.hpp"

#include <algorithm>

#include "aslio/core/spread.hpp"
#include "imu_gap.hpp"

namespace aslio::pipeline {

OverlapScore PriorProbe::overlap(TimeNs t) {
  constexpr std::size_t kMaxPoints = 2000;  // enough for a share to 1 %
  const NavState& from = estimator_.state();
  points_.clear();
  if (!estimator_.uses_imu()) {
    imu_ = {{.t = from.t}, {.t = t}};
  } else {
    stream_.imu_covering(from.t, t, imu_);
    if (!can_be_reckoned(imu_)) return {};
  }
  const Pose begin = from.pose();
  const Pose end = estimator_.predict(imu_).pose();
  const auto raw = stream_.points(from.t, t);
  uses_.assign(raw.size(), mask(PointUse::overlap));
  SampleBatch batch{raw, {}, uses_};
  samplers_.sample(Sampler::ActsOn::raw, batch);
  left_.clear();
  for (std::uint32_t i = 0; i < raw.size(); ++i) {
    if (uses_[i] != 0) left_.push_back(i);
  }
  const std::size_t taken = overlap_.frames_reach_back() ? left_.size() : std::min(left_.size(), kMaxPoints);
  const double span = to_seconds(t - from.t);
  StratifiedPick choice(taken, left_.size(), 0);
  for (std::size_t k = 0; k < taken; ++k) {
    const std::uint32_t i = left_[choice.next()];
    const TimedPoint& p = raw[i];
    const Vec3 p_L(p.x, p.y, p.z);
    const Pose T = interpolate(begin, end, to_seconds(p.t - from.t) / span);
    points_.push_back(
        {T * (sensor_.T_imu_lidar * p_L), p.t, static_cast<float>(p_L.norm()), p.intensity, i, p.line, p.feature});
  }
  return overlap_.evaluate(points_, t);
}

}  // namespace aslio::pipeline
