#pragma once

#include <cstdint>
#include <vector>

#include "aslio/core/sensor.hpp"
#include "aslio/stages/estimator.hpp"
#include "aslio/stages/overlap.hpp"
#include "aslio/stages/sampler.hpp"
#include "aslio/stream/measurement_stream.hpp"

namespace aslio::pipeline {

/// Scores coming points at the pose the IMU predicts, before any update: those that the raw samplers leave to the
/// overlap, since of others it knows nothing. Only windows that ask for it pay for it.
class PriorProbe final : public OverlapProbe {
 public:
  PriorProbe(const stream::MeasurementStream& stream, const Estimator& estimator, SamplerChain& samplers,
             OverlapMetric& overlap, const SensorModel& sensor)
      : stream_(stream), estimator_(estimator), samplers_(samplers), overlap_(overlap), sensor_(sensor) {}

  OverlapScore overlap(TimeNs t) override;

 private:
  const stream::MeasurementStream& stream_;
  const Estimator& estimator_;
  SamplerChain& samplers_;
  OverlapMetric& overlap_;
  SensorModel sensor_;
  std::vector<ImuSample> imu_;
  std::vector<PointUses> uses_;
  std::vector<std::uint32_t> left_;
  std::vector<WorldPoint> points_;
};

}  // namespace aslio::pipeline
