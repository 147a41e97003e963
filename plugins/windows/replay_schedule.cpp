#include "windows/replay_schedule.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>
#include <numeric>
#include <optional>
#include <utility>

#include "aslio/core/csv.hpp"
#include "aslio/core/errors.hpp"
#include "aslio/core/input_file.hpp"
#include "aslio/core/spread.hpp"

namespace aslio::plugins {

namespace {

/// The current line of a file on the way to being understood.
struct Row {
  const CsvReader& csv;

  [[noreturn]] void refuse(std::string_view why) const { csv.refuse(why); }
  /// Without blanks around it; nothing when the line has fewer.
  std::optional<std::string_view> field(std::size_t index) const {
    if (index >= csv.cells().size()) return std::nullopt;
    std::string_view cell = csv.cells()[index];
    const auto blank = [](char c) { return c == ' ' || c == '\t'; };
    while (!cell.empty() && blank(cell.front())) cell.remove_prefix(1);
    while (!cell.empty() && blank(cell.back())) cell.remove_suffix(1);
    return cell;
  }
  bool blank() const { return csv.cells().size() == 1 && field(0)->empty(); }
  std::optional<std::size_t> column(std::string_view name) const {
    for (std::size_t i = 0; i < csv.cells().size(); ++i) {
      if (field(i) == name) return i;
    }
    return std::nullopt;
  }
  TimeNs time(std::size_t index, std::string_view name) const {
    const auto value = field(index);
    if (!value) refuse(fmt::format("the line ends before column '{}'", name));
    TimeNs t = 0;
    const auto [end, error] = std::from_chars(value->data(), value->data() + value->size(), t);
    if (error != std::errc() || end != value->data() + value->size()) {
      refuse(fmt::format("{} '{}' is not a time in whole nanoseconds", name, value->substr(0, 40)));
    }
    constexpr TimeNs farthest = kTimeMax / 2;  // differences of two times are times again
    if (t < -farthest || t > farthest) refuse(fmt::format("{} {} is out of range", name, t));
    return t;
  }
  /// NaN where there is no number: of use to one order alone, which refuses that itself.
  double rate(std::size_t index) const {
    const auto value = field(index);
    double rate = std::numeric_limits<double>::quiet_NaN();
    if (!value) return rate;
    const auto [end, error] = std::from_chars(value->data(), value->data() + value->size(), rate);
    return error == std::errc() && end == value->data() + value->size() ? rate
                                                                        : std::numeric_limits<double>::quiet_NaN();
  }
};

/// To each interval between two updates the one that it is to be as long as: where the turn rate is above that of a
/// share q of the time, one that a share q of the time has longer ones than.
std::vector<std::size_t> lengths_by_turn_rate(const std::vector<ReplaySchedule::Update>& updates) {
  const auto duration = [&](std::size_t i) { return updates[i + 1].end - updates[i].end; };
  std::vector<std::size_t> by_rate(updates.size() - 1), like(updates.size() - 1);
  std::iota(by_rate.begin(), by_rate.end(), std::size_t{0});
  std::vector<std::size_t> by_duration = by_rate;
  // Ties keep their order: the result is the same on every machine.
  std::stable_sort(by_rate.begin(), by_rate.end(),
                   [&](std::size_t a, std::size_t b) { return updates[a + 1].turn_rate > updates[b + 1].turn_rate; });
  std::stable_sort(by_duration.begin(), by_duration.end(),
                   [&](std::size_t a, std::size_t b) { return duration(a) < duration(b); });
  TimeNs begin = 0, until = 0;  // where an interval begins in the one order, and where one ends in the other
  auto shortest = by_duration.begin();
  for (const std::size_t i : by_rate) {
    const TimeNs middle = begin + duration(i) / 2;
    while (until + duration(*shortest) <= middle) until += duration(*shortest++);
    like[i] = *shortest;
    begin += duration(i);
  }
  return like;
}

/// SplitMix64 (Steele et al. 2014).
std::uint64_t draw(std::uint64_t& state) {
  const std::uint64_t drawn = mixed(state);
  state += kGoldenRatio;
  return drawn;
}

}  // namespace

ReplaySchedule ReplaySchedule::read(const std::filesystem::path& path) {
  const auto refuse = [&path](const std::string& why) {
    throw ConfigError(fmt::format("{}: cannot open the schedule: {}; name the updates.csv of a run, for example",
                                  path.string(), why));
  };
  if (const std::string why = why_no_input(path); !why.empty()) refuse("it " + why);
  errno = 0;
  std::ifstream file(path, std::ios::binary);
  if (!file) refuse(std::strerror(errno));
  const std::string text{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  if (file.bad()) throw DataError(fmt::format("{}: cannot read the schedule", path.string()));
  return parse(text, path.string());
}

ReplaySchedule ReplaySchedule::parse(std::string_view text, const std::string& source) {
  if (text.empty()) throw DataError(fmt::format("{}: is empty: is it the right file?", source));
  ReplaySchedule schedule;
  schedule.source_ = source;
  std::optional<std::size_t> end_column, begin_column, rate_column;
  CsvReader csv(text, source);
  const Row row{csv};
  while (csv.next()) {
    if (!end_column) {  // the header
      end_column = row.column("t_ns");
      begin_column = row.column("window_begin_ns");
      rate_column = row.column("gyro_rms_rad_s");
      if (!end_column) {
        row.refuse(
            "the header names no column 't_ns': give a CSV file with the ends of the updates, such as the updates.csv "
            "of a run");
      }
      continue;
    }
    if (row.blank()) continue;
    Update update{.end = row.time(*end_column, "t_ns")};
    if (!schedule.updates_.empty()) {
      const TimeNs previous = schedule.updates_.back().end;
      if (update.end <= previous) {
        row.refuse(fmt::format("t_ns {} is not after that of the update before, {}", update.end, previous));
      }
      if (begin_column) update.history = std::max<TimeNs>(previous - row.time(*begin_column, "window_begin_ns"), 0);
    }
    if (rate_column) update.turn_rate = row.rate(*rate_column);
    schedule.updates_.push_back(update);
  }
  if (schedule.updates_.empty()) throw DataError(fmt::format("{}: holds no update: is it the right file?", source));
  return schedule;
}

std::vector<ReplaySchedule::Update> ReplaySchedule::split(TimeNs warmup) {
  const TimeNs first = updates_.front().end;
  const auto rest = std::prev(
      std::find_if(updates_.begin() + 1, updates_.end(), [&](const Update& u) { return u.end - first > warmup; }));
  std::vector<Update> head(updates_.begin(), rest);
  updates_.erase(updates_.begin(), rest);
  return head;
}

void ReplaySchedule::prepend(const std::vector<Update>& head) {
  updates_.insert(updates_.begin(), head.begin(), head.end());
}

void ReplaySchedule::rotate(TimeNs shift) {
  const TimeNs first = updates_.front().end, span = updates_.back().end - first;
  if (span == 0) return;
  const TimeNs offset = ((shift % span) + span) % span;
  if (offset == 0) return;
  std::vector<Update> moved = {updates_.front()};
  // The interval that runs over the seam ends there first, and then again behind it.
  const auto seam =
      std::find_if(updates_.begin(), updates_.end(), [&](const Update& u) { return u.end - first + offset >= span; });
  for (auto u = seam; u != updates_.end(); ++u) {
    const TimeNs end = u->end + offset - span;
    if (end > first) moved.push_back({.end = end, .history = u->history});
  }
  for (auto u = updates_.begin() + 1; u < seam; ++u) moved.push_back({.end = u->end + offset, .history = u->history});
  moved.push_back({.end = first + span, .history = seam->history});
  updates_ = std::move(moved);
}

void ReplaySchedule::shuffle(std::uint64_t seed) {
  std::vector<Update> intervals;  // `end`: duration
  for (std::size_t i = 1; i < updates_.size(); ++i) {
    intervals.push_back({.end = updates_[i].end - updates_[i - 1].end, .history = updates_[i].history});
  }
  for (std::size_t i = intervals.size(); i > 1; --i) std::swap(intervals[i - 1], intervals[draw(seed) % i]);
  for (std::size_t i = 1; i < updates_.size(); ++i) {
    updates_[i] = {.end = updates_[i - 1].end + intervals[i - 1].end, .history = intervals[i - 1].history};
  }
}

void ReplaySchedule::steady() {
  const auto count = static_cast<TimeNs>(updates_.size() - 1);
  if (count == 0) return;
  const TimeNs first = updates_.front().end, span = updates_.back().end - first;
  TimeNs before = first;
  for (TimeNs i = 1; i <= count; ++i) {
    Update& update = updates_[static_cast<std::size_t>(i)];
    const TimeNs length = update.history + update.end - std::exchange(before, update.end);
    const TimeNs begin = updates_[static_cast<std::size_t>(i - 1)].end;
    update.end = first + span / count * i + span % count * i / count;
    update.history = std::max<TimeNs>(length - (update.end - begin), 0);
  }
}

void ReplaySchedule::by_turn_rate() {
  const std::size_t count = updates_.size() - 1;
  for (std::size_t i = 1; i <= count; ++i) {
    if (std::isfinite(updates_[i].turn_rate)) continue;
    throw DataError(
        fmt::format("{}: gyro_rms_rad_s of the update that ends at {} ns is not known: order 'turn_rate' needs it for "
                    "every update, as in the updates.csv of a run with IMU",
                    source_, updates_[i].end));
  }
  if (count == 0) return;
  const auto interval = [&](std::size_t i) { return static_cast<double>(updates_[i + 1].end - updates_[i].end); };
  const std::vector<std::size_t> like = lengths_by_turn_rate(updates_);
  double all = 0.0;  // so many updates, with a fraction, the lengths make; scaled, they are `count` again
  for (std::size_t i = 0; i < count; ++i) all += interval(i) / interval(like[i]);
  std::vector<Update> ordered = {updates_.front()};
  double until = 0.0;  // updates that end by the end of interval i
  for (std::size_t i = 0; i < count; ++i) {
    const double density = static_cast<double>(count) / all / interval(like[i]);
    const double begin =
        std::exchange(until, i + 1 == count ? static_cast<double>(count) : until + interval(i) * density);
    while (static_cast<double>(ordered.size()) <= until) {
      const TimeNs inside = std::llround((static_cast<double>(ordered.size()) - begin) / density);
      const TimeNs before = ordered.back().end, after = static_cast<TimeNs>(count - ordered.size());
      // Ends increase to the last, though intervals of some ns may be rounded to none.
      const TimeNs end = after == 0 ? updates_.back().end
                                    : std::clamp(updates_[i].end + inside, before + 1, updates_.back().end - after);
      const TimeNs length = updates_[like[i] + 1].history + updates_[like[i] + 1].end - updates_[like[i]].end;
      ordered.push_back({.end = end, .history = std::max<TimeNs>(length - (end - before), 0)});
    }
  }
  updates_ = std::move(ordered);
}

const ReplaySchedule::Update* ReplaySchedule::after(TimeNs t) {
  while (next_ < updates_.size() && updates_[next_].end <= t) ++next_;
  return next_ < updates_.size() ? &updates_[next_] : nullptr;
}

TimeNs ReplaySchedule::longest_history() const {
  TimeNs longest = 0;
  for (const Update& update : updates_) longest = std::max(longest, update.history);
  return longest;
}

}  // namespace aslio::plugins
