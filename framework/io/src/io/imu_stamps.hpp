#pragma once
/// The stamps of an IMU as drivers give them: one per sample, or one for all samples of a packet.

#include <span>
#include <string>
#include <vector>

#include "aslio/core/measurement.hpp"

namespace aslio::io {

struct ImuStamps {
  TimeNs burst_period = 0;  ///< time between packets whose samples share a stamp [ns]; 0: each sample has its own
  std::string verdict;      ///< empty: nothing to say
};

/// By the first samples. Throws DataError for stamps that tell no time (all alike, whole seconds). `where`: file and
/// topic.
ImuStamps judge_imu_stamps(std::span<const ImuSample> samples, const std::string& where);

/// Spreads the samples of a packet over the time since the one before: the stamp is that of the last.
class ImuSpreader {
 public:
  explicit ImuSpreader(TimeNs burst_period = 0) : period_(burst_period) {}
  /// Samples that are ready go to `out`: those of the packet before, once the next one begins.
  void add(const ImuSample& sample, std::vector<ImuSample>& out);
  void flush(std::vector<ImuSample>& out);

 private:
  TimeNs period_;
  std::vector<ImuSample> packet_;
};

}  // namespace aslio::io
