#include "bag_source.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "aslio/core/errors.hpp"
#include "aslio/io/rosbag/messages.hpp"
#include "imu_rate.hpp"
#include "lidar_decoder.hpp"

namespace aslio::io {
namespace {

using rosbag::BagMessage;
using rosbag::BagReader;
using rosbag::Connection;

constexpr TimeNs kJudgedSpan = 5 * kSecond;     ///< of IMU data; the norm of gravity is judged on the first second
constexpr std::size_t kJudgedSamples = 20'000;  ///< at most
constexpr std::size_t kJudgedMessages = 50;     ///< LiDAR messages looked at for one with returns
constexpr TimeNs kSectionSlack = kSecond;       ///< messages may be recorded later than stamped

std::string list_topics(const std::vector<Connection>& connections) {
  std::string text;
  std::vector<std::string> lines;
  for (const Connection& c : connections) lines.push_back(fmt::format("\n  {} [{}]", c.topic, c.type));
  std::sort(lines.begin(), lines.end());
  lines.erase(std::unique(lines.begin(), lines.end()), lines.end());
  constexpr std::size_t kMost = 50;
  for (std::size_t i = 0; i < std::min(kMost, lines.size()); ++i) text += lines[i];
  if (lines.size() > kMost) text += fmt::format("\n  and {} more", lines.size() - kMost);
  return text.empty() ? "\n  (none)" : text;
}

/// The connections of one role, all of one topic.
class TopicChooser {
 public:
  TopicChooser(const std::filesystem::path& path, const std::vector<Connection>& connections)
      : path_(path.string()), connections_(connections) {}

  std::vector<Connection> choose(const char* role, const char* key, const std::string& wanted,
                                 bool (*fits)(const Connection&), const char* types) const {
    const std::string topic = wanted.empty() ? only_topic(role, key, fits, types) : wanted;
    std::vector<Connection> chosen;
    for (const Connection& c : connections_) {
      if (c.topic == topic) chosen.push_back(c);
    }
    if (chosen.empty()) {
      throw DataError(fmt::format("{}: there is no {} topic '{}'; set `{}` to one of:{}", path_, role, topic, key,
                                  list_topics(connections_)));
    }
    for (const Connection& c : chosen) {
      if (!fits(c)) throw DataError(wrong_type(role, key, c, types));
      if (c.md5 != chosen.front().md5) {
        throw DataError(
            fmt::format("{}: topic '{}' carries both {} and {}", path_, topic, chosen.front().type, c.type));
      }
    }
    return chosen;
  }

 private:
  std::string wrong_type(const char* role, const char* key, const Connection& c, const char* types) const {
    const bool named =
        c.type.ends_with("/CustomMsg") || c.type == rosbag::kImu.name || c.type == rosbag::kPointCloud2.name;
    std::string remark;
    if (is_lidar(c) || is_imu(c)) {
      remark = ": `lidar_topic` and `imu_topic` look swapped";
    } else if (named) {
      remark = fmt::format(" with checksum {}, another version of that message than the known one", c.md5);
    }
    return fmt::format("{}: {} topic '{}' is of type {}{}; {} can be read; set `{}` to one of:{}", path_, role, c.topic,
                       c.type, remark, types, key, list_topics(connections_));
  }

  std::string only_topic(const char* role, const char* key, bool (*fits)(const Connection&), const char* types) const {
    std::vector<std::string> topics;
    for (const Connection& c : connections_) {
      if (fits(c) && std::find(topics.begin(), topics.end(), c.topic) == topics.end()) topics.push_back(c.topic);
    }
    if (topics.size() == 1) return topics.front();
    throw DataError(fmt::format("{}: {} {} topic ({}); set `{}` to one of:{}", path_,
                                topics.empty() ? "there is no" : "there is more than one", role, types, key,
                                list_topics(connections_)));
  }

  std::string path_;
  const std::vector<Connection>& connections_;
};

class BagSource final : public MeasurementSource {
 public:
  BagSource(const std::filesystem::path& path, const SensorConfig& sensor, const Section& section)
      : path_(path), reader_(path) {
    const TopicChooser chooser(path, reader_.connections());
    const auto lidar = chooser.choose("LiDAR", "lidar_topic", sensor.lidar_topic, &is_lidar,
                                      "livox CustomMsg and sensor_msgs/PointCloud2");
    const auto imu = chooser.choose("IMU", "imu_topic", sensor.imu_topic, &is_imu, "sensor_msgs/Imu");
    for (const Connection& c : lidar) lidar_ids_.push_back(c.id);
    for (const Connection& c : imu) imu_ids_.push_back(c.id);
    decoder_ = make_lidar_decoder(lidar.front(), sensor, fmt::format("{}: {}", path.string(), lidar.front().topic));
    judge_imu(sensor, fmt::format("{}: {}", path.string(), imu.front().topic));
    judge_lidar(lidar.front().topic);
    set_section(section);
    std::vector<std::uint32_t> both = lidar_ids_;
    both.insert(both.end(), imu_ids_.begin(), imu_ids_.end());
    reader_.select(both);
    add_reader_warnings();
  }

  std::optional<Measurement> next() override {
    BagMessage message;
    while (!past_section() && reader_.next(message)) {
      const bool is_imu_message = std::find(imu_ids_.begin(), imu_ids_.end(), message.connection) != imu_ids_.end();
      const auto stamp = decode::header_stamp(message.bytes);
      TimeNs& newest = is_imu_message ? newest_imu_ : newest_lidar_;
      if (stamp) newest = std::max(newest, *stamp);
      if (stamp && (*stamp < from_ || *stamp >= until_)) {
        sweeps_ += is_imu_message ? 0 : 1;
        continue;
      }
      if (is_imu_message) {
        if (auto sample = imu(message)) return Measurement(*sample);
      } else if (auto packet = lidar(message)) {
        return Measurement(std::move(*packet));
      }
    }
    add_reader_warnings();
    return std::nullopt;
  }

  InputStatus status() const override { return reader_.status(); }
  const SourceNotes& notes() const override { return notes_; }
  std::optional<TimeNs> begin_time() const override { return begin_; }
  std::optional<TimeNs> end_time() const override { return end_; }

 private:
  void judge_imu(const SensorConfig& sensor, const std::string& where) {
    reader_.select(imu_ids_);
    BagMessage message;
    std::vector<ImuSample> samples;
    while (samples.size() < kJudgedSamples && reader_.next(message)) {
      ImuSample sample;
      if (const std::string why = decode::decode_imu(message.bytes, sample); !why.empty()) {
        if (samples.empty()) throw DataError(fmt::format("{}: the first message cannot be decoded: {}", where, why));
        continue;
      }
      samples.push_back(sample);
      if (sample.t - samples.front().t > kJudgedSpan) break;
    }
    units_ = decode::judge_imu_units(samples, sensor.acc_unit, sensor.gyro_unit, where);
    notes_.verdicts = units_.verdicts;
    notes_.warnings = units_.warnings;
    note_imu_rate(samples, notes_);
    begin_ = samples.front().t;
  }

  void judge_lidar(const std::string& topic) {
    reader_.select(lidar_ids_);
    BagMessage message;
    bool judged = false;
    std::size_t seen = 0;
    for (; !judged && seen < kJudgedMessages && reader_.next(message); ++seen) {
      if (const auto stamp = decode::header_stamp(message.bytes); seen == 0 && stamp) begin_ = std::min(begin_, *stamp);
      judged = decoder_->judge(message.bytes, notes_);
    }
    if (seen == 0) throw DataError(fmt::format("{}: {}: there is no LiDAR message", path_.string(), topic));
    if (!judged) decoder_->assume(notes_);
  }

  void set_section(const Section& section) {
    const TimeNs first = reader_.begin_time().value_or(0), last = reader_.end_time().value_or(0);
    end_ = begin_ + (last - first);
    if (section.start > 0) from_ = begin_ + to_ns(section.start);
    if (section.start > to_seconds(last - first)) {
      throw DataError(fmt::format("{}: the section starts at {} s, the bag lasts {:.3f} s", path_.string(),
                                  section.start, to_seconds(last - first)));
    }
    if (section.duration) until_ = begin_ + to_ns(section.start) + to_ns(*section.duration);
    begin_ = std::max(begin_, from_);
    end_ = std::min(end_, until_);
  }

  bool past_section() const {
    return until_ != kTimeMax && std::min(newest_imu_, newest_lidar_) > until_ + kSectionSlack;
  }

  std::optional<ImuSample> imu(const BagMessage& message) {
    ImuSample sample;
    if (const std::string why = decode::decode_imu(message.bytes, sample); !why.empty()) {
      skip("IMU", why);
      return std::nullopt;
    }
    sample.acc *= units_.acc;
    sample.gyro *= units_.gyro;
    if (!too_fast_ && sample.gyro.norm() > decode::kFastestGyro) {
      too_fast_ = true;
      notes_.warnings.push_back(
          fmt::format("{}: an angular rate of {:.1f} rad/s is beyond any gyroscope; if it is in "
                      "deg/s set `gyro_unit: deg_s`",
                      path_.string(), sample.gyro.norm()));
    }
    return sample;
  }

  std::optional<LidarPacket> lidar(const BagMessage& message) {
    LidarPacket packet;
    packet.sweep_id = sweeps_++;
    if (const std::string why = decoder_->decode(message.bytes, packet); !why.empty()) {
      skip("LiDAR", why);
      return std::nullopt;
    }
    return packet;
  }

  void skip(const char* role, const std::string& why) {
    ++skipped_;
    const std::string text =
        fmt::format("{}: {} malformed message(s) skipped; the first, of the {}: {}", path_.string(), skipped_,
                    skipped_ == 1 ? role : first_role_, skipped_ == 1 ? why : first_why_);
    if (skipped_ == 1) {
      first_role_ = role;
      first_why_ = why;
      skip_warning_ = notes_.warnings.size();
      notes_.warnings.push_back(text);
    } else {
      notes_.warnings[skip_warning_] = text;
    }
  }

  void add_reader_warnings() {
    for (; reader_warnings_ < reader_.warnings().size(); ++reader_warnings_) {
      notes_.warnings.push_back(fmt::format("{}: {}", path_.string(), reader_.warnings()[reader_warnings_]));
    }
  }

  std::filesystem::path path_;
  BagReader reader_;
  std::unique_ptr<LidarDecoder> decoder_;
  std::vector<std::uint32_t> lidar_ids_, imu_ids_;
  decode::ImuUnits units_;
  SourceNotes notes_;
  TimeNs begin_ = 0, end_ = 0, from_ = kTimeMin, until_ = kTimeMax;
  TimeNs newest_imu_ = kTimeMin, newest_lidar_ = kTimeMin;
  std::uint32_t sweeps_ = 0;
  std::size_t skipped_ = 0, skip_warning_ = 0, reader_warnings_ = 0;
  std::string first_role_, first_why_;
  bool too_fast_ = false;
};

}  // namespace

std::unique_ptr<MeasurementSource> open_bag(const std::filesystem::path& path, const SensorConfig& sensor,
                                            const Section& section) {
  return std::make_unique<BagSource>(path, sensor, section);
}

}  // namespace aslio::io
