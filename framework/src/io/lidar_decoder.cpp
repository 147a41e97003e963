#include "lidar_decoder.hpp"

#include <fmt/format.h>

#include "aslio/core/errors.hpp"
#include "aslio/io/rosbag/messages.hpp"
#include "decode/cloud.hpp"

namespace aslio::io {
namespace {

/// Offsets beyond several sweeps are bit errors or wrapped counters.
TimeNs longest_offset(const SensorConfig& sensor) { return std::max(kSecond, to_ns(5.0 * sensor.model.sweep_period)); }

class LivoxDecoder final : public LidarDecoder {
 public:
  LivoxDecoder(const SensorConfig& sensor, std::string where)
      : where_(std::move(where)), require_times_(sensor.require_point_times) {
    rule_.tag_filter = sensor.livox_tag_filter;
    rule_.scan_lines = sensor.model.scan_lines;
    rule_.longest_offset = longest_offset(sensor);
  }

  bool judge(decode::Bytes message, SourceNotes& notes) override {
    LidarPacket packet;
    decode::LivoxFacts facts;
    decode::LivoxRule lenient = rule_;
    lenient.from_header = true;
    if (const std::string why = decode_livox(message, lenient, packet, facts); !why.empty()) {
      throw DataError(fmt::format("{}: the first message cannot be decoded: {}", where_, why));
    }
    if (facts.valid < 2) return false;
    if (facts.last_offset == 0) {
      const std::string why = fmt::format("offset_time is 0 in all {} points", facts.present);
      if (require_times_) throw DataError(refusal(why));
      notes.warnings.push_back(fmt::format("{}: {}: no motion correction within a sweep", where_, why));
    }
    const TimeNs apart = facts.timebase - facts.stamp;
    rule_.from_header = std::abs(apart) > kSecond / 2;
    if (rule_.from_header) {
      notes.warnings.push_back(
          fmt::format("{}: time base and header stamp differ by {:.3f} s: offsets are counted from "
                      "the header stamp, the clock of the other topics",
                      where_, to_seconds(apart)));
    }
    notes.verdicts.push_back(fmt::format("lidar point times: livox offset_time, ns from the {} (0 to {:.6f} s)",
                                         rule_.from_header ? "header stamp" : "time base", 1e-9 * facts.last_offset));
    return true;
  }

  void assume(SourceNotes& notes) override {
    notes.warnings.push_back(fmt::format("{}: no message has returns; nothing to judge point times by", where_));
  }

  std::string decode(decode::Bytes message, LidarPacket& packet) override {
    decode::LivoxFacts facts;
    return decode_livox(message, rule_, packet, facts);
  }

 private:
  std::string refusal(const std::string& why) const {
    return fmt::format(
        "{}: the time of the points cannot be known: {}; record with per-point times, or set "
        "`require_point_times: false` to go without motion correction",
        where_, why);
  }

  std::string where_;
  bool require_times_;
  decode::LivoxRule rule_;
};

class CloudDecoder final : public LidarDecoder {
 public:
  CloudDecoder(const SensorConfig& sensor, std::string where)
      : where_(std::move(where)), require_times_(sensor.require_point_times), sweep_period_(sensor.model.sweep_period) {
    rule_.tag_filter = sensor.livox_tag_filter;
    rule_.scan_lines = sensor.model.scan_lines;
    rule_.longest_offset = longest_offset(sensor);
  }

  bool judge(decode::Bytes message, SourceNotes& notes) override {
    decode::CloudView view;
    bool systematic = false;
    if (const std::string why = parse_cloud(message, view, systematic); !why.empty()) {
      throw DataError(fmt::format("{}: the first message cannot be decoded: {}", where_, why));
    }
    LidarPacket packet;
    rule_.time = {};
    decode_cloud(view, rule_, packet);
    constexpr std::size_t kEnough = 10;
    if (packet.points.size() < kEnough) return false;
    rule_.time = judge_cloud_times(view, sweep_period_);
    if (rule_.time.known) {
      notes.verdicts.push_back("lidar point times: " + rule_.time.verdict);
      return true;
    }
    if (require_times_) {
      throw DataError(
          fmt::format("{}: the time of the points cannot be known: {}; record with per-point times, check "
                      "`sweep_period`, or set `require_point_times: false` to go without motion correction",
                      where_, rule_.time.verdict));
    }
    notes.warnings.push_back(
        fmt::format("{}: {}: all points take the header stamp, no motion correction", where_, rule_.time.verdict));
    return true;
  }

  void assume(SourceNotes& notes) override {
    notes.warnings.push_back(fmt::format("{}: no message has returns; nothing to judge point times by", where_));
  }

  std::string decode(decode::Bytes message, LidarPacket& packet) override {
    decode::CloudView view;
    bool systematic = false;
    std::string why = parse_cloud(message, view, systematic);
    return why.empty() ? decode_cloud(view, rule_, packet) : why;
  }

 private:
  std::string where_;
  bool require_times_;
  double sweep_period_;
  decode::CloudRule rule_;
};

}  // namespace

bool is_lidar(const rosbag::Connection& connection) {
  return connection.md5 == rosbag::kLivoxCustomMsg.md5 || connection.md5 == rosbag::kPointCloud2.md5;
}

bool is_imu(const rosbag::Connection& connection) { return connection.md5 == rosbag::kImu.md5; }

std::unique_ptr<LidarDecoder> make_lidar_decoder(const rosbag::Connection& connection, const SensorConfig& sensor,
                                                 std::string where) {
  if (connection.md5 == rosbag::kLivoxCustomMsg.md5) return std::make_unique<LivoxDecoder>(sensor, std::move(where));
  return std::make_unique<CloudDecoder>(sensor, std::move(where));
}

}  // namespace aslio::io
