#include "cloud.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>
#include <vector>

#include "wire.hpp"

namespace aslio::io::decode {
namespace {

constexpr std::array<std::uint32_t, 9> kSizes{0, 1, 1, 2, 2, 4, 4, 4, 8};
constexpr std::array<std::string_view, 9> kNames{"",      "int8",   "uint8",   "int16",  "uint16",
                                                 "int32", "uint32", "float32", "float64"};
constexpr std::array<std::string_view, 6> kTimeNames{"t",         "time",       "time_stamp",
                                                     "timestamp", "timestamps", "offset_time"};
constexpr std::uint32_t kMaxFields = 256;
constexpr std::uint64_t kMaxPoints = 1U << 26U;

template <class T>
double as_double(const std::uint8_t* from) {
  T value;
  std::memcpy(&value, from, sizeof(T));
  return static_cast<double>(value);
}

double scalar(const std::uint8_t* point, const CloudField& field) {
  const std::uint8_t* from = point + field.offset;
  switch (field.datatype) {
    case 1:
      return as_double<std::int8_t>(from);
    case 2:
      return as_double<std::uint8_t>(from);
    case 3:
      return as_double<std::int16_t>(from);
    case 4:
      return as_double<std::uint16_t>(from);
    case 5:
      return as_double<std::int32_t>(from);
    case 6:
      return as_double<std::uint32_t>(from);
    case 7:
      return as_double<float>(from);
    case 8:
      return as_double<double>(from);
    default:
      return 0;
  }
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
      std::memcpy(&p[axis], point + field.offset, 4);
    } else {
      const double value = scalar(point, field);
      p[axis] = std::abs(value) < double{kFarthest} ? static_cast<float>(value) : kFarthest;
    }
  }
  return p;
}

void place(std::string_view name, const CloudField& field, CloudTable& table) {
  constexpr std::array<std::string_view, 3> kAxes{"x", "y", "z"};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (name == kAxes[axis] && field.datatype >= 7) table.xyz[axis] = field;
  }
  if (name == "intensity" || (name == "reflectivity" && !table.intensity.present())) table.intensity = field;
  if (name == "ring" || name == "line") {
    table.ring = field;
    table.livox_lines = name == "line";
  }
  if (name == "tag" && field.datatype == 2) table.tag = field;
  if (!table.time.present() && std::find(kTimeNames.begin(), kTimeNames.end(), name) != kTimeNames.end()) {
    table.time = field;
    table.time_name = name;
  }
  table.all_names += fmt::format("{}{} {}", table.all_names.empty() ? "" : ", ", std::string_view(name).substr(0, 32),
                                 kNames[field.datatype]);
}

std::string parse_fields(Wire& wire, std::uint32_t count, CloudTable& table, std::uint64_t& extent) {
  if (count > kMaxFields) return fmt::format("it claims {} fields (at most {})", count, kMaxFields);
  for (std::uint32_t i = 0; i < count; ++i) {
    std::string name(wire.text());
    std::replace_if(
        name.begin(), name.end(), [](unsigned char c) { return c < 0x20 || c == 0x7f; }, '?');
    const std::uint32_t offset = wire.get<std::uint32_t>();
    const std::uint8_t datatype = wire.get<std::uint8_t>();
    const std::uint32_t repeat = wire.get<std::uint32_t>();
    if (!wire.ok()) return "the message ends inside its field table";
    if (datatype == 0 || datatype > 8) {
      return fmt::format("field '{}' has the unknown datatype {}", name.substr(0, 32), datatype);
    }
    const std::uint64_t bytes = std::uint64_t{kSizes[datatype]} * std::max<std::uint32_t>(repeat, 1);
    extent = std::max(extent, offset + bytes);
    if (repeat <= 1) place(name, {offset, datatype}, table);
  }
  return {};
}

struct Extent {
  double low = 0, high = 0;
  std::size_t count = 0;
};

template <class Visit>
void each_point(const CloudView& view, Visit&& visit) {
  if (view.width == 0) return;  // however many rows of nothing are claimed
  for (std::uint32_t row = 0; row < view.height; ++row) {
    const std::uint8_t* point = view.data.data() + static_cast<std::size_t>(row) * view.row_step;
    for (std::uint32_t i = 0; i < view.width; ++i, point += view.point_step) visit(point);
  }
}

/// Of all returns, and of their middle nine tenths, which damage of a few leaves alone.
std::array<Extent, 2> time_extents(const CloudView& view) {
  std::vector<double> times;
  each_point(view, [&](const std::uint8_t* point) {
    const auto p = position(point, view.table);
    const double t = scalar(point, view.table.time);
    if (is_return(p[0], p[1], p[2]) && std::isfinite(t)) times.push_back(t);
  });
  if (times.empty()) return {};
  std::sort(times.begin(), times.end());
  const std::size_t rim = times.size() / 20;
  return {Extent{times.front(), times.back(), times.size()},
          Extent{times[rim], times[times.size() - 1 - rim], times.size()}};
}

// Units differ by 1000, the admissible spans by 30: at most one unit fits.
struct Unit {
  std::string_view name;
  double seconds, to_ns;
};
constexpr std::array<Unit, 4> kUnits{{{"s", 1, 1e9}, {"ms", 1e-3, 1e6}, {"us", 1e-6, 1e3}, {"ns", 1e-9, 1}}};

/// nullptr: none in which such a span is that of a sweep.
const Unit* unit_of(double span, double sweep_period) {
  const auto fits = [&](const Unit& unit) {
    return span * unit.seconds > 0.1 * sweep_period && span * unit.seconds < 3.0 * sweep_period;
  };
  const auto found = std::find_if(kUnits.begin(), kUnits.end(), fits);
  return found == kUnits.end() ? nullptr : &*found;
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

std::string parse_cloud(const Message& message, CloudView& view, bool& systematic) {
  Wire wire(message);
  view = CloudView{};
  systematic = false;
  view.stamp = wire.header();
  view.height = wire.get<std::uint32_t>();
  view.width = wire.get<std::uint32_t>();
  std::uint64_t extent = 0;
  if (std::string why = parse_fields(wire, wire.get<std::uint32_t>(), view.table, extent); !why.empty()) return why;
  const bool big_endian = wire.get<std::uint8_t>() != 0;
  view.point_step = wire.get<std::uint32_t>();
  view.row_step = wire.get<std::uint32_t>();
  view.data = wire.take(wire.get<std::uint32_t>());
  if (!wire.ok()) return wire.problem("a PointCloud2 of its size");
  if (big_endian) {
    systematic = true;
    return "it is flagged big-endian, which no known driver sends; convert the bag";
  }
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
  if (std::uint64_t{view.width} * view.point_step > view.row_step && view.height > 1) {
    return fmt::format("a row of {} points of {} bytes does not fit a row step of {}", view.width, view.point_step,
                       view.row_step);
  }
  const std::uint64_t needed =
      std::uint64_t{view.row_step} * (view.height - 1) + std::uint64_t{view.width} * view.point_step;
  if (needed > view.data.size()) {
    return fmt::format("its {} points need {} bytes, {} are there", points, needed, view.data.size());
  }
  return {};
}

CloudTimeRule judge_cloud_times(const CloudView& view, double sweep_period) {
  CloudTimeRule rule;
  const CloudTable& table = view.table;
  if (!table.time.present()) {
    rule.verdict = fmt::format(
        "there is no time field (t, time, time_stamp, timestamp, timestamps, offset_time) among: {}", table.all_names);
    return rule;
  }
  const auto [all, middle] = time_extents(view);
  const std::string field = fmt::format("field '{}' ({})", table.time_name, kNames[table.time.datatype]);
  const double span = all.high - all.low;
  if (span <= 0) {
    rule.verdict = fmt::format("{} is {} in all {} points", field, all.low, all.count);
    return rule;
  }
  // A few damaged times may make the span that of a sweep in another unit.
  const Unit* unit = unit_of(middle.high - middle.low, sweep_period);
  const Extent& extent = unit == nullptr || unit_of(span, sweep_period) == unit ? all : middle;
  if (unit == nullptr) unit = unit_of(span, sweep_period);
  if (unit == nullptr) {
    rule.verdict =
        fmt::format("{} spans {:.6g}, which is a sweep of {} s in none of s, ms, us, ns", field, span, sweep_period);
    return rule;
  }
  const double low = extent.low * unit->seconds, high = extent.high * unit->seconds, stamp = to_seconds(view.stamp);
  const double relative = std::min(std::abs(low), std::abs(high));
  const double absolute = std::min(std::abs(low - stamp), std::abs(high - stamp));
  if (std::min(relative, absolute) > 1.5 * sweep_period) {
    rule.verdict = fmt::format(
        "{} runs from {:.6f} to {:.6f} s: neither near 0 nor near the header stamp {:.6f} s; "
        "the clocks of driver and sensor differ",
        field, low, high, stamp);
    return rule;
  }
  rule.known = true;
  rule.datatype = table.time.datatype;
  rule.to_ns = unit->to_ns;
  rule.absolute = absolute < relative;
  const double shift = rule.absolute ? stamp : 0.0;
  const bool last = high - shift < 0.3 * sweep_period && low - shift < -0.3 * sweep_period;
  rule.verdict = fmt::format("{}, {}, {} ({:.6f} to {:.6f} s from the header stamp{})", field, unit->name,
                             rule.absolute ? "absolute" : "relative to the header stamp", low - shift, high - shift,
                             last ? ", which is of the last packet" : "");
  return rule;
}

std::string decode_cloud(const CloudView& view, const CloudRule& rule, LidarPacket& packet) {
  const CloudTable& table = view.table;
  const bool timed = rule.time.known;
  const bool filter_tags = rule.tag_filter && table.tag.present() && table.livox_lines;
  const double longest = static_cast<double>(rule.longest_offset);
  packet.stamp = view.stamp;
  packet.points.clear();
  if (std::string why = unlike(view, rule.time); !why.empty()) return why;
  packet.points.reserve(static_cast<std::size_t>(view.width) * view.height);
  packet.beyond_lines = 0;
  const auto note_beyond = [&packet](std::uint8_t line) {
    ++packet.beyond_lines;
    packet.highest_line = std::max(packet.highest_line, line);
  };
  TimeNs first = kTimeMax, last = kTimeMin;
  each_point(view, [&](const std::uint8_t* from) {
    const auto p = position(from, table);
    if (!is_return(p[0], p[1], p[2])) return;
    TimedPoint point;
    if (table.tag.present()) point.tag = from[table.tag.offset];
    if (filter_tags && (point.tag & 0x30U) != 0x00 && (point.tag & 0x30U) != 0x10) return;
    if (table.ring.present()) point.line = small(from, table.ring);
    const bool beyond = table.livox_lines && point.line >= rule.scan_lines;
    point.t = view.stamp;
    if (timed) {
      const double value = scalar(from, table.time);
      const double offset = value * rule.time.to_ns - (rule.time.absolute ? static_cast<double>(view.stamp) : 0.0);
      if (!(std::abs(offset) <= longest)) return;
      if (beyond) return note_beyond(point.line);
      point.t = rule.time.absolute ? exact_ns(value, rule.time.to_ns) : view.stamp + std::llround(offset);
      first = std::min(first, point.t);
      last = std::max(last, point.t);
    }
    if (beyond) return note_beyond(point.line);
    point.x = p[0];
    point.y = p[1];
    point.z = p[2];
    if (table.intensity.present()) point.intensity = static_cast<float>(scalar(from, table.intensity));
    point.sweep_id = packet.sweep_id;
    packet.points.push_back(point);
  });
  packet.dropped_invalid = static_cast<std::size_t>(view.width) * view.height - packet.points.size();
  constexpr std::size_t kSomePoints = 16;
  if (timed && first == last && packet.points.size() > kSomePoints) {
    return fmt::format("all {} points have the same time", packet.points.size());
  }
  return {};
}

}  // namespace aslio::io::decode
