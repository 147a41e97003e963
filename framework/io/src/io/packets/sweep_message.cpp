#include "sweep_message.hpp"

#include <fmt/format.h>

#include "../decode/wire.hpp"
#include "velodyne.hpp"

namespace aslio::io::packets {
namespace {

enum class Layout : std::uint8_t { velodyne, fixed, dynamic };

constexpr std::size_t kFixedBytes = 1500;

std::size_t least_bytes(Layout layout) {
  constexpr std::size_t kTime = 8, kSize = 4;
  if (layout == Layout::velodyne) return kTime + kVelodyneDataBytes;
  return layout == Layout::fixed ? kTime + kFixedBytes + kSize : kTime + 2 * kSize;
}

Packet read_packet(decode::Wire& wire, Layout layout) {
  Packet packet;
  wire.align(4);
  packet.received = wire.time();
  if (layout == Layout::velodyne) {
    packet.bytes = wire.take(kVelodyneDataBytes);
    return packet;
  }
  packet.bytes = wire.take(layout == Layout::fixed ? kFixedBytes : wire.get<std::uint32_t>());
  const std::uint32_t size = wire.get<std::uint32_t>();
  if (size < packet.bytes.size()) packet.bytes = packet.bytes.first(size);
  return packet;
}

std::string parse_as(const decode::Message& message, Layout layout, SweepMessage& sweep) {
  decode::Wire wire(message);
  sweep.packets.clear();
  sweep.stamp = wire.header();
  const std::uint32_t count = wire.get<std::uint32_t>();
  if (!wire.ok()) return wire.problem("a scan of packets");
  if (count > wire.left() / least_bytes(layout) + 1) {
    return fmt::format("it claims {} packets where {} bytes are left", count, wire.left());
  }
  sweep.packets.reserve(count);
  for (std::uint32_t i = 0; i < count && wire.ok(); ++i) sweep.packets.push_back(read_packet(wire, layout));
  if (!wire.ok()) return wire.problem(fmt::format("a scan of {} packets", count));
  constexpr std::size_t kPadding = 3;  // of CDR, behind the last value
  if (wire.left() > (wire.cdr() ? kPadding : 0)) {
    return fmt::format("{} bytes are left behind its {} packets", wire.left(), count);
  }
  return {};
}

void put(std::uint32_t value, std::vector<std::uint8_t>& out) {
  for (unsigned shift = 0; shift < 32; shift += 8) out.push_back(static_cast<std::uint8_t>(value >> shift));
}

void put_time(TimeNs time, std::vector<std::uint8_t>& out) {
  put(static_cast<std::uint32_t>(time / kSecond), out);
  put(static_cast<std::uint32_t>(time % kSecond), out);
}

}  // namespace

std::string parse_sweep(const decode::Message& message, bool velodyne_scan, SweepMessage& sweep) {
  if (velodyne_scan) return parse_as(message, Layout::velodyne, sweep);
  std::string why = parse_as(message, Layout::fixed, sweep);
  if (why.empty() || parse_as(message, Layout::dynamic, sweep).empty()) return {};
  return why;
}

void encode_sweep(std::uint32_t seq, TimeNs stamp, std::string_view frame, std::span<const Packet> packets,
                  std::vector<std::uint8_t>& out) {
  out.clear();
  put(seq, out);
  put_time(stamp, out);
  put(static_cast<std::uint32_t>(frame.size()), out);
  out.insert(out.end(), frame.begin(), frame.end());
  put(static_cast<std::uint32_t>(packets.size()), out);
  for (const Packet& packet : packets) {
    put_time(packet.received, out);
    put(static_cast<std::uint32_t>(packet.bytes.size()), out);
    out.insert(out.end(), packet.bytes.begin(), packet.bytes.end());
    put(static_cast<std::uint32_t>(packet.bytes.size()), out);
  }
}

}  // namespace aslio::io::packets
