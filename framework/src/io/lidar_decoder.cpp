#include "lidar_decoder.hpp"

#include <fmt/format.h>

#include "aslio/core/errors.hpp"
#include "aslio/io/rosbag/messages.hpp"
#include "decode/cloud.hpp"

namespace aslio::io {
namespace {

/// Offsets beyond several sweeps are bit errors or wrapped counters.
TimeNs longest_offset(const SensorConfig& sensor) { return std::max(kSecond, to_ns(5.0 * sensor.model.sweep_period)); }

/// Judges the offsets of a Livox topic by the longest span among its first messages. A driver may send 10 ms at a time,
/// or a first message cut off by its start; only a span that is off by hundreds is of another unit.
class LivoxDecoder final : public LidarDecoder {
 public:
  LivoxDecoder(const SensorConfig& sensor, std::string where)
      : where_(std::move(where)), require_times_(sensor.require_point_times), sweep_period_(sensor.model.sweep_period) {
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
      if (clock_judged_) return false;  // a single one, which reading skips
      throw DataError(fmt::format("{}: the first message cannot be decoded: {}", where_, why));
    }
    if (facts.valid < 2) return false;
    if (!clock_judged_) judge_clock(facts.timebase - facts.stamp, notes);
    if (is_sweep(facts.span())) {
      notes.verdicts.push_back(fmt::format("lidar point times: livox offset_time, ns from the {} ({:.6f} to {:.6f} s)",
                                           base(), 1e-9 * facts.first_offset, 1e-9 * facts.last_offset));
      return true;
    }
    if (facts.valid < (facts.last_offset == 0 ? kEnoughZeros : kEnoughPoints)) return false;
    if (doubtful_++ == 0 || facts.span() > longest_.span()) longest_ = facts;
    if (doubtful_ < kEnoughMessages) return false;
    reject_offsets(notes);
    return true;
  }

  void assume(SourceNotes& notes) override {
    if (doubtful_ > 0) return reject_offsets(notes);
    notes.warnings.push_back(fmt::format("{}: no message has enough returns to judge point times by", where_));
  }

  std::string decode(decode::Bytes message, LidarPacket& packet) override {
    decode::LivoxFacts facts;
    return decode_livox(message, rule_, packet, facts);
  }

 private:
  static constexpr std::uint32_t kEnoughPoints = 100;  ///< few, of one corner of the view, may be of one moment
  static constexpr std::uint32_t kEnoughZeros = 10;    ///< no moment has offset 0 by chance in that many
  static constexpr std::size_t kEnoughMessages = 10;

  bool is_sweep(double span) const {
    constexpr double kFactor = 200;
    return span >= sweep_period_ / kFactor && span <= sweep_period_ * kFactor;
  }

  const char* base() const { return rule_.from_header ? "header stamp" : "time base"; }

  void judge_clock(TimeNs apart, SourceNotes& notes) {
    clock_judged_ = true;
    rule_.from_header = std::abs(apart) > kSecond / 2;
    if (!rule_.from_header) return;
    notes.warnings.push_back(
        fmt::format("{}: time base and header stamp differ by {:.3f} s: offsets are counted from "
                    "the header stamp, the clock of the other topics",
                    where_, to_seconds(apart)));
  }

  std::string why_rejected() const {
    const double span = longest_.span();
    if (span == 0) return fmt::format("offset_time is {} in all {} points", longest_.first_offset, longest_.valid);
    const char* guess = "is offset_time in ns, and `sweep_period` right?";
    // Both may fit; messages are shorter than a sweep rather than longer, so that the smaller unit is meant.
    if (is_sweep(1e3 * span)) {
      guess = "is offset_time in microseconds?";
    } else if (is_sweep(1e6 * span)) {
      guess = "is offset_time in milliseconds?";
    }
    const std::string first = doubtful_ == 1 ? std::string("the first message spans")
                                             : fmt::format("the first {} messages span at most", doubtful_);
    return fmt::format("{} {:.6g} s where `sweep_period` is {} s ({})", first, span, sweep_period_, guess);
  }

  void reject_offsets(SourceNotes& notes) {
    const std::string why = why_rejected();
    if (require_times_) {
      throw DataError(
          fmt::format("{}: the time of the points cannot be known: {}; record with per-point times in ns, check "
                      "`sweep_period`, or set `require_point_times: false` to go without motion correction",
                      where_, why));
    }
    rule_.timed = false;
    notes.warnings.push_back(
        fmt::format("{}: {}: all points take the {}, no motion correction within a sweep", where_, why, base()));
  }

  std::string where_;
  bool require_times_, clock_judged_ = false;
  double sweep_period_;
  decode::LivoxRule rule_;
  std::size_t doubtful_ = 0;    ///< messages of enough points whose span is that of no sweep
  decode::LivoxFacts longest_;  ///< of those, the one of the longest span
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
