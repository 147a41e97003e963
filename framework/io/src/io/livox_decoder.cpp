#include "livox_decoder.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <set>
#include <utility>
#include <vector>

#include "aslio/core/errors.hpp"
#include "longest_offset.hpp"

namespace aslio::io {
namespace {

/// What the offsets of one message tell. The span is that of the middle nine tenths, stretched to all of them: a
/// damaged offset among thousands says nothing of the unit.
struct Offsets {
  std::size_t points = 0;
  TimeNs first = 0, last = 0;  ///< least and largest; but for those beyond the longest offset, unless most are
  bool beyond = false;         ///< most are
  double span = 0;             ///< [s]
  TimeNs least_middle = 0, largest_middle = 0;
  std::size_t alike = 0;  ///< that equal `least_middle`
  std::size_t apart = 0;  ///< that lie later than `least_middle` by a time that is asked for
};

/// Pre: at least two points, whose times count from the stamp. `apart`: of Offsets::apart.
Offsets look_at_offsets(const LidarPacket& packet, TimeNs longest, TimeNs apart) {
  std::vector<TimeNs> all, kept;
  for (const TimedPoint& p : packet.points) all.push_back(p.t - packet.stamp);
  std::copy_if(all.begin(), all.end(), std::back_inserter(kept), [longest](TimeNs t) { return t <= longest; });
  Offsets offsets;
  offsets.points = all.size();
  offsets.beyond = 2 * kept.size() < all.size();
  if (offsets.beyond) kept = all;
  const std::size_t n = kept.size(), cut = n < 4 ? 0 : std::max<std::size_t>(1, n / 20);
  const auto ranked = [&kept](std::size_t rank) {
    const auto at = kept.begin() + static_cast<std::ptrdiff_t>(rank);
    std::nth_element(kept.begin(), at, kept.end());
    return *at;
  };
  const auto [least, largest] = std::minmax_element(kept.begin(), kept.end());
  offsets.first = *least;
  offsets.last = *largest;
  offsets.least_middle = ranked(cut);
  offsets.largest_middle = ranked(n - 1 - cut);
  offsets.alike = static_cast<std::size_t>(std::count(all.begin(), all.end(), offsets.least_middle));
  const TimeNs far = offsets.least_middle + apart;
  offsets.apart =
      static_cast<std::size_t>(std::count_if(kept.begin(), kept.end(), [far](TimeNs t) { return t > far; }));
  const double middle = to_seconds(offsets.largest_middle - offsets.least_middle);
  if (n > 1) offsets.span = middle * static_cast<double>(n - 1) / static_cast<double>(n - 1 - 2 * cut);
  return offsets;
}

/// Judges the offsets of a Livox topic by the median span of its first messages. A driver may send 10 ms at a time, or
/// first messages cut off by its start; only a span that is off by hundreds is of another unit.
class LivoxDecoder final : public LidarDecoder {
 public:
  LivoxDecoder(const SensorConfig& sensor, std::string where)
      : where_(std::move(where)),
        require_times_(sensor.require_point_times),
        sweep_period_(sensor.model.sweep_period),
        longest_(longest_offset(sensor)) {
    rule_.lidar_id = sensor.lidar_id;
    rule_.shift = shift_of(sensor.times.lidar_stamp, sweep_period_);
    untimed_ = sensor.times.deskewed || sensor.times.point_time == PointTime::none;
    rule_.tag_filter = sensor.livox_tag_filter;
    rule_.scan_lines = sensor.model.scan_lines;
    rule_.longest_offset = kTimeMax;  // until judged: what lies beyond may be all there is
  }

  bool judge(const decode::Message& message, SourceNotes& notes) override {
    LidarPacket packet;
    decode::LivoxFacts facts;
    decode::LivoxRule lenient = rule_;
    lenient.from_header = true;
    lenient.shift = 0;
    if (const std::string why = decode_livox(message, lenient, packet, facts); !why.empty()) {
      if (clock_judged_) return false;  // a single one, which reading skips
      throw DataError(fmt::format("{}: the first message cannot be decoded: {}", where_, why));
    }
    if (rule_.lidar_id >= 0 && facts.lidar_id != rule_.lidar_id) return false;
    ids_.insert(facts.lidar_id);
    if (facts.valid < 2) return false;
    if (!clock_judged_) judge_clock(facts.timebase - facts.stamp, notes);
    const Offsets offsets = look_at_offsets(packet, longest_, to_ns(sweep_period_ / kFactor));
    if (!tells(offsets)) return false;
    judged_.push_back(offsets);
    stamps_.push_back(facts.stamp);
    if (judged_.size() < kEnoughMessages) return false;
    decide(notes);
    return true;
  }

  void assume(SourceNotes& notes) override {
    if (!judged_.empty()) return decide(notes);
    rule_.longest_offset = longest_;
    notes.warnings.push_back(fmt::format("{}: no message has enough returns to judge point times by", where_));
  }

  std::string decode(const decode::Message& message, LidarPacket& packet) override {
    decode::LivoxFacts facts;
    std::string why = decode_livox(message, rule_, packet, facts);
    skipped_ = why.empty() && rule_.lidar_id >= 0 && facts.lidar_id != rule_.lidar_id;
    return why;
  }

  bool skipped() const override { return skipped_; }

 private:
  /// From the stamp to the begin of a sweep.
  static TimeNs shift_of(LidarStamp stamp, double sweep_period) {
    if (stamp == LidarStamp::middle) return to_ns(-0.5 * sweep_period);
    return stamp == LidarStamp::end ? to_ns(-sweep_period) : 0;
  }

  static constexpr std::size_t kEnoughPoints = 100;  ///< few, of one corner of the view, may be of one moment
  static constexpr std::size_t kEnoughAlike = 10;    ///< so many are not of offset 0, or damaged, by chance
  static constexpr std::size_t kEnoughMessages = 10;

  static constexpr double kFactor = 200;          ///< by which a span may differ from a sweep
  static constexpr std::size_t kEnoughApart = 3;  ///< so many are not damaged alike

  bool is_sweep(double span) const { return span >= sweep_period_ / kFactor && span <= sweep_period_ * kFactor; }

  bool is_good(const Offsets& offsets) const { return !offsets.beyond && is_sweep(offsets.span); }

  /// Few points can speak for their offsets, but hardly against them.
  bool tells(const Offsets& offsets) const {
    if (is_good(offsets)) return true;
    const bool alike = offsets.beyond || offsets.largest_middle == 0;
    // Nearly all returns may be of one short moment, where the rest of the sweep sees the sky.
    if (!alike && offsets.span < sweep_period_ && offsets.apart >= kEnoughApart) return false;
    return offsets.points >= (alike ? kEnoughAlike : kEnoughPoints);
  }

  void refuse_several_sensors() const {
    if (ids_.size() < 2) return;
    std::string list;
    for (const int id : ids_) list += fmt::format("{}{}", list.empty() ? "" : ", ", id);
    throw DataError(
        fmt::format("{}: this topic carries the points of {} sensors (lidar_id {}): set `lidar_id` to one of "
                    "them, with its T_imu_lidar",
                    where_, ids_.size(), list));
  }

  /// Offsets that cover an eighth of the time between messages are in a wrong scale, or of a view that is cut.
  void doubt_scale(const Offsets& offsets, SourceNotes& notes) {
    constexpr double kFactor = 2;
    if (stamps_.size() < 3) return;
    std::vector<TimeNs> steps;
    for (std::size_t i = 1; i < stamps_.size(); ++i) steps.push_back(stamps_[i] - stamps_[i - 1]);
    std::nth_element(steps.begin(), steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2), steps.end());
    const double step = to_seconds(steps[steps.size() / 2]);
    if (step <= 0 || (offsets.span * kFactor >= step && offsets.span <= kFactor * step)) return;
    notes.warnings.push_back(
        fmt::format("{}: offset_time spans {:.6f} s, but messages come each {:.6f} s: is it in another "
                    "scale than ns?",
                    where_, offsets.span, step));
  }

  void decide(SourceNotes& notes) {
    refuse_several_sensors();
    // Of an even number the longer one: a start cuts messages short, and nothing makes them longer.
    const auto middle = judged_.begin() + static_cast<std::ptrdiff_t>(judged_.size() / 2);
    std::stable_sort(judged_.begin(), judged_.end(), [](const Offsets& a, const Offsets& b) {
      return std::pair(a.beyond, a.span) < std::pair(b.beyond, b.span);
    });
    if (untimed_) return take_without_times(notes);
    if (!is_good(*middle)) return reject_offsets(*middle, notes);
    rule_.longest_offset = longest_;
    doubt_scale(*middle, notes);
    notes.verdicts.push_back(fmt::format("lidar point times: livox offset_time, ns from the {} ({:.6f} to {:.6f} s)",
                                         base(), to_seconds(middle->first), to_seconds(middle->last)));
  }

  void take_without_times(SourceNotes& notes) {
    rule_.timed = false;
    rule_.longest_offset = longest_;
    notes.verdicts.push_back(fmt::format("lidar point times: none, all points of a sweep are of the {}", base()));
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

  bool counts_from_elsewhere(const Offsets& offsets) const {
    return offsets.beyond && offsets.span <= to_seconds(longest_);
  }

  std::string why_rejected(const Offsets& offsets) const {
    if (offsets.beyond) {
      return fmt::format(
          "offset_time goes from {:.6f} to {:.6f} s; more than {} s after the {} is taken for damage ({})",
          to_seconds(offsets.first), to_seconds(offsets.last), to_seconds(longest_), base(),
          counts_from_elsewhere(offsets) ? "does it count from another moment?" : "is `sweep_period` right?");
    }
    const double span = offsets.span;
    if (span == 0) {
      const bool all = offsets.alike == offsets.points;
      return fmt::format("offset_time is {} in {} {} points", offsets.least_middle,
                         all ? "all" : fmt::format("{} of", offsets.alike), offsets.points);
    }
    const char* guess = "is offset_time in ns, and `sweep_period` right?";
    // Both may fit; messages are shorter than a sweep rather than longer, so that the smaller unit is meant.
    if (is_sweep(1e3 * span)) {
      guess = "is offset_time in microseconds?";
    } else if (is_sweep(1e6 * span)) {
      guess = "is offset_time in milliseconds?";
    }
    const std::string first = judged_.size() == 1
                                  ? fmt::format("the first message spans {:.3g} s", span)
                                  : fmt::format("the first {} messages span {:.3g} s (median)", judged_.size(), span);
    return fmt::format("{} where `sweep_period` is {} s ({})", first, sweep_period_, guess);
  }

  void reject_offsets(const Offsets& offsets, SourceNotes& notes) {
    const std::string why = why_rejected(offsets);
    if (require_times_) {
      throw DataError(
          fmt::format("{}: the time of the points cannot be known: {}; record with per-point times in ns{}, or set "
                      "`require_point_times: false` to go without motion correction",
                      where_, why,
                      counts_from_elsewhere(offsets) ? fmt::format(" from the {}", base()) : ", check `sweep_period`"));
    }
    rule_.timed = false;
    notes.warnings.push_back(
        fmt::format("{}: {}: all points take the {}, no motion correction within a sweep", where_, why, base()));
  }

  std::string where_;
  bool require_times_, clock_judged_ = false, skipped_ = false;
  double sweep_period_;
  TimeNs longest_;
  decode::LivoxRule rule_;
  bool untimed_ = false;         ///< by the sensor file
  std::set<int> ids_;            ///< of the sensors that were seen
  std::vector<TimeNs> stamps_;   ///< of the messages of `judged_`
  std::vector<Offsets> judged_;  ///< those of the messages that tell
};

}  // namespace

std::unique_ptr<LidarDecoder> make_livox_decoder(const SensorConfig& sensor, std::string where) {
  return std::make_unique<LivoxDecoder>(sensor, std::move(where));
}

}  // namespace aslio::io
