#include "cloud_form.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>

#include "aslio/core/errors.hpp"

namespace aslio::io {
namespace {

using N = NumberType;
using P = PointPart;
constexpr double kSecondTicks = 1e9, kMicrosecondTicks = 1e3;

/// x, y, z and the intensity one behind the other, and `more`.
std::vector<FormField> with_xyzi(std::vector<FormField> more) {
  std::vector<FormField> fields = {{"x", 0, N::f32, P::x}, {"y", 4, N::f32, P::y}, {"z", 8, N::f32, P::z}};
  fields.push_back({"intensity", 12, N::f32, P::intensity});
  fields.insert(fields.end(), more.begin(), more.end());
  return fields;
}

/// As PCL aligns them: z is padded to 16 bytes, and a point to a multiple of 16.
std::vector<FormField> as_pcl(std::vector<FormField> more) {
  std::vector<FormField> fields = {{"x", 0, N::f32, P::x}, {"y", 4, N::f32, P::y}, {"z", 8, N::f32, P::z}};
  fields.push_back({"intensity", 16, N::f32, P::intensity});
  fields.insert(fields.end(), more.begin(), more.end());
  return fields;
}

CloudForm make_form(LidarForm form) {
  switch (form) {
    case LidarForm::ouster:
      return {as_pcl({{"t", 20, N::u32, P::time},
                      {"reflectivity", 24, N::u16, P::reflectivity},
                      {"ring", 26, N::u16, P::line},
                      {"ambient", 28, N::u16, P::nothing},
                      {"range", 32, N::u32, P::range_mm}}),
              48, PointOrigin::start, 1, true};
    case LidarForm::ouster_old:
      return {as_pcl({{"t", 20, N::u32, P::time},
                      {"reflectivity", 24, N::u16, P::reflectivity},
                      {"ring", 26, N::u8, P::line},
                      {"noise", 28, N::u16, P::nothing},
                      {"range", 32, N::u32, P::range_mm}}),
              48, PointOrigin::start, 1, true};
    case LidarForm::hesai:
      return {with_xyzi({{"ring", 16, N::u16, P::line}, {"timestamp", 18, N::f64, P::time}}), 26, PointOrigin::absolute,
              kSecondTicks, false};
    case LidarForm::hesai_general:
      return {as_pcl({{"timestamp", 24, N::f64, P::time}, {"ring", 32, N::u16, P::line}}), 48, PointOrigin::absolute,
              kSecondTicks, false};
    case LidarForm::livox_cloud:
      return {with_xyzi({{"tag", 16, N::u8, P::tag}, {"line", 17, N::u8, P::line}, {"timestamp", 18, N::f64, P::time}}),
              26, PointOrigin::absolute, 1, true};
    case LidarForm::helipr_ouster:
      return {with_xyzi({{"t", 16, N::u32, P::time},
                         {"reflectivity", 20, N::u16, P::reflectivity},
                         {"ring", 22, N::u16, P::line},
                         {"ambient", 24, N::u16, P::nothing}}),
              26, PointOrigin::start, 1, true};
    case LidarForm::boreas:
      return {with_xyzi({{"ring", 16, N::f32, P::line}, {"time", 20, N::f32, P::time}}), 24, PointOrigin::middle,
              kSecondTicks, true};
    case LidarForm::fomo:
      return {with_xyzi({{"ring", 16, N::u16, P::line}, {"time", 18, N::u64, P::time}}), 26, PointOrigin::absolute,
              kMicrosecondTicks, true};
    default:
      return {with_xyzi({{"ring", 16, N::u16, P::line}, {"time", 18, N::f32, P::time}}), 22, PointOrigin::start,
              kSecondTicks, false};
  }
}

template <class T>
void store(double value, std::uint8_t* to) {
  const T number = static_cast<T>(value);
  std::memcpy(to, &number, sizeof(number));
}

void store(NumberType type, double value, std::uint8_t* to) {
  switch (type) {
    case N::u8:
      return store<std::uint8_t>(value, to);
    case N::u16:
      return store<std::uint16_t>(value, to);
    case N::i32:
      return store<std::int32_t>(value, to);
    case N::u32:
      return store<std::uint32_t>(value, to);
    case N::f32:
      return store<float>(value, to);
    case N::f64:
      return store<double>(value, to);
    case N::u64:
      return store<std::uint64_t>(value, to);
  }
}

/// Largest value of a field without sign; 0: it has one.
double largest(NumberType type) {
  if (type == N::u32) return std::numeric_limits<std::uint32_t>::max();
  return type == N::u64 ? 9e18 : 0;
}

}  // namespace

const CloudForm& cloud_form(LidarForm form) {
  constexpr std::size_t kForms = static_cast<std::size_t>(LidarForm::fomo) + 1;
  static const auto kAll = [] {
    std::array<CloudForm, kForms> all;
    for (std::size_t i = 0; i < kForms; ++i) all[i] = make_form(static_cast<LidarForm>(i));
    return all;
  }();
  return kAll[static_cast<std::size_t>(form)];
}

bool is_livox_form(LidarForm form) { return form == LidarForm::livox || form == LidarForm::livox2; }
bool is_cloud_form(LidarForm form) { return !is_livox_form(form) && form != LidarForm::velodyne_packets; }

TimeNs moment_of(SweepMoment moment, TimeNs start, double period) {
  const double share = moment == SweepMoment::start ? 0 : moment == SweepMoment::middle ? 0.5 : 1;
  return start + to_ns(share * period);
}

CloudEncoder::CloudEncoder(const LidarLayout& layout, const SweepGrid& grid)
    : layout_(layout),
      grid_(grid),
      form_(cloud_form(layout.form)),
      origin_(layout.point_time == PointOrigin::form ? form_.origin : layout.point_time) {}

const std::vector<std::uint8_t>& CloudEncoder::encode(const LidarPacket& sweep) {
  layout_.organised ? place_in_grid(sweep) : order(sweep);
  TimeNs origin = 0;
  if (origin_ != PointOrigin::absolute) {
    const SweepMoment moment = origin_ == PointOrigin::end      ? SweepMoment::end
                               : origin_ == PointOrigin::middle ? SweepMoment::middle
                                                                : SweepMoment::start;
    origin = moment_of(moment, sweep.stamp, grid_.period);
  }
  data_.assign(std::size_t{form_.point_step} * points_.size(), 0);
  for (std::size_t i = 0; i < points_.size(); ++i) put(points_[i], origin, data_.data() + i * form_.point_step);
  return data_;
}

void CloudEncoder::order(const LidarPacket& sweep) {
  points_ = sweep.points;
  if (layout_.order == PointOrder::column) return;
  std::stable_sort(points_.begin(), points_.end(),
                   [](const TimedPoint& a, const TimedPoint& b) { return a.line < b.line; });
}

void CloudEncoder::place_in_grid(const LidarPacket& sweep) {
  const auto lines = static_cast<std::size_t>(grid_.lines), columns = static_cast<std::size_t>(grid_.columns);
  const double step = 1e9 * grid_.period / static_cast<double>(columns);
  const bool by_row = layout_.order == PointOrder::row;
  const float none = form_.zero_invalid ? 0.0F : std::numeric_limits<float>::quiet_NaN();
  points_.assign(lines * columns, {});
  for (std::size_t line = 0; line < lines; ++line) {
    for (std::size_t column = 0; column < columns; ++column) {
      TimedPoint& point = points_[by_row ? line * columns + column : column * lines + line];
      point.x = point.y = point.z = none;
      point.line = static_cast<std::uint8_t>(line);
      point.t = sweep.stamp + std::llround(step * static_cast<double>(column));
    }
  }
  for (const TimedPoint& point : sweep.points) {
    const auto column = std::llround(static_cast<double>(point.t - sweep.stamp) / step);
    if (point.line >= lines || column < 0 || column >= static_cast<long long>(columns)) {
      throw DataError(
          fmt::format("a point of line {} at {} ns of its sweep lies outside {} lines of {} columns; write "
                      "it without `organised`",
                      point.line, point.t - sweep.stamp, lines, columns));
    }
    const auto at = static_cast<std::size_t>(column);
    points_[by_row ? point.line * columns + at : at * lines + point.line] = point;
  }
}

double CloudEncoder::number(const FormField& field, const TimedPoint& point, TimeNs origin) const {
  switch (field.part) {
    case P::x:
      return point.x;
    case P::y:
      return point.y;
    case P::z:
      return point.z;
    case P::intensity:
      return point.intensity;
    case P::line:
      return point.line;
    case P::time:
      return static_cast<double>(point.t - origin) / form_.tick;
    case P::reflectivity:
      return std::clamp(std::round(point.intensity), 0.0F, 65535.0F);
    case P::tag:
      return point.tag;
    case P::range_mm: {
      const double range = std::hypot(double{point.x}, double{point.y}, double{point.z});
      return std::isfinite(range) ? std::round(1000 * range) : 0;
    }
    case P::nothing:
      return 0;
  }
  return 0;
}

void CloudEncoder::put(const TimedPoint& point, TimeNs origin, std::uint8_t* to) const {
  for (const FormField& field : form_.fields) {
    double value = number(field, point, origin);
    if (field.part == P::time && largest(field.type) > 0) {
      value = std::round(value);
      if (!(value >= 0 && value <= largest(field.type))) refuse_time(point, value);
    }
    store(field.type, value, to + field.offset);
  }
}

void CloudEncoder::refuse_time(const TimedPoint& point, double value) const {
  throw DataError(
      fmt::format("a point of {} ns has the time {} for a field without sign; let `point_time` count from the "
                  "start of the sweep, or take another form",
                  point.t, value));
}

rosbag::CloudLayout CloudEncoder::layout() const {
  rosbag::CloudLayout layout;
  for (const FormField& field : form_.fields) {
    layout.fields.push_back({field.name, field.offset, static_cast<std::uint8_t>(field.type), 1});
  }
  layout.point_step = form_.point_step;
  const bool by_row = layout_.order == PointOrder::row;
  if (layout_.organised) {
    layout.height = static_cast<std::uint32_t>(by_row ? grid_.lines : grid_.columns);
    layout.width = static_cast<std::uint32_t>(by_row ? grid_.columns : grid_.lines);
    layout.is_dense = form_.zero_invalid;
  } else {
    layout.width = static_cast<std::uint32_t>(points_.size());
  }
  layout.row_step = layout.point_step * layout.width;
  return layout;
}

}  // namespace aslio::io
