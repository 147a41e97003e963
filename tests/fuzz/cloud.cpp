#include "../../framework/io/src/io/decode/cloud.hpp"

#include <array>

#include "fuzz/points.hpp"

// The first byte: how the times are read.
ASLIO_FUZZ_TARGET(cloud) {
  if (bytes.empty()) return;
  const unsigned choice = bytes[0];
  io::decode::CloudView view;
  bool systematic = false;
  const io::decode::Message message(bytes.subspan(1), choice >= 128 ? io::Encoding::cdr : io::Encoding::ros1);
  if (!io::decode::parse_cloud(message, view, systematic).empty()) return;
  io::decode::CloudRule rule;
  rule.time = io::decode::judge_cloud_times(view, {});
  must(rule.time.known || !rule.time.verdict.empty(), "a verdict says why times cannot be known");
  rule.tag_filter = (choice & 1U) != 0;
  rule.scan_lines = (choice & 2U) != 0 ? 128 : 4;
  if ((choice & 4U) != 0) {
    // As judged by a cloud before it.
    constexpr std::array<double, 4> kToNs = {1e9, 1e6, 1e3, 1};
    rule.time = {};
    rule.time.known = true;
    rule.time.to_ns = kToNs[choice >> 4U & 3U];
    rule.time.absolute = (choice & 8U) != 0;
    rule.time.own_clock = rule.time.absolute && (choice & 64U) != 0;
    rule.time.datatype = view.table.time.datatype;
    if (!view.table.time.present()) rule.time.known = false;
  }
  LidarPacket packet;
  if (!io::decode::decode_cloud(view, rule, packet).empty()) return;
  must_be_returns(packet);
  must(packet.points.size() + packet.dropped_invalid == std::size_t{view.width} * view.height, "points are counted");
}
