#include "rows.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <iterator>
#include <numbers>
#include <system_error>

#include "aslio/core/errors.hpp"

namespace aslio::io {

std::string filled_in(std::string name, std::string_view key, std::string_view value) {
  const std::string mark = fmt::format("{{{}}}", key);
  for (std::size_t at = name.find(mark); at != std::string::npos; at = name.find(mark, at + value.size())) {
    name.replace(at, mark.size(), value);
  }
  return name;
}

std::filesystem::path place_of(const LayoutPlace& place, const std::string& name) {
  const std::filesystem::path path = place.folder / filled_in(name, "sequence", place.sequence);
  std::error_code error;
  std::filesystem::create_directories(path.parent_path(), error);
  if (error) {
    throw DataError(fmt::format("{}: cannot create the folder: {}; name one that can be written",
                                path.parent_path().string(), error.message()));
  }
  return path;
}

ImuSample as_told(const ImuLayout& layout, ImuSample sample) {
  const double acc_unit = layout.acc_unit == AccUnit::g ? kStandardGravity : 1;
  const double gyro_unit = layout.gyro_unit == GyroUnit::deg_s ? std::numbers::pi / 180 : 1;
  sample.t += to_ns(layout.time_offset);
  for (int axis = 0; axis < 3; ++axis) {
    const auto at = static_cast<std::size_t>(axis);
    sample.gyro[axis] = layout.gyro_signs.at(at) * (sample.gyro[axis] / gyro_unit);
    sample.acc[axis] = layout.acc_signs.at(at) * (sample.acc[axis] / acc_unit);
  }
  return sample;
}

const LidarPacket& as_told(const LidarLayout& layout, const LidarPacket& sweep, LidarPacket& scratch) {
  const TimeNs offset = to_ns(layout.time_offset);
  if (offset == 0) return sweep;
  scratch = sweep;
  scratch.stamp += offset;
  for (TimedPoint& point : scratch.points) point.t += offset;
  return scratch;
}

std::string time_text(TimeNs t, TimeUnit unit) {
  constexpr TimeNs kMicrosecond = 1000, kMillisecond = 1'000'000;
  switch (unit) {
    case TimeUnit::ns:
      return fmt::format("{}", t);
    case TimeUnit::us:
      return fmt::format("{}", (t + kMicrosecond / 2) / kMicrosecond);
    case TimeUnit::ms:
      return fmt::format("{}", (t + kMillisecond / 2) / kMillisecond);
    default:
      return fmt::format("{}.{:09}", t / kSecond, t % kSecond);
  }
}

RowFile::RowFile(const std::filesystem::path& path, std::vector<std::string> columns, std::string separator,
                 bool header, TimeUnit unit)
    : file_(path), roles_(std::move(columns)), separator_(std::move(separator)), unit_(unit) {
  std::vector<std::string> names;
  for (std::string& role : roles_) {
    const std::size_t equal = role.find('=');
    names.push_back(equal == std::string::npos ? role : role.substr(equal + 1));
    role = role.substr(0, equal);
  }
  if (header) file_.write(fmt::format("{}\n", fmt::join(names, separator_)));
}

void RowFile::add(TimeNs t, const std::function<double(std::string_view)>& number) {
  line_.clear();
  for (const std::string& role : roles_) {
    if (!line_.empty()) line_ += separator_;
    if (role == "t") {
      line_ += time_text(t, unit_);
    } else if (role == "sec" || role == "nsec") {
      fmt::format_to(std::back_inserter(line_), "{}", role == "sec" ? t / kSecond : t % kSecond);
    } else if (role == "count") {
      fmt::format_to(std::back_inserter(line_), "{}", count_);
    } else if (role == "-") {
      line_ += '0';
    } else {
      fmt::format_to(std::back_inserter(line_), "{}", number(role) + 0.0);  // + 0.0: no "-0"
    }
  }
  line_ += '\n';
  file_.write(line_);
  ++count_;
}

ReferenceSampler::ReferenceSampler(const ReferenceLayout& layout)
    : period_(to_ns(1 / layout.rate)),
      offset_(to_ns(layout.time_offset)),
      positions_only_(layout.positions_only),
      T_imu_reference_(layout.T_imu_reference.pose()),
      origin_(layout.origin.at(0), layout.origin.at(1), layout.origin.at(2)) {}

std::optional<StampedPose> ReferenceSampler::take(const StampedPose& T_W_I) {
  if (!first_) first_ = T_W_I.t;
  if (T_W_I.t < *first_ + taken_ * period_) return std::nullopt;
  while (T_W_I.t >= *first_ + taken_ * period_) ++taken_;
  StampedPose pose{T_W_I.t + offset_, T_W_I.T * T_imu_reference_};
  pose.T.p += origin_;
  if (positions_only_) pose.T.R = Mat3::Identity();
  return pose;
}

ReferenceFileWriter::ReferenceFileWriter(const ReferenceLayout& layout, const std::filesystem::path& path) {
  if (layout.format == ReferenceFile::tum) {
    tum_ = std::make_unique<AtomicFile>(path);
  } else {
    table_ = std::make_unique<RowFile>(path, layout.columns, layout.separator, layout.header, layout.time_unit);
  }
}

void ReferenceFileWriter::add(const StampedPose& pose) {
  if (tum_) return tum_->write(tum_line(pose));
  Eigen::Quaterniond q(pose.T.R);
  if (q.w() < 0) q.coeffs() = -q.coeffs();
  table_->add(pose.t, [&](std::string_view column) {
    const bool turn = column[0] == 'q';
    const char axis = column.back();
    if (turn) return axis == 'x' ? q.x() : axis == 'y' ? q.y() : axis == 'z' ? q.z() : q.w();
    return axis == 'x' ? pose.T.p.x() : axis == 'y' ? pose.T.p.y() : pose.T.p.z();
  });
}

void ReferenceFileWriter::close() { tum_ ? tum_->close() : table_->close(); }

}  // namespace aslio::io
