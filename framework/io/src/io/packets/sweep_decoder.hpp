#pragma once
/// The LiDAR decoder of messages that carry packets.

#include <memory>
#include <optional>
#include <string>

#include "../lidar_decoder.hpp"
#include "format.hpp"

namespace aslio::io::packets {

/// Whose packets a connection carries; nothing for other connections.
enum class Vendor : std::uint8_t { velodyne, hesai, ouster };
std::optional<Vendor> vendor_of(const Connection& connection);

/// Points of all packets of a sweep with their times: those of the sensor's clock, moved by one offset per sweep to the
/// clock of the receiver. The least delay of the sweep's packets gives that offset.
struct Sweep {
  std::uint32_t missing = 0;    ///< packets that should have been there
  std::uint32_t malformed = 0;  ///< skipped
  std::string first_problem;    ///< of those
};
Sweep decode_packets(const PacketFormat& format, std::span<const Packet> packets, int scan_lines, LidarPacket& out);

/// Pre: the connection has a vendor. Reads the files that `sensor` names: throws DataError where one cannot be used.
std::unique_ptr<LidarDecoder> make_sweep_decoder(const Connection& connection, const SensorConfig& sensor,
                                                 std::string where);

}  // namespace aslio::io::packets
