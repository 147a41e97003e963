#pragma once
/// Ouster's LiDAR packets (profiles LEGACY, RNG15_RFL8_NIR8, RNG19_RFL8_SIG16_NIR16, single and dual) and IMU packets
/// of 48 bytes. Facts: firmware user manual of Ouster, its sections on packets and on coordinate frames.
/// Frame: the Sensor Coordinate Frame of the manual, x away from the connector, z up.

#include <array>
#include <string_view>
#include <vector>

#include "format.hpp"

namespace aslio::io::packets {

/// How the packets of a profile lie in memory [bytes]. A second return, where there is one, is not read.
struct OusterProfile {
  std::string_view name;
  std::size_t packet_head, column_head, pixel, column_tail, packet_tail;
  std::uint32_t range_mask;  ///< of the number at the begin of a pixel: 4 bytes, or 2 where `range_shift` is not 0
  unsigned range_shift;      ///< to mm
  std::size_t reflectivity_at;
  bool dual, legacy;
};

/// The part of a sensor's metadata that decoding needs. Lengths in m, angles in rad.
struct OusterMetadata {
  const OusterProfile* profile = nullptr;
  std::string product;       ///< "OS-1-128"
  std::uint64_t serial = 0;  ///< of the sensor; 0: not known
  std::size_t columns_per_frame = 0, columns_per_packet = 0, rows = 0;
  std::vector<double> altitudes, azimuths;  ///< of each row
  double beam_x = 0, beam_z = 0;            ///< origin of the beams in the turning frame
  Pose T_sensor_lidar, T_sensor_imu;
  bool legacy_imu = true;  ///< IMU packets of 48 bytes

  std::size_t column_bytes() const { return profile->column_head + rows * profile->pixel + profile->column_tail; }
  std::size_t packet_bytes() const {
    return profile->packet_head + columns_per_packet * column_bytes() + profile->packet_tail;
  }
};

/// Of the sensor's JSON, in the flat form of old firmware or the nested one. Throws DataError that begins with `where`.
OusterMetadata parse_ouster_metadata(const std::string& where, std::string_view json);

struct OusterColumn {
  TimeNs time = 0;              ///< by the sensor's clock [ns]
  std::size_t measurement = 0;  ///< which of the frame: 0 to columns_per_frame - 1
  bool valid = false;
  Bytes pixels;
};

/// Pre: the packet has packet_bytes(), `column` is one of them.
OusterColumn ouster_column(const OusterMetadata& metadata, Bytes packet, std::size_t column);
/// Range of the first return of a row [mm]; 0: none.
std::uint32_t ouster_range(const OusterMetadata& metadata, const OusterColumn& column, std::size_t row);

std::unique_ptr<PacketFormat> make_ouster(OusterMetadata metadata);

inline constexpr std::size_t kOusterImuBytes = 48;

struct OusterImu {
  TimeNs time = 0;                               ///< of the gyroscope's sample, by the sensor's clock [ns]
  Vec3 gyro = Vec3::Zero(), acc = Vec3::Zero();  ///< [rad/s], [m/s^2], in the IMU frame of the sensor
};

/// Empty, or what is wrong with the packet.
std::string decode_ouster_imu(Bytes packet, OusterImu& imu);

}  // namespace aslio::io::packets
