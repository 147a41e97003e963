#pragma once
/// Packets of LiDARs as tests make them.

#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "aslio/core/time.hpp"

namespace aslio::io::test {

using PacketBytes = std::vector<std::uint8_t>;

/// Writes a number, little-endian, of `size` bytes.
void put_number(PacketBytes& bytes, std::size_t at, std::uint64_t value, std::size_t size);

/// A data packet of Velodyne: block b has azimuth `first + step * b` [0.01 deg], and in each return the raw distance.
struct VelodynePacket {
  std::uint8_t product = 0x22, mode = 0x37;
  int first = 0, step = 40;
  std::uint32_t microseconds = 0;
  std::function<std::uint16_t(std::size_t block, std::size_t i)> distance = [](auto, auto) { return 5000; };
  std::function<std::uint16_t(std::size_t block)> flag = [](auto) { return 0xEEFF; };

  PacketBytes bytes() const;
};

/// A packet of Hesai's XT32, XT16 or QT64 (by channels), with blocks `step` apart in azimuth.
struct HesaiPacket {
  std::uint8_t channels = 32, mode = 0x37;
  unsigned first = 0, step = 18;
  std::uint32_t microseconds = 0, sequence = 0;
  std::function<std::uint16_t(std::size_t block, std::size_t channel)> distance = [](auto, auto) { return 2500; };

  PacketBytes bytes() const;
};
PacketBytes pandar40p_packet(unsigned first, std::uint16_t distance);

/// Metadata of an Ouster of 16 rows at 0 deg and 512 columns a frame, 16 to a packet.
std::string ouster_metadata(const std::string& profile);
/// A packet of that sensor with all returns at `mm`; columns are 195312 ns apart. Profile LEGACY, or
/// RNG19_RFL8_SIG16_NIR16.
PacketBytes ouster_packet(bool legacy, std::uint16_t frame, std::uint16_t first_column, TimeNs time, std::uint32_t mm);
PacketBytes ouster_imu(TimeNs time, float acc_z, float gyro_z);

/// velodyne_msgs/VelodyneScan: the packets with their times; CDR with its encapsulation, otherwise ROS1.
std::vector<std::uint8_t> velodyne_scan(TimeNs stamp, const std::vector<std::pair<TimeNs, PacketBytes>>& packets,
                                        bool cdr);

/// A UDP datagram, and how it is sent.
struct SentDatagram {
  TimeNs time = 0;
  PacketBytes payload;
  std::array<std::uint8_t, 4> source{192, 168, 1, 201};
  std::uint16_t port = 2368;
  bool vlan = false;
  std::size_t fragment_bytes = 0;  ///< 0: in one piece; otherwise a multiple of 8
  std::uint16_t id = 0;
};
enum class CaptureForm : std::uint8_t { pcap, pcapng };

/// Ethernet frames of a datagram.
std::vector<PacketBytes> ethernet_frames(const SentDatagram& datagram);
/// A capture with times in ns.
std::vector<std::uint8_t> capture(const std::vector<SentDatagram>& datagrams, CaptureForm form = CaptureForm::pcap);

}  // namespace aslio::io::test
