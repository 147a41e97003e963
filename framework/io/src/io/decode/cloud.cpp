#include "cloud.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <optional>
#include <string_view>
#include <vector>

#include "wire.hpp"

namespace aslio::io::decode {
namespace {

/// Datatypes 1 to 11 of sensor_msgs/PointField; 9 to 11 came with ROS2.
constexpr std::array<std::uint32_t, 12> kSizes{0, 1, 1, 2, 2, 4, 4, 4, 8, 8, 8, 1};
constexpr std::array<std::string_view, 12> kNames{"",       "int8",    "uint8",   "int16", "uint16", "int32",
                                                  "uint32", "float32", "float64", "int64", "uint64", "bool"};
constexpr std::array<std::string_view, 6> kTimeNames{"t",         "time",       "time_stamp",
                                                     "timestamp", "timestamps", "offset_time"};
constexpr std::uint32_t kMaxFields = 256;
constexpr std::uint64_t kMaxPoints = 1U << 26U;

template <class T>
double as_double(const std::uint8_t* from, bool swapped) {
  return static_cast<double>(load<T>(from, swapped));
}

double scalar(const std::uint8_t* point, const CloudField& field) {
  const std::uint8_t* from = point + field.offset;
  switch (field.datatype) {
    case 1:
      return as_double<std::int8_t>(from, false);
    case 2:
    case 11:
      return as_double<std::uint8_t>(from, false);
    case 3:
      return as_double<std::int16_t>(from, field.swapped);
    case 4:
      return as_double<std::uint16_t>(from, field.swapped);
    case 5:
      return as_double<std::int32_t>(from, field.swapped);
    case 6:
      return as_double<std::uint32_t>(from, field.swapped);
    case 7:
      return as_double<float>(from, field.swapped);
    case 8:
      return as_double<double>(from, field.swapped);
    case 9:
      return as_double<std::int64_t>(from, field.swapped);
    case 10:
      return as_double<std::uint64_t>(from, field.swapped);
    default:
      return 0;
  }
}

/// A time in ns as it stands in the field: an epoch in a double is rounded to 256 ns. Pre: an integer of 64 bits.
TimeNs whole_ns(const std::uint8_t* point, const CloudField& field, double to_ns) {
  const auto value = load<std::int64_t>(point + field.offset, field.swapped);
  const auto factor = static_cast<TimeNs>(to_ns);
  return value > kTimeMax / factor || value < kTimeMin / factor ? kTimeMax : value * factor;
}

/// value * to_ns without the rounding of an epoch in ns to the 256 ns of a double. Pre: the product fits 63 bits.
TimeNs exact_ns(double value, double to_ns) {
  const double whole = std::floor(value);
  return static_cast<TimeNs>(whole) * static_cast<TimeNs>(to_ns) + std::llround((value - whole) * to_ns);
}

/// A field of small integers; what does not fit becomes 255.
std::uint8_t small(const std::uint8_t* point, const CloudField& field) {
  if (field.datatype == 2) return point[field.offset];
  const double value = scalar(point, field);
  return value >= 0 && value < 255 ? static_cast<std::uint8_t>(value) : std::uint8_t{255};
}

std::array<float, 3> position(const std::uint8_t* point, const CloudTable& table) {
  std::array<float, 3> p{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const CloudField& field = table.xyz[axis];
    if (field.datatype == 7) {
      p[axis] = load<float>(point + field.offset, field.swapped);
    } else {
      const double value = scalar(point, field);
      p[axis] = std::abs(value) < double{kFarthest} ? static_cast<float>(value) : kFarthest;
    }
  }
  return p;
}

bool speaks_of_time(std::string_view name) {
  std::string lower(name);
  std::transform(lower.begin(), lower.end(), lower.begin(), [](unsigned char c) { return std::tolower(c); });
  return lower.find("time") != std::string::npos || lower.find("stamp") != std::string::npos;
}

bool is_ring(std::string_view name) {
  constexpr std::array<std::string_view, 6> kNames{"ring", "line", "channel", "laser_id", "laser_number", "ring_id"};
  return std::find(kNames.begin(), kNames.end(), name) != kNames.end();
}

void place(std::string_view name, const CloudField& field, std::string_view time_field, CloudTable& table) {
  constexpr std::array<std::string_view, 3> kAxes{"x", "y", "z"};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (name == kAxes[axis] && (field.datatype == 7 || field.datatype == 8)) table.xyz[axis] = field;
  }
  if (name == "intensity" || (name == "reflectivity" && !table.intensity.present())) table.intensity = field;
  if (is_ring(name) && (!table.ring.present() || name == "ring" || name == "line")) {
    table.ring = field;
    table.livox_lines = name == "line";
  }
  if (name == "tag" && field.datatype == 2) table.tag = field;
  const bool known = std::find(kTimeNames.begin(), kTimeNames.end(), name) != kTimeNames.end();
  if (time_field.empty() ? known && !table.time.present() : name == time_field) {
    table.time = field;
    table.time_name = name;
  } else if (table.time_like.empty() && speaks_of_time(name)) {
    table.time_like = std::string(name).substr(0, 32);
  }
}

std::string parse_fields(Wire& wire, std::uint32_t count, std::string_view time_field, CloudTable& table,
                         std::uint64_t& extent) {
  if (count > kMaxFields) return fmt::format("it claims {} fields (at most {})", count, kMaxFields);
  for (std::uint32_t i = 0; i < count; ++i) {
    std::string name(wire.text());
    std::replace_if(
        name.begin(), name.end(), [](unsigned char c) { return c < 0x20 || c == 0x7f; }, '?');
    const std::uint32_t offset = wire.get<std::uint32_t>();
    const std::uint8_t datatype = wire.get<std::uint8_t>();
    const std::uint32_t repeat = wire.get<std::uint32_t>();
    if (!wire.ok()) return "the message ends inside its field table";
    // A type that came later is no harm in a field that nobody needs.
    const bool known = datatype > 0 && datatype < kSizes.size();
    table.all_names += fmt::format("{}{} {}", table.all_names.empty() ? "" : ", ", std::string_view(name).substr(0, 32),
                                   known ? std::string(kNames[datatype]) : fmt::format("of datatype {}", datatype));
    if (!known) continue;
    const std::uint64_t bytes = std::uint64_t{kSizes[datatype]} * std::max<std::uint32_t>(repeat, 1);
    extent = std::max(extent, offset + bytes);
    if (repeat <= 1) place(name, {offset, datatype}, time_field, table);
  }
  return {};
}

template <class Visit>
void each_point(const CloudView& view, Visit&& visit) {
  if (view.width == 0) return;  // however many rows of nothing are claimed
  for (std::uint32_t row = 0; row < view.height; ++row) {
    const std::uint8_t* point = view.data.data() + static_cast<std::size_t>(row) * view.row_step;
    for (std::uint32_t i = 0; i < view.width; ++i, point += view.point_step) visit(point);
  }
}

/// Checks the size of the data against the table. Drivers compute the row step wrongly, while the rows are dense: then
/// the data are as long as the points need.
std::string judge_rows(CloudView& view, std::uint64_t points) {
  const std::uint64_t row = std::uint64_t{view.width} * view.point_step;
  if (view.data.size() == points * view.point_step && view.row_step != row) {
    view.row_step_wrong = view.height > 1;
    view.row_step = static_cast<std::uint32_t>(row);
  }
  if (row > view.row_step && view.height > 1) {
    return fmt::format("a row of {} points of {} bytes does not fit a row step of {}", view.width, view.point_step,
                       view.row_step);
  }
  const std::uint64_t needed = std::uint64_t{view.row_step} * (view.height - 1) + row;
  if (needed <= view.data.size()) return {};
  return fmt::format("its {} points need {} bytes, {} are there", points, needed, view.data.size());
}

void swap_fields(CloudTable& table) {
  for (CloudField* field :
       {&table.xyz[0], &table.xyz[1], &table.xyz[2], &table.intensity, &table.ring, &table.tag, &table.time}) {
    field->swapped = true;
  }
}

/// Simulators set the flag of big-endian data and send little-endian ones: values that could be ranges decide.
bool more_plausible_swapped(const CloudView& view) {
  CloudTable swapped = view.table;
  swap_fields(swapped);
  std::ptrdiff_t balance = 0;
  const auto plausible = [](const std::array<float, 3>& p) {
    constexpr float kNearest = 1e-3F, kFarPoint = 1e3F;
    const float largest = std::max({std::abs(p[0]), std::abs(p[1]), std::abs(p[2])});
    return largest > kNearest && largest < kFarPoint;  // false for what is not finite
  };
  each_point(view, [&](const std::uint8_t* point) {
    balance += plausible(position(point, swapped)) ? 1 : 0;
    balance -= plausible(position(point, view.table)) ? 1 : 0;
  });
  return balance > 0;
}

/// Why a known rule does not serve for a cloud; empty where it does. One without points has no time to lose.
std::string unlike(const CloudView& view, const CloudTimeRule& rule) {
  const CloudTable& table = view.table;
  if (!rule.known || table.time.datatype == rule.datatype || view.width == 0 || view.height == 0) return {};
  if (!table.time.present()) {
    return fmt::format("it has no time field, which clouds before it have (fields: {})", table.all_names);
  }
  return fmt::format("its time field '{}' is {}, that of clouds before it {}", table.time_name,
                     kNames[table.time.datatype], kNames[rule.datatype]);
}

}  // namespace

std::string parse_cloud(const Message& message, CloudView& view, bool& systematic, std::string_view time_field) {
  Wire wire(message);
  view = CloudView{};
  systematic = false;
  view.stamp = wire.header();
  view.frame = wire.frame();
  view.height = wire.get<std::uint32_t>();
  view.width = wire.get<std::uint32_t>();
  std::uint64_t extent = 0;
  if (std::string why = parse_fields(wire, wire.get<std::uint32_t>(), time_field, view.table, extent); !why.empty())
    return why;
  view.flagged_big_endian = wire.get<std::uint8_t>() != 0;
  view.point_step = wire.get<std::uint32_t>();
  view.row_step = wire.get<std::uint32_t>();
  view.data = wire.take(wire.get<std::uint32_t>());
  if (!wire.ok()) return wire.problem("a PointCloud2 of its size");
  for (const CloudField& field : view.table.xyz) {
    if (field.present()) continue;
    systematic = true;
    return fmt::format("it has no x, y, z of type float32 or float64 (fields: {})", view.table.all_names);
  }
  if (extent > view.point_step) {
    return fmt::format("its fields reach to byte {} of a point of {} bytes", extent, view.point_step);
  }
  // All factors are below 2^32: the products fit 64 bits.
  const std::uint64_t points = std::uint64_t{view.width} * view.height;
  if (points > kMaxPoints) return fmt::format("it claims {} x {} points", view.width, view.height);
  if (points == 0) return {};
  if (std::string why = judge_rows(view, points); !why.empty()) return why;
  if (view.flagged_big_endian && more_plausible_swapped(view)) swap_fields(view.table);
  return {};
}

std::string_view cloud_datatype_name(std::uint8_t datatype) { return kNames.at(datatype); }

std::array<CloudTimeExtent, 2> cloud_time_extents(const CloudView& view) {
  std::vector<double> times;
  each_point(view, [&](const std::uint8_t* point) {
    const auto p = position(point, view.table);
    const double t = scalar(point, view.table.time);
    if (is_return(p[0], p[1], p[2]) && std::isfinite(t)) times.push_back(t);
  });
  if (times.empty()) return {};
  std::sort(times.begin(), times.end());
  const std::size_t rim = times.size() / 20;  // damage of a few leaves the middle nine tenths alone
  return {CloudTimeExtent{times.front(), times.back(), times.size()},
          CloudTimeExtent{times[rim], times[times.size() - 1 - rim], times.size()}};
}

namespace {

/// The times of the points of one cloud, by a rule that is known.
class PointClock {
 public:
  PointClock(const CloudView& view, const CloudRule& rule)
      : field_(view.table.time),
        rule_(rule.time),
        longest_(static_cast<double>(rule.longest_offset)),
        base_(view.stamp + rule.time.shift),
        origin_(view.stamp),
        origin_known_(!rule.time.own_clock),
        whole_(field_.datatype == 9 || field_.datatype == 10) {}

  /// Nothing for a damaged time, far from the others.
  std::optional<TimeNs> at(const std::uint8_t* point) {
    constexpr double kLatest = 9e18;  // [ns] fits 63 bits
    const double value = scalar(point, field_);
    if (!origin_known_ && std::abs(value * rule_.to_ns) < kLatest) {
      origin_ = absolute(point, value);
      origin_known_ = true;
    }
    const double offset = value * rule_.to_ns - (rule_.absolute ? static_cast<double>(origin_) : 0.0);
    if (!(std::abs(offset) <= longest_)) return std::nullopt;
    return rule_.absolute ? absolute(point, value) : base_ + std::llround(offset);
  }

  /// The header stamp or, where that is of another clock, the time of the first return.
  TimeNs origin() const { return origin_; }

 private:
  TimeNs absolute(const std::uint8_t* point, double value) const {
    return whole_ ? whole_ns(point, field_, rule_.to_ns) : exact_ns(value, rule_.to_ns);
  }

  CloudField field_;
  const CloudTimeRule& rule_;
  double longest_;
  TimeNs base_, origin_;
  bool origin_known_, whole_;
};

}  // namespace

std::string decode_cloud(const CloudView& view, const CloudRule& rule, LidarPacket& packet) {
  const CloudTable& table = view.table;
  const bool timed = rule.time.known;
  const bool filter_tags = rule.tag_filter && table.tag.present() && table.livox_lines;
  PointClock clock(view, rule);
  packet.stamp = view.stamp;
  packet.points.clear();
  if (std::string why = unlike(view, rule.time); !why.empty()) return why;
  packet.points.reserve(static_cast<std::size_t>(view.width) * view.height);
  packet.beyond_lines = 0;
  TimeNs first = kTimeMax, last = kTimeMin;
  each_point(view, [&](const std::uint8_t* from) {
    const auto p = position(from, table);
    if (!is_return(p[0], p[1], p[2])) return;
    TimedPoint point;
    if (table.tag.present()) point.tag = from[table.tag.offset];
    if (filter_tags && (point.tag & 0x30U) != 0x00 && (point.tag & 0x30U) != 0x10) return;
    if (table.ring.present()) point.line = small(from, table.ring);
    const auto time = timed ? clock.at(from) : view.stamp;
    if (!time) return;
    if (table.livox_lines && point.line >= rule.scan_lines) {
      ++packet.beyond_lines;
      packet.highest_line = std::max(packet.highest_line, point.line);
      return;
    }
    point.t = *time;
    first = std::min(first, point.t);
    last = std::max(last, point.t);
    point.x = p[0];
    point.y = p[1];
    point.z = p[2];
    if (table.intensity.present()) point.intensity = static_cast<float>(scalar(from, table.intensity));
    point.sweep_id = packet.sweep_id;
    packet.points.push_back(point);
  });
  if (timed) packet.stamp = clock.origin();
  packet.dropped_invalid = static_cast<std::size_t>(view.width) * view.height - packet.points.size();
  constexpr std::size_t kSomePoints = 16;
  if (timed && first == last && packet.points.size() > kSomePoints) {
    return fmt::format("all {} points have the same time", packet.points.size());
  }
  return {};
}

}  // namespace aslio::io::decode
