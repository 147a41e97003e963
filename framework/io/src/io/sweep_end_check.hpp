#pragma once
/// Whether sweeps end after their messages were recorded: then their stamps are not of the moment that they are read
/// as.

#include <cstddef>
#include <string>
#include <vector>

#include "aslio/core/measurement.hpp"
#include "aslio/core/time.hpp"

namespace aslio::io {

class SweepEndCheck {
 public:
  explicit SweepEndCheck(TimeNs sweep_period) : sweep_period_(sweep_period) {}

  /// `header`: the stamp as sent; `arrival`: the time of recording on the clock of the stamps. [ns]
  void add(const LidarPacket& packet, TimeNs header, TimeNs arrival);
  /// Once enough messages were added.
  bool decided() const { return beyond_.size() >= kMessages; }
  /// Empty: nothing is wrong, or the times of recording tell nothing, as after a conversion that takes the stamps for
  /// them.
  std::string doubt() const;

 private:
  static constexpr std::size_t kMessages = 20;

  TimeNs sweep_period_;
  std::vector<TimeNs> beyond_, lags_;  ///< of the last point beyond the arrival; of the arrival beyond the stamp
};

}  // namespace aslio::io
