#include "sweep_splitter.hpp"

#include <cmath>

#include "sweep_message.hpp"

namespace aslio::io::packets {

bool SweepSplitter::add(const PacketHead& head, TimeNs time, Bytes packet) {
  const bool full = parts_.size() >= kMostPackets || bytes_.size() + packet.size() > kMostBytes;
  const bool late = !parts_.empty() && std::abs(time - parts_.front().time) > kLongest;
  const bool ends = !parts_.empty() && (full || late || (last_ && format_.begins_sweep(*last_, head)));
  if (ends) finish();
  last_ = head;
  parts_.push_back({time, bytes_.size(), packet.size()});
  bytes_.insert(bytes_.end(), packet.begin(), packet.end());
  return ends;
}

bool SweepSplitter::flush() {
  last_.reset();
  if (parts_.empty()) return false;
  finish();
  return true;
}

void SweepSplitter::finish() {
  std::vector<Packet> packets;
  packets.reserve(parts_.size());
  for (const Part& part : parts_) packets.push_back({part.time, Bytes(bytes_).subspan(part.begin, part.size)});
  encode_sweep(sweeps_++, packets.front().received, "lidar", packets, message_);
  parts_.clear();
  bytes_.clear();
}

}  // namespace aslio::io::packets
