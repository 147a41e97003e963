#include "aslio/io/inspect.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <memory>
#include <optional>

#include "aslio/core/errors.hpp"
#include "aslio/io/message_reader.hpp"
#include "decode/cloud.hpp"
#include "folder/open_folder.hpp"
#include "imu_rate.hpp"
#include "imu_stamps.hpp"
#include "lidar_decoder.hpp"
#include "packets/open_packets.hpp"
#include "recording_files.hpp"
#include "stamp_clock.hpp"
#include "topic_statistics.hpp"

namespace aslio::io {
namespace {

/// One topic of a recording while it is read.
class TopicProbe {
 public:
  TopicProbe(const Connection& connection, const SensorConfig& sensor, std::string where)
      : sensor_(sensor), connection_(connection), where_(std::move(where)) {
    report_.topic = connection.topic;
    report_.type = connection.type;
    report_.md5 = connection.md5;
    report_.role = is_lidar(connection) ? TopicRole::lidar : is_imu(connection) ? TopicRole::imu : TopicRole::other;
    is_cloud_ = message_kind(connection) == MessageKind::cloud;
  }

  void add_connection(std::uint32_t id) { ids_.push_back(id); }

  /// Before the first message.
  void look_at_clock(MessageReader& reader) {
    if (report_.role != TopicRole::other) clock_ = judge_clock(reader, ids_, kClockMessages);
  }

  /// When an IMU begins, by its stamps.
  std::optional<TimeNs> imu_begin() const {
    if (report_.role != TopicRole::imu || !clock_.offset()) return std::nullopt;
    return clock_.begin();
  }

  /// Before the first message. `imu_time`: where the recording begins, by the only IMU.
  void make_decoder(std::optional<TimeNs> imu_time) {
    if (report_.role != TopicRole::lidar) return;
    try {
      decoder_ = make_lidar_decoder(connection_, sensor_, where_, imu_time);
    } catch (const DataError& error) {
      report_.problem = error.what();
    }
  }

  void add(const RawMessage& message) {
    const bool stamped = report_.role != TopicRole::other;
    const TimeNs stamp = stamped ? decode::header_stamp(message).value_or(message.time) : message.time;
    statistics_.add(stamp);
    if (report_.role == TopicRole::imu) add_imu(message);
    if (decoder_) add_lidar(message, clock_.far_off(stamp, message.time));
  }

  /// `known`: verdicts of the recording, of which a topic states those on its role.
  TopicReport finish(const std::vector<std::string>& known) {
    for (const std::string& verdict : known) {
      const TopicRole role = verdict.starts_with("imu") ? TopicRole::imu : TopicRole::lidar;
      if (role == report_.role) report_.verdicts.push_back(verdict);
    }
    statistics_.finish(report_);
    if (report_.role == TopicRole::imu && report_.problem.empty()) judge_imu();
    if (report_.role == TopicRole::lidar && report_.messages > report_.malformed) {
      report_.points_per_message =
          static_cast<double>(points_) / static_cast<double>(report_.messages - report_.malformed);
    }
    if (decoder_) judge_lidar_end();
    if (report_.messages == 0 && report_.role != TopicRole::other) report_.problem = "there is no message";
    if (decoder_ && !decoder_->remark().empty()) notes_.warnings.push_back(decoder_->remark());
    report_.verdicts.insert(report_.verdicts.end(), notes_.verdicts.begin(), notes_.verdicts.end());
    report_.verdicts.insert(report_.verdicts.end(), notes_.warnings.begin(), notes_.warnings.end());
    return std::move(report_);
  }

 private:
  void add_imu(const RawMessage& message) {
    ImuSample sample;
    if (!decode::decode_imu(message, sample).empty()) {
      ++report_.malformed;
      return;
    }
    if (sensor_.times.stamps == StampKind::received) sample.t = message.time;
    gyro_range_.add(sample.gyro);
    beginning_.add(sample, message.time);
  }

  void judge_imu() {
    beginning_.finish();
    try {
      const decode::ImuUnits units = decode::judge_imu_units(beginning_.samples(), sensor_, where_);
      notes_.verdicts = units.verdicts;
      const ImuStamps stamps = judge_imu_stamps(beginning_.samples(), where_);
      if (!stamps.verdict.empty()) notes_.verdicts.push_back(stamps.verdict);
      report_.acc_unit = units.acc == 1 ? "mps2" : "g";
      report_.gyro_unit = units.gyro == 1 ? "rad_s" : "deg_s";
      notes_.warnings = units.warnings;
      note_imu_rate(beginning_.samples(), notes_);
      for (const std::string& text : {gyro_range_.beyond(units), gyro_range_.doubt(sensor_.gyro_unit)}) {
        if (!text.empty()) notes_.warnings.push_back(text);
      }
    } catch (const DataError& error) {
      report_.problem = error.what();
    }
  }

  void add_lidar(const decode::Message& message, bool stamp_far_off) {
    if (is_cloud_ && report_.fields.empty()) {
      decode::CloudView view;
      bool systematic = false;
      parse_cloud(message, view, systematic);
      report_.fields = view.table.all_names;
    }
    try {
      if (!judged_ && report_.problem.empty() && !stamp_far_off) judged_ = decoder_->judge(message, notes_);
    } catch (const DataError& error) {
      report_.problem = error.what();
    }
    LidarPacket& packet = packet_;
    if (!decoder_->decode(message, packet).empty()) {
      ++report_.malformed;
    } else if (!decoder_->skipped()) {
      points_ += packet.points.size();
      for (const TimedPoint& p : packet.points) report_.lines = std::max(report_.lines, p.line + 1);
      report_.empty += packet.points.empty() ? 1 : 0;
    }
  }

  void judge_lidar_end() {
    if (judged_ || !report_.problem.empty()) return;
    try {
      decoder_->assume(notes_);
    } catch (const DataError& error) {
      report_.problem = error.what();
    }
  }

  const SensorConfig& sensor_;
  const Connection& connection_;  ///< of the reader
  std::string where_;
  TopicReport report_;
  TopicStatistics statistics_;
  SourceNotes notes_;
  std::unique_ptr<LidarDecoder> decoder_;
  std::vector<std::uint32_t> ids_;
  StampClock clock_;  ///< of a LiDAR
  ImuBeginning beginning_;
  decode::GyroRange gyro_range_;
  LidarPacket packet_;
  std::uint64_t points_ = 0;
  bool is_cloud_ = false, judged_ = false;
};

std::uint64_t bytes_of(const std::filesystem::path& path) {
  std::uint64_t bytes = 0;
  for (const auto& file : find_recording_files(path).files) bytes += std::filesystem::file_size(file);
  return bytes;
}

void inspect_messages(MessageReader& reader, const SensorConfig& sensor, InputReport& report) {
  report.kind = reader.kind();
  std::map<std::string, std::unique_ptr<TopicProbe>> probes;  // several connections may share a topic
  std::map<std::uint32_t, TopicProbe*> by_id;
  std::vector<std::uint32_t> all;
  for (const Connection& c : reader.connections()) {
    auto& probe = probes[c.topic + '\0' + c.type + '\0' + c.md5];
    if (!probe) probe = std::make_unique<TopicProbe>(c, sensor, fmt::format("{}: {}", report.name, c.topic));
    by_id[c.id] = probe.get();
    probe->add_connection(c.id);
    all.push_back(c.id);
  }
  std::vector<TimeNs> imu_begins;
  for (auto& [key, probe] : probes) {
    probe->look_at_clock(reader);
    if (const auto begin = probe->imu_begin()) imu_begins.push_back(*begin);
  }
  for (auto& [key, probe] : probes) {
    probe->make_decoder(imu_begins.size() == 1 ? std::optional(imu_begins.front()) : std::nullopt);
  }
  reader.select(all);
  RawMessage message;
  while (reader.next(message)) by_id.at(message.connection)->add(message);
  for (auto& [key, probe] : probes) report.topics.push_back(probe->finish(reader.verdicts()));
  report.status = reader.status();
  report.begin = reader.begin_time().value_or(0);
  report.end = reader.end_time().value_or(0);
  report.warnings = reader.warnings();
}

std::string cell(double value, int decimals) { return value == 0 ? "-" : fmt::format("{:.{}f}", value, decimals); }

}  // namespace

InputReport inspect(const std::filesystem::path& path, const SensorConfig& sensor) {
  return inspect(std::vector{path}, sensor);
}

InputReport inspect(const std::vector<std::filesystem::path>& inputs, const SensorConfig& sensor) {
  InputReport report;
  for (const auto& input : inputs) report.name += (report.name.empty() ? "" : ", ") + input.string();
  const bool folder = inputs.size() == 1 && is_folder_of_scans(inputs.front());
  const auto reader = folder ? open_folder(inputs.front(), sensor) : packets::open_with_packets(inputs, sensor);
  for (const auto& input : inputs) report.bytes += folder ? 0 : bytes_of(input);
  inspect_messages(*reader, sensor, report);
  if (!sensor.placeholder_warning.empty()) report.warnings.push_back(sensor.placeholder_warning);
  try {
    open_source(inputs, sensor);
    report.usable = true;
  } catch (const DataError& error) {
    report.reason = error.what();
  }
  return report;
}

std::string render(const InputReport& report) {
  std::string text =
      fmt::format("{}: {}, {:.3f} s{}{}\n", report.name, report.kind, report.duration(),
                  report.bytes > 0 ? fmt::format(", {:.1f} MB", 1e-6 * static_cast<double>(report.bytes)) : "",
                  report.status == InputStatus::truncated ? ", TRUNCATED" : "");
  std::size_t wide = 5, wide_type = 4;
  for (const TopicReport& t : report.topics) {
    wide = std::max(wide, t.topic.size());
    wide_type = std::max(wide_type, t.type.size());
  }
  text += fmt::format("  {:<{}}  {:<{}}  {:>9}  {:>8}  {:>11}  {:>11}  {:>8}  {:>8}\n", "topic", wide, "type",
                      wide_type, "messages", "rate Hz", "period ms", "max gap ms", "backward", "points");
  for (const TopicReport& t : report.topics) {
    text += fmt::format("  {:<{}}  {:<{}}  {:>9}  {:>8}  {:>11}  {:>11}  {:>8}  {:>8}\n", t.topic, wide, t.type,
                        wide_type, t.messages, cell(t.rate, 2), cell(1e3 * t.median_period, 3),
                        cell(1e3 * t.largest_gap, 3), t.backward, cell(t.points_per_message, 0));
  }
  for (const TopicReport& t : report.topics) {
    if (t.role == TopicRole::other) continue;
    text += fmt::format("{}: {}\n", t.topic, t.problem.empty() ? "can be used" : "CANNOT BE USED");
    if (!t.problem.empty()) text += fmt::format("  {}\n", t.problem);
    if (!t.md5.empty()) text += fmt::format("  checksum {}\n", t.md5);
    if (!t.fields.empty()) text += fmt::format("  fields: {}\n", t.fields);
    for (const std::string& verdict : t.verdicts) text += fmt::format("  {}\n", verdict);
    if (t.repeated > 0) text += fmt::format("  {} repeated stamps\n", t.repeated);
    if (t.empty > 0) text += fmt::format("  {} messages without a point that is kept\n", t.empty);
    if (t.malformed > 0) text += fmt::format("  {} malformed messages\n", t.malformed);
  }
  for (const std::string& warning : report.warnings) text += fmt::format("warning: {}\n", warning);
  text += report.usable ? "usable: yes\n" : fmt::format("usable: no: {}\n", report.reason);
  return text;
}

}  // namespace aslio::io
