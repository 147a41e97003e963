#pragma once
/// The clock of a sensor, as that of the computer that receives its packets tells it.

#include <algorithm>
#include <optional>

#include "format.hpp"

namespace aslio::io::packets {

/// Moves times of a sensor's clock to the receiver's: by the least delay of packets so far, which may grow by what two
/// clocks drift apart. A clock that agrees with the receiver's to half a second is synchronised, and stays as it is.
class SensorClock {
 public:
  /// `period`: at which the sensor's clock starts anew [ns]; 0: never.
  explicit SensorClock(TimeNs period) : period_(period) {}

  /// `sensor` was read from a packet that was received at `received`. Packets in the order of reception.
  TimeNs to_receiver(TimeNs sensor, TimeNs received) {
    if (!offset_) begin(sensor, received);
    unwrapped_ += clock_difference(sensor, last_sensor_, period_);
    last_sensor_ = sensor;
    const TimeNs apart = received - unwrapped_;
    if (std::abs(apart - *offset_) > kJump) {
      begin(sensor, received);  // one of the clocks was set
    } else if (!synchronised_) {
      const TimeNs drift = std::max<TimeNs>(0, received - last_received_) / kDriftPart;
      offset_ = std::min(*offset_ + drift, apart);
    }
    last_received_ = received;
    return unwrapped_ + *offset_;
  }

 private:
  static constexpr TimeNs kJump = 2 * kSecond, kSynchronised = kSecond / 2;
  static constexpr TimeNs kDriftPart = 10'000;  ///< 100 ppm: more than crystals do

  void begin(TimeNs sensor, TimeNs received) {
    unwrapped_ = last_sensor_ = sensor;
    last_received_ = received;
    const TimeNs apart = clock_difference(received, sensor, period_);
    synchronised_ = std::abs(apart) < kSynchronised;
    offset_ = received - sensor - (synchronised_ ? apart : 0);
  }

  TimeNs period_, unwrapped_ = 0, last_sensor_ = 0, last_received_ = 0;
  std::optional<TimeNs> offset_;
  bool synchronised_ = false;
};

}  // namespace aslio::io::packets
