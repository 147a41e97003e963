#include "prior_probe.hpp"

#include <algorithm>

#include "aslio/core/spread.hpp"
#include "imu_gap.hpp"

namespace aslio::pipeline {

OverlapScore PriorProbe::overlap(TimeNs t) {
  constexpr std::size_t kMostPoints = 2000;  // enough for a share to 1 %
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
  const std::size_t taken = std::min(raw.size(), kMostPoints);
  const double span = to_seconds(t - from.t);
  chosen_.clear();
  OneOfEachRun choice(taken, raw.size(), 0);
  for (std::size_t k = 0; k < taken; ++k) chosen_.push_back(raw[choice.next()]);
  taps_.assign(chosen_.size(), mask(Tap::overlap));
  SampleBatch batch{chosen_, {}, taps_};
  samplers_.sample(Sampler::ActsOn::raw, batch);
  for (std::size_t k = 0; k < chosen_.size(); ++k) {
    if (taps_[k] == 0) continue;
    const TimedPoint& p = chosen_[k];
    const Vec3 p_L(p.x, p.y, p.z);
    const Pose T = interpolate(begin, end, to_seconds(p.t - from.t) / span);
    points_.push_back({T * (sensor_.T_imu_lidar * p_L), p.t, static_cast<float>(p_L.norm()), p.intensity,
                       static_cast<std::uint32_t>(k), p.line, p.feature});
  }
  return overlap_.evaluate(points_, t);
}

}  // namespace aslio::pipeline
