#include "recording_source.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "aslio/core/errors.hpp"
#include "imu_rate.hpp"
#include "imu_stamps.hpp"
#include "lidar_decoder.hpp"
#include "stamp_clock.hpp"
#include "sweep_end_check.hpp"
#include "topic_chooser.hpp"

namespace aslio::io {
namespace {

constexpr std::size_t kJudgedMessages = 50;  ///< LiDAR messages looked at for one with returns
constexpr TimeNs kClocksApart = kSecond;     ///< a recorder is never so late with one topic alone
constexpr TimeNs kSectionSlack = kSecond;    ///< messages may be recorded later than stamped

const TopicRoleWords kLidarWords{"LiDAR", "lidar_topic",
                                 "livox CustomMsg, sensor_msgs/PointCloud2 and packets of Velodyne, Ouster and Hesai",
                                 &is_lidar};
const TopicRoleWords kImuWords{"IMU", "imu_topic", "sensor_msgs/Imu", &is_imu};

class RecordingSource final : public MeasurementSource {
 public:
  RecordingSource(std::string name, std::unique_ptr<MessageReader> reader, const SensorConfig& sensor,
                  const Section& section)
      : name_(std::move(name)),
        reader_(std::move(reader)),
        received_(sensor.times.stamps == StampKind::received),
        sweep_period_(to_ns(sensor.model.sweep_period)),
        lidar_offset_(to_ns(sensor.times.lidar_time_offset)),
        scan_lines_(sensor.model.scan_lines),
        gyro_unit_(sensor.gyro_unit),
        sweep_end_(sweep_period_) {
    refuse_without_message();
    notes_.verdicts = reader_->verdicts();
    const std::string cut = if_cut();
    const TopicChooser chooser(name_, reader_->connections(),
                               cut.empty() ? "" : fmt::format("{}: copy it again from its origin, or ", cut));
    const auto lidar = chooser.choose(kLidarWords, sensor.lidar_topic);
    const auto imu = chooser.choose(kImuWords, sensor.imu_topic);
    for (const Connection& c : lidar) lidar_ids_.push_back(c.id);
    for (const Connection& c : imu) imu_ids_.push_back(c.id);
    judge_imu(sensor, fmt::format("{}: {}", name_, imu.front().topic));
    if (!sensor.placeholder_warning.empty()) notes_.warnings.push_back(sensor.placeholder_warning);
    decoder_ = make_lidar_decoder(lidar.front(), sensor, fmt::format("{}: {}", name_, lidar.front().topic), begin_);
    judge_lidar(lidar.front().topic);
    compare_clocks(imu.front().topic, lidar.front().topic, sensor.model.sweep_period);
    set_section(section);
    std::vector<std::uint32_t> both = lidar_ids_;
    both.insert(both.end(), imu_ids_.begin(), imu_ids_.end());
    reader_->select(both);
    refuse_topic_after_topic(imu.front().topic, lidar.front().topic);
    reader_->select(both);
    add_reader_warnings();
  }

  std::optional<Measurement> next() override {
    if (auto waiting = next_sample()) return waiting;
    RawMessage message;
    while (!past_section() && reader_->next(message)) {
      const bool is_imu_message = is_of_imu(message);
      const auto stamp = stamp_of(message, is_imu_message);
      const bool ahead = stamp && is_far_ahead(message, is_imu_message);
      TimeNs& newest = is_imu_message ? newest_imu_ : newest_lidar_;
      if (stamp && !ahead) newest = std::max(newest, *stamp);
      if (stamp && (*stamp < from_ || *stamp >= until_)) {
        sweeps_ += is_imu_message ? 0 : 1;
        continue;
      }
      if (is_imu_message) {
        read_imu(message);
        if (auto sample = next_sample()) return sample;
      } else if (auto packet = lidar(message)) {
        return Measurement(std::move(*packet));
      }
    }
    spreader_.flush(samples_);
    if (auto last = next_sample()) return last;
    section_ended_ = until_ != kTimeMax && std::min(newest_imu_, newest_lidar_) >= until_;
    conclude();
    return std::nullopt;
  }

  void conclude() override {
    add_reader_warnings();
    judge_all_imu();
    judge_lines();
    if (const std::string why = sweep_end_.doubt(); !why.empty()) warn(sweep_end_warning_, why);
    if (const std::string remark = decoder_->remark(); !remark.empty()) warn(packets_warning_, remark);
  }

  /// What is cut off behind the section is nothing that was asked for.
  InputStatus status() const override { return section_ended_ ? InputStatus::complete : reader_->status(); }
  const SourceNotes& notes() const override { return notes_; }
  std::optional<TimeNs> begin_time() const override { return begin_; }
  std::optional<TimeNs> end_time() const override { return end_; }

 private:
  /// The time of a message that counts: of its header or its recording, with the offsets of the sensor file. Nothing
  /// for a message that is too short.
  std::optional<TimeNs> stamp_of(const RawMessage& message, bool is_imu_message) const {
    auto stamp = decode::header_stamp(message);
    if (!stamp) return stamp;
    if (is_imu_message) return (received_ ? message.time : *stamp) - units_.delay;
    if (received_) return message.time - sweep_period_ + lidar_offset_;
    // Only the points know: by the time of recording, on the IMU's clock.
    if (decoder_->own_clock()) return message.time + imu_clock_.offset().value_or(0) - units_.delay;
    return *stamp + lidar_offset_;
  }

  bool is_of_imu(const RawMessage& message) const {
    return std::find(imu_ids_.begin(), imu_ids_.end(), message.connection) != imu_ids_.end();
  }

  bool is_far_ahead(const RawMessage& message, bool is_imu_message) const {
    if (received_ || (!is_imu_message && decoder_->own_clock())) return false;
    const StampClock& clock = is_imu_message ? imu_clock_ : lidar_clock_;
    return clock.far_ahead(*decode::header_stamp(message), message.time);
  }

  /// A sample that waits to be given.
  std::optional<Measurement> next_sample() {
    if (next_sample_ == samples_.size()) {
      samples_.clear();
      next_sample_ = 0;
      return std::nullopt;
    }
    return Measurement(samples_[next_sample_++]);
  }

  /// What is to be said where a file that is cut short lacks something: the rest may have had it. Empty for a whole
  /// one.
  std::string if_cut() const {
    if (reader_->status() != InputStatus::truncated) return {};
    std::error_code error;
    const auto bytes = std::filesystem::file_size(name_, error);
    return error ? "it is cut short" : fmt::format("the file is cut short at {} bytes", bytes);
  }

  /// Such a file has no topics either, or not all of them: naming those to choose from would mislead.
  void refuse_without_message() const {
    const std::string cut = if_cut();
    if (cut.empty() || reader_->begin_time()) return;
    throw DataError(fmt::format("{}: {}, before its first whole message; copy it again from its origin", name_, cut));
  }

  [[noreturn]] void fail_without(const std::string& where, const char* what) const {
    const std::string cut = if_cut();
    throw DataError(fmt::format("{}: there is no {}{}", where, what,
                                cut.empty() ? "" : fmt::format("; {}: copy it again from its origin", cut)));
  }

  void judge_imu(const SensorConfig& sensor, const std::string& where) {
    reader_->select(imu_ids_);
    RawMessage message;
    ImuBeginning beginning;
    for (bool more = true, first = true; more && reader_->next(message);) {
      ImuSample sample;
      if (const std::string why = decode::decode_imu(message, sample); !why.empty()) {
        if (first) throw DataError(fmt::format("{}: the first message cannot be decoded: {}", where, why));
        continue;
      }
      first = false;
      if (received_) sample.t = message.time;
      more = beginning.add(sample, message.time);
    }
    beginning.finish();
    if (beginning.samples().empty()) fail_without(where, "IMU sample");
    const ImuStamps stamps = judge_imu_stamps(beginning.samples(), where);
    spreader_ = ImuSpreader(stamps.burst_period);
    units_ = decode::judge_imu_units(beginning.samples(), sensor, where);
    notes_.verdicts.insert(notes_.verdicts.end(), units_.verdicts.begin(), units_.verdicts.end());
    notes_.warnings = units_.warnings;
    if (!stamps.verdict.empty()) notes_.verdicts.push_back(stamps.verdict);
    if (received_) notes_.verdicts.push_back("stamps: times of recording, by `stamps: received` of the sensor file");
    note_imu_rate(beginning.samples(), notes_);
    imu_clock_ = beginning.clock();
    begin_ = imu_clock_.begin() - units_.delay;
  }

  void judge_lidar(const std::string& topic) {
    lidar_clock_ = judge_clock(*reader_, lidar_ids_, kClockMessages);
    reader_->select(lidar_ids_);
    RawMessage message;
    bool judged = false;
    std::size_t seen = 0;
    for (; !judged && seen < kJudgedMessages && reader_->next(message); ++seen) {
      const auto stamp = decode::header_stamp(message);
      if (seen == 0 && stamp && !received_) begin_ = std::min(begin_, lidar_clock_.begin() + lidar_offset_);
      if (stamp && lidar_clock_.far_off(*stamp, message.time)) continue;
      judged = decoder_->judge(message, notes_);
    }
    if (seen == 0) fail_without(fmt::format("{}: {}", name_, topic), "LiDAR message");
    if (!judged) decoder_->assume(notes_);
    if (decoder_->own_clock()) begin_ = imu_clock_.begin() - units_.delay;
    if (lidar_offset_ != 0) {
      notes_.verdicts.push_back(fmt::format("lidar stamps: {:+.6f} s, by the lidar_time_offset of the sensor file",
                                            to_seconds(lidar_offset_)));
    }
  }

  /// Odometry with the stamps of two clocks would fail later, and not say why.
  void compare_clocks(const std::string& imu_topic, const std::string& lidar_topic, double sweep_period) {
    if (!imu_clock_.offset() || received_ || decoder_->own_clock()) return;
    const TimeNs imu = *imu_clock_.offset() - units_.delay;
    const TimeNs most = std::max(kClocksApart, to_ns(2 * sweep_period));  // a sweep is stamped when it begins
    const auto of_lidar = [&](const StampClock& lidar) {
      return lidar.offset() ? *lidar.offset() + lidar_offset_ : imu;
    };
    const auto apart = [&](const StampClock& lidar) { return std::abs(imu - of_lidar(lidar)); };
    warn_of_delay(imu - of_lidar(lidar_clock_), most, imu_topic, lidar_topic);
    if (apart(lidar_clock_) <= most) return;
    // The first few may have waited for the recorder to start.
    const StampClock lidar = judge_clock(*reader_, lidar_ids_, kJudgedMessages);
    if (apart(lidar) <= most) return;
    const bool imu_off = std::abs(imu) > std::abs(of_lidar(lidar));
    const auto lie = [](TimeNs offset) {
      return fmt::format("{:.3f} s {} the times of recording", to_seconds(std::abs(offset)),
                         offset < 0 ? "before" : "after");
    };
    throw DataError(fmt::format(
        "{}: the stamps of IMU topic '{}' and of LiDAR topic '{}' are of clocks {:.3f} s apart (at most {} s): the "
        "former lie {}, the latter {}; those of '{}' look off: record both topics with one clock, or correct these "
        "stamps by `{}: {:.3f}` in the sensor file, or take the times of recording by `stamps: received`",
        name_, imu_topic, lidar_topic, to_seconds(apart(lidar)), to_seconds(most), lie(imu), lie(of_lidar(lidar)),
        imu_off ? imu_topic : lidar_topic, imu_off ? "imu_time_offset" : "lidar_time_offset",
        to_seconds(imu_off ? of_lidar(lidar) - imu : imu - of_lidar(lidar))));
  }

  /// A script may write all messages of one topic, then those of the other. What waits for its other half so long would
  /// be dropped. Pre: both topics are selected.
  void refuse_topic_after_topic(const std::string& imu_topic, const std::string& lidar_topic) {
    if (received_ || decoder_->own_clock()) return;
    constexpr TimeNs kWaits = 2 * kSecond;  // less than what a pipeline keeps of one sensor without the other
    constexpr int kEnough = 3;              // messages; a single stamp may be damaged
    std::optional<bool> first;
    int late = 0;
    for (RawMessage message; late < kEnough && reader_->next(message);) {
      const bool is_imu_message = is_of_imu(message);
      if (first.value_or(is_imu_message) != is_imu_message) return;
      first = is_imu_message;
      const TimeNs other = is_imu_message ? lidar_clock_.begin() + lidar_offset_ : imu_clock_.begin() - units_.delay;
      late += stamp_of(message, is_imu_message).value_or(other) > other + kWaits ? 1 : 0;
    }
    if (late < kEnough) return;
    throw DataError(
        fmt::format("{}: the messages of '{}' come {} s and more after those of '{}' with the same stamps: the "
                    "topics were written one after the other; write the bag with the header stamps as times of "
                    "recording",
                    name_, *first ? lidar_topic : imu_topic, kWaits / kSecond, *first ? imu_topic : lidar_topic));
  }

  /// A part of a second is no other clock, but more than recorders delay a topic: a sweep is received at its end.
  void warn_of_delay(TimeNs apart, TimeNs most, const std::string& imu_topic, const std::string& lidar_topic) {
    constexpr TimeNs kUsual = kSecond / 10;
    if (std::abs(apart) > most || std::abs(apart) <= kUsual + 2 * sweep_period_) return;
    notes_.warnings.push_back(fmt::format(
        "{}: by the times of recording, the stamps of '{}' and '{}' are {:.3f} s apart, where a sweep takes "
        "{:.3f} s: are their clocks the same? `imu_time_offset` and `lidar_time_offset` correct them",
        name_, imu_topic, lidar_topic, to_seconds(std::abs(apart)), to_seconds(sweep_period_)));
  }

  void set_section(const Section& section) {
    const TimeNs first = reader_->begin_time().value_or(0), last = reader_->end_time().value_or(0);
    end_ = begin_ + (last - first);
    if (section.start > 0) from_ = begin_ + to_ns(section.start);
    if (section.start > to_seconds(last - first)) {
      throw DataError(fmt::format("{}: the section starts at {} s, the bag lasts {:.3f} s", name_, section.start,
                                  to_seconds(last - first)));
    }
    if (section.duration) until_ = begin_ + to_ns(section.start) + to_ns(*section.duration);
    begin_ = std::max(begin_, from_);
    end_ = std::min(end_, until_);
  }

  bool past_section() const {
    return until_ != kTimeMax && std::min(newest_imu_, newest_lidar_) > until_ + kSectionSlack;
  }

  void read_imu(const RawMessage& message) {
    ImuSample sample;
    if (const std::string why = decode::decode_imu(message, sample); !why.empty()) {
      return skip("IMU", notes_.malformed_imu, why);
    }
    if (received_) sample.t = message.time;
    const std::uint64_t too_fast = gyro_range_.too_fast(units_);
    gyro_range_.add(sample.gyro);
    if (gyro_range_.too_fast(units_) > too_fast) warn(too_fast_warning_, gyro_range_.beyond(units_));
    units_.apply(sample);
    spreader_.add(sample, samples_);
  }

  /// Last, since a standstill at the beginning fits any unit.
  void judge_all_imu() {
    if (const std::string why = gyro_range_.doubt(gyro_unit_); !why.empty()) warn(doubt_warning_, why);
  }

  std::optional<LidarPacket> lidar(const RawMessage& message) {
    LidarPacket packet;
    packet.sweep_id = sweeps_++;
    if (const std::string why = decoder_->decode(message, packet); !why.empty()) {
      skip("LiDAR", notes_.malformed_lidar, why);
      return std::nullopt;
    }
    if (decoder_->skipped()) {
      --sweeps_;
      return std::nullopt;
    }
    move(packet, received_ ? *stamp_of(message, false) - packet.stamp : lidar_offset_);
    judge_sweep_end(packet, message);
    points_ += packet.points.size();
    beyond_lines_ += packet.beyond_lines;
    highest_line_ = std::max(highest_line_, packet.highest_line);
    return packet;
  }

  /// Points of the future: recorders are late, never early.
  void judge_sweep_end(const LidarPacket& packet, const RawMessage& message) {
    const auto header = decode::header_stamp(message);
    if (received_ || decoder_->own_clock() || sweep_end_.decided() || !imu_clock_.offset() || !header) return;
    const TimeNs apart = *imu_clock_.offset() - units_.delay;
    sweep_end_.add(packet, *header + lidar_offset_, message.time + apart);
    if (!sweep_end_.decided()) return;
    if (const std::string why = sweep_end_.doubt(); !why.empty()) warn(sweep_end_warning_, why);
  }

  static void move(LidarPacket& packet, TimeNs by) {
    if (by == 0) return;
    packet.stamp += by;
    for (TimedPoint& p : packet.points) p.t += by;
  }

  /// Lines that the sensor does not have are damage, if they are few, or those of another sensor.
  void judge_lines() {
    if (beyond_lines_ * 1000 <= points_) return;
    warn(lines_warning_,
         fmt::format("{} of {} points are of scan lines from {} to {} and were dropped: `scan_lines` is {} "
                     "in the sensor file; is it that of this sensor?",
                     beyond_lines_, points_ + beyond_lines_, scan_lines_, highest_line_, scan_lines_));
  }

  /// `count`: of the malformed messages of that role.
  void skip(const char* role, std::uint64_t& count, const std::string& why) {
    if (first_skipped_.empty()) first_skipped_ = fmt::format("of the {}: {}", role, why);
    ++count;
    warn(skip_warning_, fmt::format("{} malformed message(s) skipped; the first, {}",
                                    notes_.malformed_lidar + notes_.malformed_imu, first_skipped_));
  }

  /// A warning that is brought up to date, in its place, as more of its kind is found.
  void warn(std::optional<std::size_t>& place, const std::string& text) {
    if (!place) {
      place = notes_.warnings.size();
      notes_.warnings.emplace_back();
    }
    notes_.warnings[*place] = fmt::format("{}: {}", name_, text);
  }

  void add_reader_warnings() {
    for (; reader_warnings_ < reader_->warnings().size(); ++reader_warnings_) {
      notes_.warnings.push_back(fmt::format("{}: {}", name_, reader_->warnings()[reader_warnings_]));
    }
  }

  std::string name_;
  std::unique_ptr<MessageReader> reader_;
  bool received_;  ///< times of recording count
  TimeNs sweep_period_, lidar_offset_;
  std::unique_ptr<LidarDecoder> decoder_;
  ImuSpreader spreader_;
  std::vector<ImuSample> samples_;  ///< ready to be given, from next_sample_ on
  std::size_t next_sample_ = 0;
  std::vector<std::uint32_t> lidar_ids_, imu_ids_;
  decode::ImuUnits units_;
  StampClock imu_clock_, lidar_clock_;  ///< of the stamps as sent
  SourceNotes notes_;
  TimeNs begin_ = 0, end_ = 0, from_ = kTimeMin, until_ = kTimeMax;
  bool section_ended_ = false;  ///< all of it has been read
  TimeNs newest_imu_ = kTimeMin, newest_lidar_ = kTimeMin;
  std::uint32_t sweeps_ = 0;
  std::size_t reader_warnings_ = 0;
  std::optional<std::size_t> skip_warning_, too_fast_warning_, doubt_warning_, lines_warning_, packets_warning_,
      sweep_end_warning_;  ///< places in the notes
  std::string first_skipped_;
  std::uint64_t points_ = 0, beyond_lines_ = 0;  ///< taken; dropped for their line alone
  int scan_lines_;
  std::uint8_t highest_line_ = 0;  ///< of those that were dropped
  GyroUnit gyro_unit_;
  decode::GyroRange gyro_range_;
  SweepEndCheck sweep_end_;
};

}  // namespace

std::unique_ptr<MeasurementSource> open_recording(std::string name, std::unique_ptr<MessageReader> reader,
                                                  const SensorConfig& sensor, const Section& section) {
  return std::make_unique<RecordingSource>(std::move(name), std::move(reader), sensor, section);
}

}  // namespace aslio::io
