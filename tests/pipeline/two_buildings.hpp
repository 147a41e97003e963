#pragma once
/// A sensor that stands between two buildings, looks at one and turns to the other: on the way there is nothing to see.

#include "aslio/simulator/boxes.hpp"
#include "aslio/simulator/walk.hpp"
#include "pipeline/runs.hpp"

namespace aslio::test {

class TwoBuildings {
 public:
  static constexpr double kTurnBegin = 2.0;  ///< [s]
  /// Turns by 180 deg within `turn_duration`; the recording lasts `duration` [s].
  TwoBuildings(double turn_duration, double duration);

  Pose pose(TimeNs t) const;
  TimeNs at(double t) const { return kBegin + to_ns(t); }

  SensorModel sensor;
  Recording recording;

 private:
  static constexpr TimeNs kBegin = 1'700'000'000 * kSecond;
  LidarPacket packet(std::uint32_t sweep, TimeNs begin) const;

  simulator::BoxScene scene_;
  simulator::Walk motion_;
};

}  // namespace aslio::test
