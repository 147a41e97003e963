#pragma once
/// Velodyne's data packets of 1206 bytes (VLP-16, Puck Hi-Res, HDL-32E, VLP-32C, VLS-128) and position packets of 512.
/// Facts: user manuals 63-9243 (VLP-16), 63-9113 (HDL-32E), 63-9325 (VLP-32C), 63-9483 (VLS-128).
/// Frame, as of the driver for ROS: x where the azimuth is 0, y to the left, z up.

#include <array>
#include <optional>
#include <span>

#include "format.hpp"

namespace aslio::io::packets {

enum class VelodyneModel : std::uint8_t { vlp16, vlp16_hires, hdl32e, vlp32c, vls128 };

struct VelodyneLaser {
  double elevation = 0;  ///< [deg]
  double azimuth = 0;    ///< what is added to the block's [deg]
  double height = 0;     ///< of its origin above the sensor's [m]
  int line = 0;          ///< rank by elevation, 0 is the lowest
};

/// The lasers of a model by their number.
std::span<const VelodyneLaser> velodyne_lasers(VelodyneModel model);

/// The model by the first packets of a recording: old firmware of a VLP-16 calls itself HDL-32E, only its rate tells.
/// Nothing without a data packet of a known model; `why` then says what there was.
std::unique_ptr<PacketFormat> make_velodyne(std::span<const Packet> first, std::string& why);
std::unique_ptr<PacketFormat> make_velodyne(VelodyneModel model, bool dual);

inline constexpr std::size_t kVelodyneDataBytes = 1206, kVelodynePositionBytes = 512;
inline constexpr TimeNs kVelodyneClock = 3600 * kSecond;  ///< time counts from the full hour

/// The inertial sensors of an HDL-32E, in the frame of its points.
struct VelodynePosition {
  TimeNs time = 0;           ///< by the sensor's clock, since the full hour [ns]
  Vec3 gyro = Vec3::Zero();  ///< [rad/s]
  Vec3 acc = Vec3::Zero();   ///< specific force [m/s^2]
  double temperature = 0;    ///< mean of the three sensors [deg C]
  bool has_imu = false;      ///< other models leave these fields 0
  std::string nmea;          ///< $GPRMC sentence of a GPS receiver; empty: none
};

/// Empty, or what is wrong with the packet.
std::string decode_velodyne_position(Bytes packet, VelodynePosition& position);

}  // namespace aslio::io::packets
