#pragma once
/// Messages that carry the packets of about one sweep: velodyne_msgs/VelodyneScan, PandarScan of Hesai's drivers and of
/// Autoware, and the sweeps that this project makes of datagrams.

#include <string>
#include <string_view>
#include <vector>

#include "../decode/decode.hpp"
#include "format.hpp"

namespace aslio::io::packets {

/// Types of the sweeps made of datagrams: a std_msgs/Header, then packets of `time, uint8[] data, uint32 size`. The
/// definition of the connection is the metadata of the sensor, where it needs one.
inline constexpr std::string_view kVelodyneSweep = "aslio/VelodyneSweep", kHesaiSweep = "aslio/HesaiSweep",
                                  kOusterSweep = "aslio/OusterSweep";

struct SweepMessage {
  TimeNs stamp = 0;
  std::vector<Packet> packets;  ///< as long as the message lives
};

/// Empty, or what is wrong with the message. Its type tells whether packets are of 1206 bytes; otherwise those of 1500
/// with a length, and of any length, are told apart by what fits.
std::string parse_sweep(const decode::Message& message, bool velodyne_scan, SweepMessage& sweep);

/// A sweep in ROS1's encoding; replaces the content of `out`.
void encode_sweep(std::uint32_t seq, TimeNs stamp, std::string_view frame, std::span<const Packet> packets,
                  std::vector<std::uint8_t>& out);

}  // namespace aslio::io::packets
