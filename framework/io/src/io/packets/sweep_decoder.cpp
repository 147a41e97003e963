#include "sweep_decoder.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include "../input_file.hpp"
#include "aslio/core/errors.hpp"
#include "hesai.hpp"
#include "ouster.hpp"
#include "sweep_message.hpp"
#include "velodyne.hpp"

namespace aslio::io::packets {
namespace {

struct KnownScan {
  Vendor vendor;
  std::string_view package, name;
};

/// By name alone: the layouts within are checked against the length of the message.
constexpr std::array<KnownScan, 7> kKnownScans{{{Vendor::velodyne, "velodyne_msgs/", "/VelodyneScan"},
                                                {Vendor::hesai, "pandar_msgs/", "/PandarScan"},
                                                {Vendor::hesai, "hesai_lidar/", "/PandarScan"},
                                                {Vendor::hesai, "hesai_ros_driver/", "/UdpFrame"},
                                                {Vendor::velodyne, kVelodyneSweep, ""},
                                                {Vendor::hesai, kHesaiSweep, ""},
                                                {Vendor::ouster, kOusterSweep, ""}}};

class SweepDecoder final : public LidarDecoder {
 public:
  SweepDecoder(Vendor vendor, const Connection& connection, const SensorConfig& sensor, std::string where)
      : vendor_(vendor),
        velodyne_scan_(connection.type.ends_with("/VelodyneScan")),
        where_(std::move(where)),
        scan_lines_(sensor.model.scan_lines) {
    if (vendor == Vendor::ouster) format_ = make_ouster(parse_ouster_metadata(where_, connection.definition));
    if (vendor == Vendor::hesai && !sensor.lidar_calibration.empty()) {
      beams_ = read_hesai_beams(sensor.lidar_calibration, read_text(sensor.lidar_calibration));
    }
  }

  bool judge(const decode::Message& message, SourceNotes& notes) override {
    SweepMessage sweep;
    std::string why = parse_sweep(message, velodyne_scan_, sweep);
    if (why.empty() && !format_) why = find_format(sweep.packets);
    LidarPacket packet;
    if (why.empty()) why = decode_all(sweep, packet);
    if (!why.empty()) {
      if (malformed_.empty()) malformed_ = why;
      return false;
    }
    if (packet.points.empty()) return false;
    notes.verdicts.push_back("lidar packets: " + format_->verdict());
    notes.verdicts.push_back(
        "lidar point times: of each firing by the sensor's clock, which the least delay of a sweep's "
        "packets moves to that of the receiver");
    return true;
  }

  void assume(SourceNotes& notes) override {
    if (!malformed_.empty()) {
      throw DataError(fmt::format("{}: no message can be decoded; the first: {}", where_, malformed_));
    }
    notes.warnings.push_back(fmt::format("{}: no message has returns; nothing to judge the packets by", where_));
  }

  std::string decode(const decode::Message& message, LidarPacket& packet) override {
    SweepMessage sweep;
    std::string why = parse_sweep(message, velodyne_scan_, sweep);
    if (why.empty() && !format_) why = find_format(sweep.packets);
    if (!why.empty()) return why;
    packet.stamp = sweep.stamp;
    packet.points.clear();
    packet.dropped_invalid = packet.beyond_lines = 0;
    const Sweep decoded = decode_packets(*format_, sweep.packets, scan_lines_, packet);
    if (!sweep.packets.empty() && decoded.malformed == sweep.packets.size()) return decoded.first_problem;
    packets_ += sweep.packets.size();
    missing_ += decoded.missing;
    skipped_ += decoded.malformed;
    if (first_skipped_.empty()) first_skipped_ = decoded.first_problem;
    return {};
  }

  std::string remark() const override {
    std::string text;
    if (missing_ > 0) text = fmt::format("{} of {} packets are missing within sweeps", missing_, packets_ + missing_);
    if (skipped_ > 0) {
      text += fmt::format("{}{} malformed packets were skipped; the first: {}", text.empty() ? "" : "; ", skipped_,
                          first_skipped_);
    }
    return text;
  }

 private:
  static std::string read_text(const std::string& path) {
    constexpr std::uint64_t kMost = 1 << 20;
    return read_small_file(path, kMost, "the table of angles (`lidar_calibration` of the sensor file)");
  }

  std::string find_format(std::span<const Packet> packets) {
    std::string why;
    format_ = vendor_ == Vendor::hesai ? make_hesai(packets, beams_, why) : make_velodyne(packets, why);
    return format_ ? "" : why;
  }

  std::string decode_all(const SweepMessage& sweep, LidarPacket& packet) const {
    const Sweep decoded = decode_packets(*format_, sweep.packets, scan_lines_, packet);
    return packet.points.empty() ? decoded.first_problem : "";
  }

  Vendor vendor_;
  bool velodyne_scan_;
  std::string where_, malformed_, first_skipped_;
  int scan_lines_;
  HesaiBeams beams_;
  std::unique_ptr<PacketFormat> format_;
  std::uint64_t packets_ = 0, missing_ = 0, skipped_ = 0;
};

}  // namespace

std::optional<Vendor> vendor_of(const Connection& connection) {
  if (connection.encoding == Encoding::other) return std::nullopt;
  const auto known = std::find_if(kKnownScans.begin(), kKnownScans.end(), [&](const KnownScan& scan) {
    return connection.type.starts_with(scan.package) && connection.type.ends_with(scan.name);
  });
  return known == kKnownScans.end() ? std::nullopt : std::optional(known->vendor);
}

Sweep decode_packets(const PacketFormat& format, std::span<const Packet> packets, int scan_lines, LidarPacket& out) {
  Sweep sweep;
  std::vector<std::pair<const Packet*, TimeNs>> timed;  // with the time since the first one, by the sensor's clock
  std::optional<PacketHead> first, last;
  TimeNs offset = kTimeMax;
  for (const Packet& packet : packets) {
    PacketHead head;
    if (std::string why = format.head(packet.bytes, head); !why.empty()) {
      if (sweep.malformed++ == 0) sweep.first_problem = std::move(why);
      continue;
    }
    if (!first) first = head;
    if (last) sweep.missing += format.missing_between(*last, head);
    last = head;
    const TimeNs since = clock_difference(head.time, first->time, format.clock_period());
    timed.emplace_back(&packet, since);
    offset = std::min(offset, packet.received - since);
  }
  for (const auto& [packet, since] : timed) format.decode(packet->bytes, offset + since, scan_lines, out);
  return sweep;
}

std::unique_ptr<LidarDecoder> make_sweep_decoder(const Connection& connection, const SensorConfig& sensor,
                                                 std::string where) {
  return std::make_unique<SweepDecoder>(vendor_of(connection).value(), connection, sensor, std::move(where));
}

}  // namespace aslio::io::packets
