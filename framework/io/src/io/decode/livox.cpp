#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "decode.hpp"
#include "wire.hpp"

namespace aslio::io::decode {
namespace {

constexpr std::size_t kPointBytes = 19;  // offset_time u32, x y z f32, reflectivity, tag, line u8; packed in ROS1
constexpr std::size_t kAligned = 20;  // in CDR each point begins at a multiple of 4, the last one ends without padding

}  // namespace

std::string decode_livox(const Message& message, const LivoxRule& rule, LidarPacket& packet, LivoxFacts& facts) {
  Wire wire(message);
  facts = LivoxFacts{};
  facts.stamp = packet.stamp = wire.header();
  const std::uint64_t timebase = wire.get<std::uint64_t>();
  facts.declared = wire.get<std::uint32_t>();
  facts.lidar_id = wire.get<std::uint8_t>();
  wire.take(3);  // rsvd
  const std::uint32_t count = wire.get<std::uint32_t>();
  if (!wire.ok()) return wire.problem("a CustomMsg");
  const std::size_t stride = wire.cdr() ? kAligned : kPointBytes;
  const std::uint64_t bytes = count == 0 ? 0 : (count - std::uint64_t{1}) * stride + kPointBytes;
  if (bytes > wire.left()) {
    return fmt::format("it claims {} points where {} bytes are left", count, wire.left());
  }
  if (!rule.from_header && timebase > static_cast<std::uint64_t>(kTimeMax - 10 * kSecond)) {
    return fmt::format("its time base {} is no time", timebase);
  }
  facts.timebase = static_cast<TimeNs>(std::min(timebase, static_cast<std::uint64_t>(kTimeMax)));
  facts.present = count;
  const TimeNs base = (rule.from_header ? packet.stamp : facts.timebase) + rule.shift;
  const std::uint8_t* from = wire.take(bytes).data();
  const bool swapped = wire.swapped();
  packet.points.clear();
  packet.beyond_lines = 0;
  if (rule.lidar_id >= 0 && facts.lidar_id != rule.lidar_id) {
    packet.dropped_invalid = 0;
    return {};
  }
  packet.points.reserve(count);
  const std::uint32_t longest = static_cast<std::uint32_t>(std::min<TimeNs>(rule.longest_offset, 0xFFFFFFFF));
  const int lines = std::min(rule.scan_lines, 256);
  for (std::uint32_t i = 0; i < count; ++i, from += stride) {
    const auto offset = load<std::uint32_t>(from, swapped);
    std::array<float, 3> p{};
    for (std::size_t axis = 0; axis < 3; ++axis) p[axis] = load<float>(from + 4 + 4 * axis, swapped);
    const std::uint8_t tag = from[17], line = from[18], returns = tag & 0x30U;
    const bool noise = rule.tag_filter && returns != 0x00 && returns != 0x10;
    const bool damaged = rule.timed && offset > longest;
    if (noise || damaged || !is_return(p[0], p[1], p[2])) continue;
    if (line >= lines) {
      ++packet.beyond_lines;
      packet.highest_line = std::max(packet.highest_line, line);
      continue;
    }
    TimedPoint& point = packet.points.emplace_back();
    point.x = p[0];
    point.y = p[1];
    point.z = p[2];
    point.intensity = from[16];
    point.t = base + (rule.timed ? offset : 0U);
    point.sweep_id = packet.sweep_id;
    point.line = line;
    point.tag = tag;
  }
  facts.valid = static_cast<std::uint32_t>(packet.points.size());
  packet.dropped_invalid = count - packet.points.size();
  return {};
}

}  // namespace aslio::io::decode
