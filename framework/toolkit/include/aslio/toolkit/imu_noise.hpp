#pragma once

#include <array>

#include "aslio/core/sensor.hpp"
#include "aslio/stages/motion.hpp"
#include "aslio/stages/window.hpp"

namespace aslio {

/// What somebody who walks and turns does while nobody reads the IMU, as squared densities of its noise. eq. MOT-9.
struct UnreadMotion {
  /// `gap`: Window::imu_gap [ns].
  explicit UnreadMotion(TimeNs gap);

  double gyro;  ///< [(rad/s)^2 / Hz]
  double acc;   ///< [(m/s^2)^2 / Hz]
};

/// What a body may do where a sample is marked (imu_fault), as squared densities of the noise of each axis of I.
/// eq. MOT-12.
struct DoubtedMotion {
  DoubtedMotion(const ImuSample& from, const ImuSample& to);

  bool any = false;
  Vec3 gyro = Vec3::Zero();  ///< [(rad/s)^2 / Hz]
  Vec3 acc = Vec3::Zero();   ///< [(m/s^2)^2 / Hz]
};

/// What an IMU that is too slow for the motion does not read, as squared densities of its noise, by how far its samples
/// lie off the line between their neighbours; eq. MOT-14. Only neighbours at even distances of 20 ms and more count: it
/// is zero for a faster IMU, also where that has lost samples.
class UnresolvedMotion {
 public:
  struct Density {
    double gyro = 0;  ///< [(rad/s)^2 / Hz]
    double acc = 0;   ///< [(m/s^2)^2 / Hz]
  };
  /// Takes the readings of the next window.
  void observe(const Window& window);
  const Density& density() const { return density_; }

 private:
  void read(const ImuSample& reading);

  std::array<ImuSample, 2> last_{};  ///< readings, the newest second
  std::size_t readings_ = 0;         ///< of last_, without a fault among or between them
  TimeNs newest_ = kTimeMin;
  Density density_;
};

/// What the prediction of a filter is held to be worth.
struct ImuNoisePreset {
  enum class Kind : std::uint8_t {
    fastlio,     ///< FAST-LIO2's inflated per-sample variances
    physical,    ///< the densities of the sensor (docs/equations.md MOT-3)
    rate_scaled  ///< those plus terms for scale factor and delay that grow with the turn rate (MOT-5)
  };
  Kind kind = Kind::fastlio;
  /// After an update that left a direction open: least density of the accelerometer [m/s^2/sqrt(Hz)] (MOT-7).
  double degenerate_acc_noise = 0;

  /// What an interval is predicted from.
  struct Circumstances {
    bool degenerate = false;  ///< the last update left a direction open
    TimeNs imu_gap = 0;       ///< of the window: Window::imu_gap [ns]
    UnresolvedMotion::Density unresolved;
  };

  /// Variances per sample over the interval from `from` to `to`; `b_w` is the gyro's bias [rad/s].
  ImuNoise over(const ImuSample& from, const ImuSample& to, const SensorModel& sensor, const Vec3& b_w,
                const Circumstances& how) const;

 private:
  ImuNoise of_readings(const ImuSample& from, const ImuSample& to, const SensorModel& sensor, const Vec3& b_w,
                       bool degenerate) const;
};

}  // namespace aslio
