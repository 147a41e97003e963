#pragma once

#include <vector>

#include "aslio/core/sensor.hpp"
#include "aslio/stages/estimator.hpp"
#include "aslio/stages/overlap.hpp"
#include "aslio/stream/measurement_stream.hpp"

namespace aslio::pipeline {

/// Scores coming points at the pose the IMU predicts, before any update. Only windows that ask for it pay for it.
class PriorProbe final : public OverlapProbe {
 public:
  PriorProbe(const stream::MeasurementStream& stream, const Estimator& estimator, OverlapMetric& overlap,
             const SensorModel& sensor)
      : stream_(stream), estimator_(estimator), overlap_(overlap), sensor_(sensor) {}

  OverlapScore overlap(TimeNs t) override;

 private:
  const stream::MeasurementStream& stream_;
  const Estimator& estimator_;
  OverlapMetric& overlap_;
  SensorModel sensor_;
  std::vector<ImuSample> imu_;
  std::vector<WorldPoint> points_;
};

}  // namespace aslio::pipeline
