#pragma once
/// Raw packets of spinning LiDARs as they come by UDP, decoded without knowledge of files. One format per family of
/// sensors. Points are in the sensor's own frame, as its vendor's driver for ROS publishes them.

#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "aslio/core/measurement.hpp"

namespace aslio::io::packets {

using Bytes = std::span<const std::uint8_t>;

/// One datagram.
struct Packet {
  TimeNs received = 0;  ///< by the clock of the recording computer [ns]
  Bytes bytes;
};

/// What a packet tells without its points.
struct PacketHead {
  TimeNs time = 0;             ///< of the first firing, by the sensor's clock [ns]; that may wrap
  double turn = 0;             ///< where the sweep is at the first firing, in turns: [0, 1)
  std::uint32_t sequence = 0;  ///< counts packets, in whatever way the format compares
  std::uint32_t frame = 0;     ///< count of sweeps, where the sensor tells it
};

class PacketFormat {
 public:
  virtual ~PacketFormat() = default;
  /// Sensor and mode, and which return is kept of two: said to the user.
  virtual std::string verdict() const = 0;
  /// Empty, or what is wrong with the packet.
  virtual std::string head(Bytes packet, PacketHead& head) const = 0;
  /// Adds the points to those of `out`, and what was dropped to its counts. `begin` is the time of the first firing
  /// [ns]; lines from `scan_lines` on are dropped. Returns an empty text, or what is wrong with the packet.
  virtual std::string decode(Bytes packet, TimeNs begin, int scan_lines, LidarPacket& out) const = 0;
  /// A packet begins the next sweep. Both are of one sensor, `next` came later.
  virtual bool begins_sweep(const PacketHead& last, const PacketHead& next) const = 0;
  /// Packets that should have come between the two.
  virtual std::uint32_t missing_between(const PacketHead& last, const PacketHead& next) const = 0;
  /// At which the sensor's clock starts anew [ns]; 0: never.
  virtual TimeNs clock_period() const { return 0; }
};

/// `next - last` on a clock that starts anew every `period` [ns] (0: never): the difference of the least magnitude.
inline TimeNs clock_difference(TimeNs next, TimeNs last, TimeNs period) {
  if (period <= 0) return next - last;
  TimeNs apart = (next - last) % period;
  if (apart > period / 2) apart -= period;
  if (apart < -period / 2) apart += period;
  return apart;
}

/// True where an angle has gone back by more than packets that came in the wrong order do: the next turn has begun.
inline bool turned_over(double last_turn, double next_turn) {
  constexpr double kBack = 1.0 / 64;
  return next_turn < last_turn - kBack;
}

/// A little-endian number at `at`. Pre: it lies within.
template <class T>
T number(Bytes bytes, std::size_t at) {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < sizeof(T); ++i) value |= std::uint64_t{bytes[at + i]} << (8 * i);
  return static_cast<T>(value);
}

/// Adds a point, unless its line is none of the sensor's.
void add_point(const Vec3& p, TimeNs t, double intensity, int line, int scan_lines, LidarPacket& out);

}  // namespace aslio::io::packets
