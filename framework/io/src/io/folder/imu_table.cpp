#include "imu_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

#include "aslio/core/errors.hpp"
#include "decimal.hpp"
#include "number_lines.hpp"

namespace aslio::io {
namespace {

constexpr std::size_t kMaxSamples = 30'000'000;  ///< 20 h at 400 Hz
constexpr std::size_t kJudged = 2000;            ///< samples by which the unit of time is judged
constexpr std::size_t kMaxHeaderLines = 50;

/// Letters and digits in lower case; what stands in brackets is a unit.
std::string bare(std::string_view name) {
  name = name.substr(0, name.find_first_of("[("));
  std::string text;
  for (const char c : name) {
    if (c >= 'A' && c <= 'Z') text += static_cast<char>(c - 'A' + 'a');
    if ((c >= 'a' && c <= 'z') || (c >= '0' && c <= '9')) text += c;
  }
  constexpr std::array<std::string_view, 3> kPrefixes{"field", "imu", "data"};
  for (const std::string_view prefix : kPrefixes) {
    if (text.size() > prefix.size() + 1 && text.starts_with(prefix)) text.erase(0, prefix.size());
  }
  constexpr std::array<std::string_view, 10> kUnits{"radps", "rads",  "radsec", "mps2", "ms2",
                                                    "degs",  "degps", "dps",    "mss",  "radians"};
  for (const std::string_view unit : kUnits) {
    if (text.size() > unit.size() + 1 && text.ends_with(unit)) {
      text.erase(text.size() - unit.size());
      break;
    }
  }
  return text;
}

template <std::size_t N>
bool among(const std::array<std::string_view, N>& names, std::string_view name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

constexpr std::array<std::string_view, 14> kGyroNames{"w",          "g",
                                                      "gyr",        "gyro",
                                                      "gyros",      "gyroscope",
                                                      "omega",      "angvel",
                                                      "angularvel", "angularvelocity",
                                                      "wrss",       "wrssi",
                                                      "angrate",    "angularvelocity1"};
constexpr std::array<std::string_view, 14> kAccNames{
    "a",      "acc",       "accel",         "accelerometer", "acceleration",
    "linacc", "linearacc", "linaccel",      "linearaccel",   "linearacceleration",
    "arss",   "f",         "specificforce", "accelerations"};
/// The first that is there counts.
constexpr std::array<std::string_view, 14> kTimeNames{
    "headerstamp", "timestamp", "stamp",       "time",       "t",     "timestampns", "timens",
    "timestampus", "timeus",    "timestampms", "timestamps", "times", "gpstime",     "utctime"};
constexpr std::array<std::string_view, 6> kSecondNames{
    "sec", "secs", "seconds", "headerstampsec", "headerstampsecs", "stampsec"};
constexpr std::array<std::string_view, 9> kNanosecondNames{
    "nsec",     "nsecs", "nanosec", "nanosecs", "nansec", "nanoseconds", "headerstampnsec", "headerstampnanosec",
    "stampnsec"};

void take_axis(const std::string& name, std::size_t place, ImuColumns& columns) {
  if (name.size() < 2) return;
  const char last = name.back();
  if (last < 'x' || last > 'z') return;
  const auto axis = static_cast<std::size_t>(last - 'x');
  const std::string_view stem = std::string_view(name).substr(0, name.size() - 1);
  if (among(kGyroNames, stem) && !columns.gyro[axis]) columns.gyro[axis] = place;
  if (among(kAccNames, stem) && !columns.acc[axis]) columns.acc[axis] = place;
}

/// The numbers of a line need not be times, so that "nan" is one.
bool is_number(std::string_view text) {
  if (text.starts_with('+')) text.remove_prefix(1);
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc{} && end == text.data() + text.size();
}

std::vector<std::string_view> names_in(std::string_view text) {
  std::vector<std::string_view> names;
  while (!text.empty()) {
    const std::size_t end = text.find_first_of(" ,\t");
    if (end != 0) names.push_back(text.substr(0, end));
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
  }
  return names;
}

struct Row {
  Decimal time;
  std::optional<Decimal> nanoseconds;
  ImuSample sample;
};

class ImuTableReader {
 public:
  ImuTableReader(const std::filesystem::path& path, const std::string& columns) : path_(path), lines_(path) {
    if (!columns.empty()) columns_ = find_imu_columns(names_in(columns));
  }

  std::vector<ImuSample> read(std::vector<std::string>& verdicts, std::vector<std::string>& warnings) {
    while (lines_.next()) {
      if (!is_data()) continue;
      if (!columns_.complete()) refuse_columns();
      if (!lines_.complete() && lines_.cells().size() <= columns_.last()) {
        warnings.push_back(fmt::format("{}: the last line is cut off", path_.string()));
        break;
      }
      add(row());
    }
    if (samples_.empty()) convert();
    verdicts.push_back(fmt::format("imu stamps: {}, {}", path_.filename().string(), unit_name_));
    return std::move(samples_);
  }

 private:
  /// Lines before the first one of numbers may name the columns.
  bool is_data() {
    const auto& cells = lines_.cells();
    if (is_number(cells.front())) return true;
    if (begun_) {
      if (cells.front().starts_with('#')) return false;
      lines_.refuse(fmt::format("'{}' is no number", cells.front().substr(0, 32)));
    }
    std::vector<std::string_view> names = cells;
    if (names.size() > 1 && (names.front() == "#" || names.front() == "%")) names.erase(names.begin());
    if (const ImuColumns found = find_imu_columns(names); found.complete()) columns_ = found;
    return false;
  }

  [[noreturn]] void refuse_columns() const {
    lines_.refuse(
        "no line before names columns of time, angular rate and acceleration (like `timestamp,wx,wy,wz,ax,ay,az`); "
        "put one there, or name them in `imu_columns` of the sensor file");
  }

  std::string_view cell(std::size_t place) const {
    if (place < lines_.cells().size()) return lines_.cells()[place];
    lines_.refuse(fmt::format("it has {} columns, not {}", lines_.cells().size(), columns_.last() + 1));
  }

  double number(std::size_t place) const {
    std::string_view text = cell(place);
    if (text.starts_with('+')) text.remove_prefix(1);
    double value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc{} || end != text.data() + text.size()) {
      lines_.refuse(fmt::format("'{}' in column {} is no number", text.substr(0, 32), place + 1));
    }
    return value;
  }

  Decimal time(std::size_t place) const {
    const auto value = Decimal::parse(cell(place));
    if (!value) lines_.refuse(fmt::format("'{}' in column {} is no time", cell(place).substr(0, 32), place + 1));
    return *value;
  }

  Row row() {
    begun_ = true;
    Row row;
    row.time = time(*columns_.time);
    if (columns_.nanoseconds) row.nanoseconds = time(*columns_.nanoseconds);
    for (int axis = 0; axis < 3; ++axis) {
      row.sample.gyro[axis] = number(*columns_.gyro[static_cast<std::size_t>(axis)]);
      row.sample.acc[axis] = number(*columns_.acc[static_cast<std::size_t>(axis)]);
    }
    return row;
  }

  void add(const Row& row) {
    if (samples_.size() >= kMaxSamples) lines_.refuse(fmt::format("there are more than {} samples", kMaxSamples));
    if (!unit_known_) {
      waiting_.push_back(row);
      if (waiting_.size() >= kJudged) convert();
    } else {
      append(row);
    }
  }

  /// The samples that waited for the unit of time to be judged.
  void convert() {
    judge_unit();
    unit_known_ = true;
    for (const Row& row : waiting_) append(row);
    waiting_.clear();
  }

  void judge_unit() {
    if (columns_.nanoseconds) {
      unit_name_ = "columns of s and ns";
      power_ = 9;
      return;
    }
    constexpr double kLeastStep = 3e-4, kLargestStep = 0.299;
    std::vector<Decimal> times;
    for (const Row& row : waiting_) times.push_back(row.time);
    const DecimalUnit* unit = judge_time_unit(times, kLeastStep, kLargestStep);
    if (unit == nullptr && !waiting_.empty()) {
      throw DataError(
          fmt::format("{}: the steps of its times are those of an IMU (3.3 to 3300 Hz) in none of s, ms, us, "
                      "ns; is column {} the time?",
                      path_.string(), *columns_.time + 1));
    }
    unit_name_ = fmt::format("in {}", unit == nullptr ? "no unit" : unit->name);
    power_ = unit == nullptr ? 0 : unit->power;
  }

  void append(Row row) {
    const auto stamp = row.time.times_power(power_);
    const auto rest = row.nanoseconds ? row.nanoseconds->times_power(0) : std::optional<std::int64_t>(0);
    constexpr std::int64_t kFarthest = (std::int64_t{1} << 33) * kSecond;
    if (!stamp || !rest || std::abs(*stamp) > kFarthest || std::abs(*rest) > kSecond) {
      throw DataError(fmt::format("{}: sample {}: its time {:.17g} does not fit {}", path_.string(),
                                  samples_.size() + 1, row.time.value(), unit_name_));
    }
    row.sample.t = *stamp + *rest;
    samples_.push_back(row.sample);
  }

  std::filesystem::path path_;
  NumberLines lines_;
  ImuColumns columns_;
  std::vector<Row> waiting_;
  std::vector<ImuSample> samples_;
  std::string unit_name_;
  int power_ = 0;
  bool unit_known_ = false, begun_ = false;
};

}  // namespace

bool ImuColumns::complete() const {
  const auto there = [](const auto& place) { return place.has_value(); };
  return time && std::all_of(gyro.begin(), gyro.end(), there) && std::all_of(acc.begin(), acc.end(), there);
}

std::size_t ImuColumns::last() const {
  std::size_t largest = std::max(*time, nanoseconds.value_or(0));
  for (std::size_t axis = 0; axis < 3; ++axis) largest = std::max({largest, *gyro[axis], *acc[axis]});
  return largest;
}

ImuColumns find_imu_columns(std::span<const std::string_view> names) {
  ImuColumns columns;
  std::optional<std::size_t> seconds;
  std::size_t rank = kTimeNames.size();
  for (std::size_t i = 0; i < names.size(); ++i) {
    const std::string name = bare(names[i]);
    take_axis(name, i, columns);
    if (among(kSecondNames, name) && !seconds) seconds = i;
    if (among(kNanosecondNames, name) && !columns.nanoseconds) columns.nanoseconds = i;
    const auto found = std::find(kTimeNames.begin(), kTimeNames.end(), name);
    const auto place = static_cast<std::size_t>(found - kTimeNames.begin());
    if (place >= rank) continue;
    rank = place;
    columns.time = i;
  }
  if (seconds && columns.nanoseconds) {
    columns.time = seconds;
  } else {
    columns.nanoseconds.reset();
    if (!columns.time) columns.time = seconds;
  }
  return columns;
}

bool is_imu_table(const std::filesystem::path& path) {
  try {
    NumberLines lines(path);
    for (std::size_t i = 0; i < kMaxHeaderLines && lines.next(); ++i) {
      if (is_number(lines.cells().front())) return false;
      if (find_imu_columns(lines.cells()).complete()) return true;
    }
  } catch (const DataError&) {  // no table
  }
  return false;
}

std::vector<ImuSample> read_imu_table(const std::filesystem::path& path, const std::string& columns,
                                      std::vector<std::string>& verdicts, std::vector<std::string>& warnings) {
  return ImuTableReader(path, columns).read(verdicts, warnings);
}

}  // namespace aslio::io
