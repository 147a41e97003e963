#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "cloud.hpp"

namespace aslio::io::decode {
namespace {

struct Unit {
  std::string_view name;
  TimeUnit declared;
  double seconds, to_ns;
};
constexpr std::array<Unit, 4> kUnits{{{"s", TimeUnit::s, 1, 1e9},
                                      {"ms", TimeUnit::ms, 1e-3, 1e6},
                                      {"us", TimeUnit::us, 1e-6, 1e3},
                                      {"ns", TimeUnit::ns, 1e-9, 1}}};

/// nullptr: none in which such a span is that of a sweep, or of the part of it that a narrow view covers. Units differ
/// by 1000, the admissible spans by 100: at most one unit fits.
const Unit* unit_of(double span, double sweep_period) {
  constexpr double kSmallest = 0.03, kLargest = 3.0;
  const auto fits = [&](const Unit& unit) {
    return span * unit.seconds > kSmallest * sweep_period && span * unit.seconds < kLargest * sweep_period;
  };
  const auto found = std::find_if(kUnits.begin(), kUnits.end(), fits);
  return found == kUnits.end() ? nullptr : &*found;
}

const Unit* declared_unit(TimeUnit unit) {
  const auto found = std::find_if(kUnits.begin(), kUnits.end(), [unit](const Unit& u) { return u.declared == unit; });
  return found == kUnits.end() ? nullptr : &*found;
}

std::string no_field(const CloudTable& table, const std::string& wanted) {
  if (!wanted.empty()) {
    return fmt::format("there is no field '{}' (`point_time_field`) among: {}", wanted, table.all_names);
  }
  std::string text = fmt::format(
      "there is no time field (t, time, time_stamp, timestamp, timestamps, offset_time) among: {}", table.all_names);
  if (!table.time_like.empty()) text += fmt::format("; if '{0}' is one, set `point_time_field: {0}`", table.time_like);
  return text;
}

/// From the header stamp to the moment that relative times count from.
TimeNs shift_of(bool from_end, LidarStamp stamp, double sweep_period) {
  const double lag = stamp == LidarStamp::start ? 0 : stamp == LidarStamp::middle ? 0.5 : 1;
  if (stamp == LidarStamp::automatic) return 0;
  return to_ns(sweep_period * ((from_end ? 1 : 0) - lag));
}

/// Times in seconds, on which the reference is judged.
struct Span {
  double low = 0, high = 0, stamp = 0;
};

/// Why times that run so cannot be referred to anything; empty where `rule` has been set.
std::string judge_reference(const Span& span, const CloudTimeFacts& facts, CloudTimeRule& rule) {
  const double near = 1.5 * facts.sweep_period;
  const double relative = std::min(std::abs(span.low), std::abs(span.high));
  const double absolute = std::min(std::abs(span.low - span.stamp), std::abs(span.high - span.stamp));
  const PointTime declared = facts.declared.point_time;
  if (declared == PointTime::start || declared == PointTime::end) return {};
  if (declared == PointTime::absolute) {
    rule.absolute = true;
    rule.own_clock = absolute > near;
    return {};
  }
  if (std::min(relative, absolute) <= near) {
    rule.absolute = absolute < relative;
    return {};
  }
  constexpr double kSameClock = 60;  // [s] of the beginning of the recording
  if (facts.imu_time && std::abs(span.low - to_seconds(*facts.imu_time)) < kSameClock) {
    rule.absolute = rule.own_clock = true;
    return {};
  }
  return "neither near 0 nor near the header stamp, and not of the IMU's clock either: set `point_time: absolute` if "
         "these times are right, or correct them by `lidar_time_offset`";
}

std::string reference_words(const CloudTimeRule& rule) {
  if (rule.own_clock) return "absolute, the header stamp is of another clock and is not used";
  return rule.absolute ? "absolute" : "relative to the header stamp";
}

/// A span that is far from a sweep's: a narrow view, or another scale.
std::string doubt_of(double span, double sweep_period) {
  constexpr double kFactor = 2;
  if (span * kFactor >= sweep_period && span <= kFactor * sweep_period) return {};
  return fmt::format(
      "the times of points span {:.6f} s of a sweep of {} s: is the view limited? If it is not, set `point_time_unit`, "
      "or check `sweep_period`",
      span, sweep_period);
}

}  // namespace

CloudTimeRule judge_cloud_times(const CloudView& view, const CloudTimeFacts& facts) {
  CloudTimeRule rule;
  const CloudTable& table = view.table;
  if (!table.time.present()) {
    rule.verdict = no_field(table, facts.declared.point_time_field);
    return rule;
  }
  const auto [all, middle] = cloud_time_extents(view);
  const std::string field = fmt::format("field '{}' ({})", table.time_name, cloud_datatype_name(table.time.datatype));
  const double span = all.high - all.low;
  if (span <= 0) {
    rule.verdict = fmt::format("{} is {} in all {} points", field, all.low, all.count);
    return rule;
  }
  // A few damaged times may make the span that of a sweep in another unit.
  const Unit* unit = unit_of(middle.high - middle.low, facts.sweep_period);
  const CloudTimeExtent& extent = unit == nullptr || unit_of(span, facts.sweep_period) == unit ? all : middle;
  if (unit == nullptr) unit = unit_of(span, facts.sweep_period);
  if (const Unit* declared = declared_unit(facts.declared.point_time_unit)) unit = declared;
  if (unit == nullptr) {
    rule.verdict = fmt::format("{} spans {:.6g}, which is a sweep of {} s in none of s, ms, us, ns", field, span,
                               facts.sweep_period);
    return rule;
  }
  const Span times{extent.low * unit->seconds, extent.high * unit->seconds, to_seconds(view.stamp)};
  if (const std::string why = judge_reference(times, facts, rule); !why.empty()) {
    rule.verdict = fmt::format("{} runs from {:.6f} to {:.6f} s, the header stamp is {:.6f} s: {}", field, times.low,
                               times.high, times.stamp, why);
    return rule;
  }
  rule.known = true;
  rule.datatype = table.time.datatype;
  rule.to_ns = unit->to_ns;
  const double origin = rule.own_clock ? times.low : rule.absolute ? times.stamp : 0.0;
  const bool last = times.high - origin < 0.3 * facts.sweep_period && times.low - origin < -0.3 * facts.sweep_period;
  const bool from_end = facts.declared.point_time == PointTime::end || last;
  if (!rule.absolute) rule.shift = shift_of(from_end, facts.declared.lidar_stamp, facts.sweep_period);
  rule.doubt = doubt_of(times.high - times.low, facts.sweep_period);
  rule.verdict =
      fmt::format("{}, {}, {} ({:.6f} to {:.6f} s from {}{}{})", field, unit->name, reference_words(rule),
                  times.low - origin, times.high - origin, rule.own_clock ? "the first" : "the header stamp",
                  last ? ", which is of the last packet" : "",
                  rule.shift == 0 ? "" : fmt::format("; {:+.3f} s by `lidar_stamp`", to_seconds(rule.shift)));
  return rule;
}

}  // namespace aslio::io::decode
