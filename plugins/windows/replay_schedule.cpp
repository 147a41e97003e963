#include "windows/replay_schedule.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <fstream>
#include <iterator>
#include <optional>

#include "aslio/core/errors.hpp"
#include "aslio/core/spread.hpp"

namespace aslio::plugins {

namespace {

/// Field `index` of a line, without blanks around it; nothing when the line has fewer.
std::optional<std::string_view> field(std::string_view line, std::size_t index) {
  for (; index > 0; --index) {
    const std::size_t comma = line.find(',');
    if (comma == std::string_view::npos) return std::nullopt;
    line.remove_prefix(comma + 1);
  }
  line = line.substr(0, line.find(','));
  const auto blank = [](char c) { return c == ' ' || c == '\t' || c == '\r'; };
  while (!line.empty() && blank(line.front())) line.remove_prefix(1);
  while (!line.empty() && blank(line.back())) line.remove_suffix(1);
  return line;
}

std::optional<std::size_t> column(std::string_view header, std::string_view name) {
  for (std::size_t i = 0;; ++i) {
    const auto title = field(header, i);
    if (!title) return std::nullopt;
    if (*title == name) return i;
  }
}

/// A line of the file on the way to being understood.
struct Row {
  const std::string& source;
  std::size_t number;
  std::string_view text;

  [[noreturn]] void refuse(std::string_view why) const {
    throw DataError(fmt::format("{}:{}: {}", source, number, why));
  }
  TimeNs time(std::size_t index, std::string_view name) const {
    const auto value = field(text, index);
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
};

/// SplitMix64 (Steele et al. 2014).
std::uint64_t draw(std::uint64_t& state) {
  const std::uint64_t drawn = mixed(state);
  state += kGoldenRatio;
  return drawn;
}

}  // namespace

ReplaySchedule ReplaySchedule::read(const std::filesystem::path& path) {
  errno = 0;
  std::ifstream file(path, std::ios::binary);
  if (!file || std::filesystem::is_directory(path)) {
    throw ConfigError(fmt::format("{}: cannot open the schedule: {}; name the updates.csv of a run, for example",
                                  path.string(), file ? "it is a directory" : std::strerror(errno)));
  }
  const std::string text{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  if (file.bad()) throw DataError(fmt::format("{}: cannot read the schedule", path.string()));
  return parse(text, path.string());
}

ReplaySchedule ReplaySchedule::parse(std::string_view text, const std::string& source) {
  if (text.empty()) throw DataError(fmt::format("{}: is empty: is it the right file?", source));
  ReplaySchedule schedule;
  std::optional<std::size_t> end_column, begin_column;
  for (std::size_t number = 1; !text.empty(); ++number) {
    const std::size_t length = std::min(text.find('\n'), text.size());
    const Row row{source, number, text.substr(0, length)};
    text.remove_prefix(std::min(length + 1, text.size()));
    if (number == 1) {
      end_column = column(row.text, "t_ns");
      begin_column = column(row.text, "window_begin_ns");
      if (!end_column) {
        row.refuse(
            "the header names no column 't_ns': give a CSV file with the ends of the updates, such as the updates.csv "
            "of a run");
      }
      continue;
    }
    if (field(row.text, 0)->empty() && !field(row.text, 1)) continue;  // an empty line
    Update update{.end = row.time(*end_column, "t_ns")};
    if (!schedule.updates_.empty()) {
      const TimeNs previous = schedule.updates_.back().end;
      if (update.end <= previous) {
        row.refuse(fmt::format("t_ns {} is not after that of the update before, {}", update.end, previous));
      }
      if (begin_column) update.history = std::max<TimeNs>(previous - row.time(*begin_column, "window_begin_ns"), 0);
    }
    schedule.updates_.push_back(update);
  }
  if (schedule.updates_.empty()) throw DataError(fmt::format("{}: holds no update: is it the right file?", source));
  return schedule;
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
    if (end > first) moved.push_back({end, u->history});
  }
  for (auto u = updates_.begin() + 1; u < seam; ++u) moved.push_back({u->end + offset, u->history});
  moved.push_back({first + span, seam->history});
  updates_ = std::move(moved);
}

void ReplaySchedule::shuffle(std::uint64_t seed) {
  std::vector<Update> intervals;  // `end`: duration
  for (std::size_t i = 1; i < updates_.size(); ++i) {
    intervals.push_back({updates_[i].end - updates_[i - 1].end, updates_[i].history});
  }
  for (std::size_t i = intervals.size(); i > 1; --i) std::swap(intervals[i - 1], intervals[draw(seed) % i]);
  for (std::size_t i = 1; i < updates_.size(); ++i) {
    updates_[i] = {updates_[i - 1].end + intervals[i - 1].end, intervals[i - 1].history};
  }
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
