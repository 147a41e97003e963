#include "ouster.hpp"

#include <fmt/format.h>

#include <bit>
#include <cmath>
#include <numbers>
#include <utility>

namespace aslio::io::packets {
namespace {

class OusterFormat final : public PacketFormat {
 public:
  explicit OusterFormat(OusterMetadata metadata) : metadata_(std::move(metadata)) {
    const OusterMetadata& m = metadata_;
    beam_radius_ = std::hypot(m.beam_x, m.beam_z);
    for (std::size_t row = 0; row < m.rows; ++row) {
      const double level = std::cos(m.altitudes[row]);
      directions_.emplace_back(level * std::cos(m.azimuths[row]), -level * std::sin(m.azimuths[row]),
                               std::sin(m.altitudes[row]));
    }
    for (std::size_t column = 0; column < m.columns_per_frame; ++column) {
      const double angle =
          2 * std::numbers::pi * (1 - static_cast<double>(column) / static_cast<double>(m.columns_per_frame));
      Mat3 R = Mat3::Identity();
      R(0, 0) = R(1, 1) = std::cos(angle);
      R(1, 0) = std::sin(angle);
      R(0, 1) = -R(1, 0);
      turned_.push_back(m.T_sensor_lidar.R * R);
    }
  }

  std::string verdict() const override {
    const Vec3 p = -(metadata_.T_sensor_imu.R.transpose() * metadata_.T_sensor_imu.p);
    return fmt::format(
        "Ouster {}, {}x{}, profile {}{}, in the sensor frame, of which the IMU of the sensor tells T_imu_lidar: "
        "translation [{:.6f}, {:.6f}, {:.6f}]",
        metadata_.product, metadata_.columns_per_frame, metadata_.rows, metadata_.profile->name,
        metadata_.profile->dual ? ", dual return: the strongest one is kept" : "", p.x(), p.y(), p.z());
  }

  std::string head(Bytes packet, PacketHead& head) const override {
    if (std::string why = problem_of(packet); !why.empty()) return why;
    const OusterColumn first = ouster_column(metadata_, packet, 0);
    if (first.measurement >= metadata_.columns_per_frame) {
      return fmt::format("its column {} is beyond the {} of a frame", first.measurement, metadata_.columns_per_frame);
    }
    head.time = first.time;
    head.turn = static_cast<double>(first.measurement) / static_cast<double>(metadata_.columns_per_frame);
    head.sequence = static_cast<std::uint32_t>(first.measurement / metadata_.columns_per_packet);
    head.frame = number<std::uint16_t>(packet, metadata_.profile->legacy ? 10 : 2);
    return {};
  }

  std::string decode(Bytes packet, TimeNs begin, int scan_lines, LidarPacket& out) const override {
    if (std::string why = problem_of(packet); !why.empty()) return why;
    const TimeNs first = ouster_column(metadata_, packet, 0).time;
    for (std::size_t i = 0; i < metadata_.columns_per_packet; ++i) {
      const OusterColumn column = ouster_column(metadata_, packet, i);
      const TimeNs since = column.time - first;
      const bool timely = since >= 0 && since < kSecond;  // columns of one packet lie milliseconds apart
      if (column.valid && timely && column.measurement < metadata_.columns_per_frame) {
        add_column(column, begin + since, scan_lines, out);
      } else {
        out.dropped_invalid += metadata_.rows;
      }
    }
    return {};
  }

  bool begins_sweep(const PacketHead& last, const PacketHead& next) const override { return next.frame != last.frame; }

  /// Within one frame: what is left out at its ends may be outside of the azimuth window.
  std::uint32_t missing_between(const PacketHead& last, const PacketHead& next) const override {
    return next.frame == last.frame && next.sequence > last.sequence + 1 ? next.sequence - last.sequence - 1 : 0;
  }

 private:
  std::string problem_of(Bytes packet) const {
    if (packet.size() != metadata_.packet_bytes()) {
      return fmt::format("a packet of {} bytes where the metadata says {}", packet.size(), metadata_.packet_bytes());
    }
    constexpr std::size_t kSerialAt = 7;
    constexpr std::uint64_t kSerialMask = 0xFFFFFFFFFF;
    const std::uint64_t serial = metadata_.profile->legacy ? 0 : number<std::uint64_t>(packet, kSerialAt) & kSerialMask;
    if (serial == 0 || metadata_.serial == 0 || serial == metadata_.serial) return {};
    return fmt::format("a packet of sensor {} where the metadata is of sensor {}", serial, metadata_.serial);
  }

  void add_column(const OusterColumn& column, TimeNs time, int scan_lines, LidarPacket& out) const {
    const Mat3& R = turned_[column.measurement];
    const Vec3 beam(metadata_.beam_x, 0, metadata_.beam_z);
    for (std::size_t row = 0; row < metadata_.rows; ++row) {
      const double range = 1e-3 * ouster_range(metadata_, column, row);
      const std::size_t at = row * metadata_.profile->pixel + metadata_.profile->reflectivity_at;
      const unsigned reflectivity =
          metadata_.profile->legacy ? number<std::uint16_t>(column.pixels, at) : column.pixels[at];
      if (range <= beam_radius_) {  // no return, or one from within the sensor
        ++out.dropped_invalid;
        continue;
      }
      const Vec3 p = R * ((range - beam_radius_) * directions_[row] + beam) + metadata_.T_sensor_lidar.p;
      add_point(p, time, reflectivity, static_cast<int>(row), scan_lines, out);
    }
  }

  OusterMetadata metadata_;
  double beam_radius_ = 0;
  std::vector<Vec3> directions_;  ///< of each row, in the turning frame
  std::vector<Mat3> turned_;      ///< from the turning frame of each column to the sensor's
};

}  // namespace

OusterColumn ouster_column(const OusterMetadata& metadata, Bytes packet, std::size_t column) {
  const OusterProfile& profile = *metadata.profile;
  const std::size_t at = profile.packet_head + column * metadata.column_bytes();
  const std::uint64_t time = number<std::uint64_t>(packet, at);
  OusterColumn out;
  constexpr std::uint64_t kLatest = std::uint64_t{1} << 62U;  // damage; sums with it must not overflow
  out.time = static_cast<TimeNs>(std::min(time, kLatest));
  out.measurement = number<std::uint16_t>(packet, at + 8);
  out.pixels = packet.subspan(at + profile.column_head, metadata.rows * profile.pixel);
  out.valid = profile.legacy
                  ? number<std::uint32_t>(packet, at + metadata.column_bytes() - profile.column_tail) == 0xFFFFFFFF
                  : (number<std::uint16_t>(packet, at + 10) & 1U) != 0;
  return out;
}

std::uint32_t ouster_range(const OusterMetadata& metadata, const OusterColumn& column, std::size_t row) {
  const OusterProfile& profile = *metadata.profile;
  const std::size_t at = row * profile.pixel;
  const std::uint32_t raw =
      profile.range_shift == 0 ? number<std::uint32_t>(column.pixels, at) : number<std::uint16_t>(column.pixels, at);
  return (raw & profile.range_mask) << profile.range_shift;
}

std::unique_ptr<PacketFormat> make_ouster(OusterMetadata metadata) {
  return std::make_unique<OusterFormat>(std::move(metadata));
}

std::string decode_ouster_imu(Bytes packet, OusterImu& imu) {
  if (packet.size() != kOusterImuBytes) {
    return fmt::format("an IMU packet of {} bytes where Ouster's have {}", packet.size(), kOusterImuBytes);
  }
  constexpr std::size_t kGyroTimeAt = 16, kAccAt = 24, kGyroAt = 36;
  constexpr double kRadians = std::numbers::pi / 180;
  constexpr std::uint64_t kLatest = std::uint64_t{1} << 62U;
  imu.time = static_cast<TimeNs>(std::min(number<std::uint64_t>(packet, kGyroTimeAt), kLatest));
  for (int axis = 0; axis < 3; ++axis) {
    const std::size_t step = 4 * static_cast<std::size_t>(axis);
    imu.acc[axis] = kStandardGravity * double{std::bit_cast<float>(number<std::uint32_t>(packet, kAccAt + step))};
    imu.gyro[axis] = kRadians * double{std::bit_cast<float>(number<std::uint32_t>(packet, kGyroAt + step))};
  }
  return {};
}

}  // namespace aslio::io::packets
