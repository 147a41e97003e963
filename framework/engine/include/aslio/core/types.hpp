#pragma once
/// Plain measurements and the navigation state. SI units, radians.

#include <array>
#include <cstdint>
#include <vector>

#include "aslio/core/lie.hpp"
#include "aslio/core/time.hpp"

namespace aslio {

/// Standard gravity [m/s^2]; the only value of g in the code.
inline constexpr double kStandardGravity = 9.80665;

/// What is known to be wrong with an IMU sample. Bit i (0 to 2): axis i of the gyro is at the end of its range; bit
/// 3 + i: axis i of the accelerometer is.
namespace imu_fault {
inline constexpr std::uint8_t gyro_clipped = 0x07, acc_clipped = 0x38;
inline constexpr std::uint8_t gyro_dead = 0x40, acc_dead = 0x80;  ///< stuck, or zero: it reads nothing
constexpr std::uint8_t clipped(bool acc, int axis) { return static_cast<std::uint8_t>(1U << ((acc ? 3 : 0) + axis)); }
}  // namespace imu_fault

/// One IMU sample in the IMU frame I: angular rate [rad/s], specific force [m/s^2].
struct ImuSample {
  TimeNs t = 0;
  Vec3 gyro = Vec3::Zero();
  Vec3 acc = Vec3::Zero();
  std::uint8_t faults = 0;  ///< bits of imu_fault; what is interpolated has those of both its neighbours
};

/// One return in the LiDAR frame L at its own time. 40 bytes.
struct TimedPoint {
  float x = 0, y = 0, z = 0;   ///< p_L [m]
  float intensity = 0;         ///< sensor units
  TimeNs t = 0;                ///< time of the firing; points of one firing share it
  std::uint32_t sweep_id = 0;  ///< count of the message (or revolution) it came with
  std::uint32_t index = 0;     ///< count over the stream (mod 2^32), assigned on arrival: what strides count
  std::uint8_t line = 0;       ///< scan line or ring
  std::uint8_t tag = 0;        ///< sensor-specific flags
  std::uint8_t feature = 0;    ///< optional feature class, 0 = none
};

/// State of the IMU frame at `t` in the world W (gravity-aligned, origin at initialisation).
/// Error order (theta, p, v, b_w, b_a, g, s, d), 28 dimensions; s is S_w column by column.
struct NavState {
  TimeNs t = 0;
  Mat3 R = Mat3::Identity();  ///< R_W_I
  Vec3 p = Vec3::Zero();      ///< [m]
  Vec3 v = Vec3::Zero();      ///< [m/s], in W
  Vec3 b_w = Vec3::Zero();    ///< gyro bias [rad/s]
  Vec3 b_a = Vec3::Zero();    ///< accelerometer bias [m/s^2]
  Vec3 g = Vec3(0, 0, -kStandardGravity);
  /// The gyro measures (I + S_w) w + b_w: errors of its scale factors on the diagonal, cross-axis terms beside it.
  Mat3 S_w = Mat3::Zero();
  double imu_delay = 0;  ///< an IMU sample measures the motion this long before its stamp [s]

  Pose pose() const { return {R, p}; }
};

/// A pose with its time; trajectories are sequences of these in strictly increasing time.
struct StampedPose {
  TimeNs t = 0;
  Pose T;
};

}  // namespace aslio
