#include "../../framework/io/src/io/decode/decode.hpp"
#include "fuzz/points.hpp"

// The first byte: how the message is read.
ASLIO_FUZZ_TARGET(livox) {
  if (bytes.empty()) return;
  const unsigned choice = bytes[0];
  io::decode::LivoxRule rule;
  rule.tag_filter = (choice & 1U) != 0;
  rule.from_header = (choice & 2U) != 0;
  rule.timed = (choice & 4U) != 0;
  rule.scan_lines = (choice & 8U) != 0 ? 256 : 4;
  rule.longest_offset = (choice & 16U) != 0 ? kTimeMax : kSecond;
  const io::decode::Message message(bytes.subspan(1), (choice & 32U) != 0 ? io::Encoding::cdr : io::Encoding::ros1);
  LidarPacket packet;
  io::decode::LivoxFacts facts;
  if (!io::decode::decode_livox(message, rule, packet, facts).empty()) return;
  must_be_returns(packet);
  must(packet.points.size() + packet.dropped_invalid == facts.present, "points are counted");
}
