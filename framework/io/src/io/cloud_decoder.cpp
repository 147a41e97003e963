#include "cloud_decoder.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <vector>

#include "aslio/core/errors.hpp"
#include "decode/cloud.hpp"
#include "longest_offset.hpp"

namespace aslio::io {
namespace {

/// Judges the times of a PointCloud2 topic by the first clouds that agree. One alone may be cut off by the start of its
/// driver, or damaged.
class CloudDecoder final : public LidarDecoder {
 public:
  CloudDecoder(const SensorConfig& sensor, std::string where, std::optional<TimeNs> imu_time)
      : where_(std::move(where)),
        frame_(sensor.lidar_frame),
        facts_{sensor.model.sweep_period, sensor.times, imu_time},
        require_times_(sensor.require_point_times),
        untimed_(sensor.times.deskewed || sensor.times.point_time == PointTime::none) {
    rule_.tag_filter = sensor.livox_tag_filter;
    rule_.scan_lines = sensor.model.scan_lines;
    rule_.longest_offset = longest_offset(sensor);
  }

  bool judge(const decode::Message& message, SourceNotes& notes) override {
    decode::CloudView view;
    bool systematic = false;
    if (const std::string why = parse(message, view, systematic); !why.empty()) {
      if (systematic) throw DataError(fmt::format("{}: the first message cannot be decoded: {}", where_, why));
      if (malformed_.empty()) malformed_ = why;
      return false;
    }
    if (!is_wanted(view)) return false;
    note_oddities(view, notes);
    LidarPacket packet;
    rule_.time = {};
    decode_cloud(view, rule_, packet);
    constexpr std::size_t kEnough = 10;
    if (packet.points.size() < kEnough) return false;
    if (untimed_) return take_without_times(notes);
    judged_.push_back(judge_cloud_times(view, facts_));
    refuse_several_frames();
    const bool told = like(judged_.back()) >= kAgreeing || judged_.size() >= kMaxJudged;
    if (!told && view.table.time.present()) return false;
    decide(notes);
    return true;
  }

  void assume(SourceNotes& notes) override {
    if (!judged_.empty()) return decide(notes);
    if (!malformed_.empty()) {
      throw DataError(fmt::format("{}: the first message cannot be decoded: {}", where_, malformed_));
    }
    notes.warnings.push_back(fmt::format("{}: no message has returns; nothing to judge point times by", where_));
  }

  std::string decode(const decode::Message& message, LidarPacket& packet) override {
    decode::CloudView view;
    bool systematic = false;
    std::string why = parse(message, view, systematic);
    skipped_ = why.empty() && !frame_.empty() && view.frame != frame_;
    if (skipped_) return {};
    return why.empty() ? decode_cloud(view, rule_, packet) : why;
  }

  bool skipped() const override { return skipped_; }
  bool own_clock() const override { return rule_.time.own_clock; }

 private:
  static constexpr std::ptrdiff_t kAgreeing = 3;  ///< clouds of one verdict that decide
  static constexpr std::size_t kMaxJudged = 10;   ///< and where they do not agree, the most of so many

  std::string parse(const decode::Message& message, decode::CloudView& view, bool& systematic) const {
    return parse_cloud(message, view, systematic, facts_.declared.point_time_field);
  }

  /// One topic may carry the clouds of several sensors, each in a frame of its own.
  bool is_wanted(const decode::CloudView& view) {
    if (!frame_.empty()) return view.frame == frame_;
    constexpr std::size_t kMaxFrames = 8;
    if (frames_.size() < kMaxFrames) frames_.emplace(view.frame);
    return true;
  }

  void refuse_several_frames() const {
    if (frames_.size() < 2) return;
    std::string list;
    for (const std::string& frame : frames_) list += fmt::format("{}'{}'", list.empty() ? "" : ", ", frame);
    throw DataError(fmt::format(
        "{}: this topic carries clouds of {} frames ({}), as of several sensors: set `lidar_frame` to one of them",
        where_, frames_.size(), list));
  }

  void note_oddities(const decode::CloudView& view, SourceNotes& notes) {
    if (view.row_step_wrong && !row_step_told_) {
      notes.warnings.push_back(
          fmt::format("{}: `row_step` of the clouds is wrong; their rows follow each other without a gap "
                      "and are read so",
                      where_));
      row_step_told_ = true;
    }
    if (view.flagged_big_endian && !endian_told_) {
      notes.warnings.push_back(
          fmt::format("{}: the clouds say `is_bigendian`; by their values they are {}-endian and are "
                      "read so",
                      where_, view.swapped() ? "big" : "little"));
      endian_told_ = true;
    }
  }

  bool take_without_times(SourceNotes& notes) {
    notes.verdicts.push_back(fmt::format("lidar point times: none, all points of a sweep are of the header stamp ({})",
                                         facts_.declared.deskewed ? "deskewed" : "point_time: none"));
    return true;
  }

  /// How many clouds say the same.
  std::ptrdiff_t like(const decode::CloudTimeRule& rule) const {
    const auto same = [&](const decode::CloudTimeRule& other) {
      return rule.known && other.known && rule.to_ns == other.to_ns && rule.absolute == other.absolute;
    };
    return std::count_if(judged_.begin(), judged_.end(), same);
  }

  void decide(SourceNotes& notes) {
    const auto known = [](const decode::CloudTimeRule& rule) { return rule.known; };
    const auto less = [this](const auto& a, const auto& b) { return like(a) < like(b); };
    const bool most_known = 2 * std::count_if(judged_.begin(), judged_.end(), known) >= std::ssize(judged_);
    rule_.time = most_known ? *std::max_element(judged_.begin(), judged_.end(), less)
                            : *std::find_if_not(judged_.begin(), judged_.end(), known);
    if (rule_.time.known) {
      notes.verdicts.push_back("lidar point times: " + rule_.time.verdict);
      if (!rule_.time.doubt.empty()) notes.warnings.push_back(fmt::format("{}: {}", where_, rule_.time.doubt));
      return;
    }
    if (require_times_) {
      throw DataError(
          fmt::format("{}: the time of the points cannot be known: {}; record with per-point times, check "
                      "`sweep_period`, or set `require_point_times: false` to go without motion correction",
                      where_, rule_.time.verdict));
    }
    notes.warnings.push_back(
        fmt::format("{}: {}: all points take the header stamp, no motion correction", where_, rule_.time.verdict));
  }

  std::string where_, malformed_;  ///< malformed_: why the first such message cannot be decoded
  std::string frame_;              ///< the only one that is taken; empty: all
  std::set<std::string> frames_;   ///< that were seen
  std::vector<decode::CloudTimeRule> judged_;
  decode::CloudTimeFacts facts_;
  bool require_times_, untimed_;
  bool row_step_told_ = false, endian_told_ = false, skipped_ = false;
  decode::CloudRule rule_;
};

}  // namespace

std::unique_ptr<LidarDecoder> make_cloud_decoder(const SensorConfig& sensor, std::string where,
                                                 std::optional<TimeNs> imu_time) {
  return std::make_unique<CloudDecoder>(sensor, std::move(where), imu_time);
}

}  // namespace aslio::io
