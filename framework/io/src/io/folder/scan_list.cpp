#include "scan_list.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <map>
#include <optional>

#include "aslio/core/errors.hpp"
#include "decimal.hpp"
#include "folder_path.hpp"
#include "number_lines.hpp"

namespace aslio::io {
namespace {

namespace fs = std::filesystem;

constexpr std::array<std::string_view, 3> kExtensions{".bin", ".pcd", ".ply"};
constexpr std::size_t kMaxScans = 2'000'000;
constexpr std::uint64_t kLeastTime = 100'000'000;  ///< names of smaller numbers count scans

bool digit(char c) { return c >= '0' && c <= '9'; }

/// The number at the end of a name, and the one before it where `.` or `_` parts them.
struct NameNumbers {
  std::string_view first, second;  ///< second: empty where there is one number
  char separator = 0;
};

std::string_view trailing_number(std::string_view text) {
  std::size_t begin = text.size();
  while (begin > 0 && digit(text[begin - 1])) --begin;
  return text.substr(begin);
}

NameNumbers numbers_of(std::string_view stem) {
  NameNumbers numbers;
  numbers.first = trailing_number(stem);
  const std::size_t before = stem.size() - numbers.first.size();
  if (numbers.first.empty() || before < 2) return numbers;
  const char separator = stem[before - 1];
  const std::string_view seconds = trailing_number(stem.substr(0, before - 1));
  constexpr std::size_t kLeastDigits = 9;  // a number of a run is no time
  if ((separator != '.' && separator != '_') || (separator == '_' && seconds.size() < kLeastDigits)) return numbers;
  if (seconds.empty()) return numbers;
  return {seconds, numbers.first, separator};
}

std::vector<fs::path> scan_files(const fs::path& folder) {
  std::vector<fs::path> files;
  std::error_code error;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    if (is_scan_file(it->path())) files.push_back(it->path());
    if (files.size() > kMaxScans) {
      throw DataError(fmt::format("{}: more than {} scans; split the folder", folder.string(), kMaxScans));
    }
  }
  if (error) throw DataError(fmt::format("{}: cannot be listed: {}", folder.string(), error.message()));
  std::sort(files.begin(), files.end());
  for (const fs::path& file : files) {
    if (file.extension() == files.front().extension()) continue;
    throw DataError(fmt::format("{}: scans of two formats, {} and {}; keep those of one", folder.string(),
                                files.front().filename().string(), file.filename().string()));
  }
  return files;
}

class ScanLister {
 public:
  ScanLister(const fs::path& folder, double sweep_period) : folder_(folder), sweep_period_(sweep_period) {
    files_ = scan_files(folder);
    for (const fs::path& file : files_) stems_.push_back(file.stem().string());
    for (const std::string& stem : stems_) numbers_.push_back(numbers_of(stem));
  }

  std::vector<ScanFile> list(std::string& verdict) {
    if (files_.empty()) return {};
    const bool split = std::all_of(numbers_.begin(), numbers_.end(), [](const auto& n) { return !n.second.empty(); });
    std::vector<ScanFile> scans;
    if (split) {
      scans = by_split_names(verdict);
    } else if (names_are_times()) {
      scans = by_names(verdict);
    } else {
      scans = by_list(verdict);
    }
    std::stable_sort(scans.begin(), scans.end(), [](const auto& a, const auto& b) { return a.stamp < b.stamp; });
    return scans;
  }

 private:
  [[noreturn]] void refuse(const std::string& name, const std::string& why) const {
    throw DataError(fmt::format("{}: '{}': {}", folder_.string(), name, why));
  }

  /// Behind a point stands a fraction, or nanoseconds without leading zeros: these have nine digits most often.
  std::vector<ScanFile> by_split_names(std::string& verdict) const {
    std::size_t longest = 0;
    for (const NameNumbers& n : numbers_) longest = std::max(longest, n.second.size());
    const bool fraction = numbers_.front().separator == '.' && longest < 9;
    if (!fraction && longest != 9) {
      refuse(stems_.front(), fmt::format("behind the seconds stand {} digits, not the 9 of nanoseconds; rename the "
                                         "scans, or give their times in timestamps.txt",
                                         longest));
    }
    std::vector<ScanFile> scans;
    for (std::size_t i = 0; i < files_.size(); ++i) {
      const std::string padded = fraction
                                     ? std::string(numbers_[i].second) + std::string(9 - numbers_[i].second.size(), '0')
                                     : std::string(numbers_[i].second);
      const auto seconds = Decimal::parse(numbers_[i].first), rest = Decimal::parse(padded);
      const auto whole = seconds ? seconds->times_power(9) : std::nullopt;
      if (!whole || !rest) refuse(stems_[i], "its seconds are no time");
      scans.push_back({*whole + *rest->times_power(0), files_[i]});
    }
    verdict = fmt::format("lidar stamps: by the names of the scans, {}", fraction ? "s" : "s and ns");
    return scans;
  }

  bool names_are_times() const {
    return std::all_of(numbers_.begin(), numbers_.end(), [](const NameNumbers& n) {
      const auto value = n.second.empty() ? Decimal::parse(n.first) : std::nullopt;
      return value && value->value() >= static_cast<double>(kLeastTime);
    });
  }

  std::vector<ScanFile> by_names(std::string& verdict) const {
    std::vector<Decimal> times;
    for (const NameNumbers& n : numbers_) times.push_back(*Decimal::parse(n.first));
    return stamped(files_, times, "by the names of the scans", verdict);
  }

  /// `where`: of the times.
  std::vector<ScanFile> stamped(const std::vector<fs::path>& files, const std::vector<Decimal>& times,
                                const std::string& where, std::string& verdict) const {
    constexpr double kLeast = 0.03, kMost = 29;  // sweeps: scans may be parts of one, or be left out
    std::vector<Decimal> sorted = times;
    std::sort(sorted.begin(), sorted.end(), [](const auto& a, const auto& b) { return a.value() < b.value(); });
    const DecimalUnit* unit = judge_time_unit(sorted, kLeast * sweep_period_, kMost * sweep_period_);
    if (unit == nullptr) {
      throw DataError(
          fmt::format("{}: times {}: their steps are a sweep of {} s in none of s, ms, us, ns; check "
                      "`sweep_period`",
                      folder_.string(), where, sweep_period_));
    }
    std::vector<ScanFile> scans;
    for (std::size_t i = 0; i < files.size(); ++i) {
      const auto stamp = times[i].times_power(unit->power);
      if (!stamp) refuse(files[i].filename().string(), fmt::format("its time is none in {}", unit->name));
      scans.push_back({*stamp, files[i]});
    }
    verdict = fmt::format("lidar stamps: {}, {}", where, unit->name);
    return scans;
  }

  std::vector<ScanFile> by_list(std::string& verdict) {
    const fs::path list = find_list();
    if (list.empty()) {
      refuse(stems_.front(),
             "the names of the scans are no times; name them by their stamps (s, ms, us, ns, or sec_nsec), or give one "
             "time a line, in the order of the scans, in timestamps.txt in this folder or beside it");
    }
    const std::vector<ListLine> lines = read_list(list);
    const std::string where = fmt::format("in {}", list.filename().string());
    const bool named = !lines.empty() && !lines.front().name.empty();
    std::vector<fs::path> files;
    std::vector<Decimal> times;
    const auto take = [&](const fs::path& file, const ListLine& line) {
      files.push_back(file);
      times.push_back(line.time);
    };
    sort_by_number();
    if (named) {
      std::map<std::string, const ListLine*> by_name;
      for (const ListLine& line : lines) by_name[line.name] = &line;
      for (std::size_t i = 0; i < files_.size(); ++i) take(files_[i], *find_line(by_name, i, list));
    } else if (lines.size() == files_.size()) {
      for (std::size_t i = 0; i < files_.size(); ++i) take(files_[i], lines[i]);
    } else {
      throw DataError(
          fmt::format("{}: {} times for the {} scans of {}; give as many, or the name of the scan before each",
                      list.string(), lines.size(), files_.size(), folder_.string()));
    }
    return stamped(files, times, where, verdict);
  }

  struct ListLine {
    std::string name;  ///< empty where the line has a time alone
    Decimal time;
  };

  static std::vector<ListLine> read_list(const fs::path& list) {
    NumberLines lines(list);
    std::vector<ListLine> found;
    while (lines.next()) {
      const auto& cells = lines.cells();
      const auto time = Decimal::parse(cells.size() == 1 ? cells[0] : cells[1]);
      if (!time && found.empty()) continue;  // a header
      if (!time) lines.refuse(fmt::format("'{}' is no time", std::string_view(cells.back()).substr(0, 32)));
      if (found.size() >= kMaxScans) lines.refuse("there are more times than scans can be");
      found.push_back({cells.size() == 1 ? std::string{} : std::string(cells[0]), *time});
    }
    return found;
  }

  /// By the name of the file, with or without extension, or by its number.
  const ListLine* find_line(const std::map<std::string, const ListLine*>& by_name, std::size_t i,
                            const fs::path& list) const {
    std::string_view number = trailing_number(stems_[i]);
    number.remove_prefix(std::min(number.find_first_not_of('0'), number.size() - (number.empty() ? 0 : 1)));
    for (const std::string& key : {files_[i].filename().string(), stems_[i], std::string(number)}) {
      if (const auto found = by_name.find(key); found != by_name.end()) return found->second;
    }
    throw DataError(fmt::format("{}: no line for {}", list.string(), files_[i].filename().string()));
  }

  fs::path find_list() const {
    constexpr std::array<std::string_view, 6> kNames{"timestamps.txt", "timestamps.csv", "times.txt",
                                                     "times.csv",      "timestamp.txt",  "stamps.txt"};
    std::error_code ignored;
    for (const fs::path& where : {folder_, named_folder(folder_).parent_path()}) {
      for (const std::string_view name : kNames) {
        if (fs::is_regular_file(where / name, ignored)) return where / name;
      }
    }
    return {};
  }

  /// `10.pcd` after `9.pcd`.
  void sort_by_number() {
    std::vector<std::size_t> order(files_.size());
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
    const auto key = [this](std::size_t i) {
      const std::string& stem = stems_[i];
      const std::string_view number = trailing_number(stem);
      const auto value = Decimal::parse(number);
      return std::pair(stem.substr(0, stem.size() - number.size()), value ? value->value() : 0.0);
    };
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return key(a) < key(b); });
    std::vector<fs::path> files;
    std::vector<std::string> stems;
    for (const std::size_t i : order) {
      files.push_back(files_[i]);
      stems.push_back(stems_[i]);
    }
    files_ = std::move(files);
    stems_ = std::move(stems);
    numbers_.clear();  // views of what was there
  }

  fs::path folder_;
  double sweep_period_;
  std::vector<fs::path> files_;
  std::vector<std::string> stems_;
  std::vector<NameNumbers> numbers_;  ///< views of stems_
};

}  // namespace

bool is_scan_file(const fs::path& path) {
  const std::string extension = path.extension().string();
  std::error_code ignored;
  return std::find(kExtensions.begin(), kExtensions.end(), extension) != kExtensions.end() &&
         !fs::is_directory(path, ignored);
}

std::vector<ScanFile> list_scans(const fs::path& folder, double sweep_period, std::string& verdict) {
  return ScanLister(folder, sweep_period).list(verdict);
}

}  // namespace aslio::io
