#pragma once
/// Gathers packets to sweeps.

#include <optional>
#include <string_view>
#include <vector>

#include "sensor_clock.hpp"

namespace aslio::io::packets {

class SweepSplitter {
 public:
  explicit SweepSplitter(const PacketFormat& format) : format_(format) {}

  /// Takes a packet, with the time of its first firing by the receiver's clock. True when it begins a sweep: the one
  /// before is finished.
  bool add(const PacketHead& head, TimeNs time, Bytes packet);
  /// At the end of the packets: finishes what there is. False for nothing.
  bool flush();
  /// The finished sweep as a message of ROS1 (sweep_message.hpp), stamped with the time of its first firing. Valid
  /// until the next call.
  const std::vector<std::uint8_t>& message() const { return message_; }

 private:
  struct Part {
    TimeNs time;
    std::size_t begin, size;
  };
  void finish();

  /// Beyond, a head does not turn, or turns for no sensor's sake.
  static constexpr std::size_t kMostPackets = 16'384, kMostBytes = 64 << 20;
  static constexpr TimeNs kLongest = 2 * kSecond;

  const PacketFormat& format_;
  std::optional<PacketHead> last_;
  std::vector<std::uint8_t> bytes_, message_;
  std::vector<Part> parts_;
  std::uint32_t sweeps_ = 0;
};

}  // namespace aslio::io::packets
