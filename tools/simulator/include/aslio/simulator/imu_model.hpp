#pragma once

#include <cstdint>
#include <vector>

#include "aslio/core/sensor.hpp"
#include "aslio/core/types.hpp"
#include "aslio/simulator/motion.hpp"
#include "aslio/simulator/random.hpp"
#include "aslio/simulator/realism.hpp"

namespace aslio::simulator {

/// A BMI088 as built into the Avia: white noise and bias walk by continuous densities, per-sample standard deviation =
/// density * sqrt(rate); the rest is drawn once for a sensor, uniformly up to the given bounds; clipped last.
struct ImuModel {
  double rate = 200;                                     ///< [Hz]
  double gyro_noise = SensorModel{}.gyro_noise;          ///< [rad/s/sqrt(Hz)]
  double acc_noise = SensorModel{}.acc_noise;            ///< [m/s^2/sqrt(Hz)]
  double gyro_bias_walk = SensorModel{}.gyro_bias_walk;  ///< [rad/s^2/sqrt(Hz)]
  double acc_bias_walk = SensorModel{}.acc_bias_walk;    ///< [m/s^3/sqrt(Hz)]
  double initial_gyro_bias = 8.727e-3;                   ///< up to this, per axis [rad/s] (0.5 deg/s)
  double initial_acc_bias = 0.196133;                    ///< up to this, per axis [m/s^2] (20 mg)
  double gyro_range = 34.9;                              ///< [rad/s]
  double acc_range = 3 * kStandardGravity;               ///< [m/s^2]
  double scale_error = 0;    ///< up to this, scale factor of each axis of both sensors: sensitivity is 1 + error
  double cross_axis = 0;     ///< up to this, each off-diagonal term of both sensitivity matrices
  double g_sensitivity = 0;  ///< up to this, each term of the gyro's response to force [rad/s per m/s^2]
  double delay = 0;          ///< a sample shows the motion this much earlier (low-pass filter) [s]
  double filter = 0;         ///< a sample is the mean over this time, about the time less `delay` [s]
  double warming = 0;        ///< from switching on, time constant 300 s [K]; the biases drift with it
  double vibration = 0;      ///< amplitude on each axis of the accelerometer, of the LiDAR's motor [m/s^2]
  double motor = 0;          ///< frequency of that motor [Hz]
};

/// The model with what realism adds. A filter shows nothing of the future: `delay` becomes half of it at least. `motor`
/// is the frequency of the LiDAR's motor [Hz], 0 where it is not known: then nothing vibrates.
ImuModel with_realism(ImuModel model, const ImuRealism& realism, double motor);

/// What is constant for one sensor: it measures gyro_sensitivity w + g_sensitivity f and acc_sensitivity f of the
/// angular rate w and the specific force f.
struct ImuCalibration {
  Mat3 gyro_sensitivity = Mat3::Identity();
  Mat3 acc_sensitivity = Mat3::Identity();
  Mat3 g_sensitivity = Mat3::Zero();  ///< [rad/s per m/s^2]
};

/// One sample after the other, in bounded memory. Each random effect has a stream of its own or a fixed place in one,
/// so that switching one off leaves the others as they are. The motion must outlive it.
class ImuSimulator {
 public:
  /// The first sample is of time `begin` (motion time 0).
  ImuSimulator(const Motion& motion, TimeNs begin, const ImuModel& model, std::uint64_t seed);

  struct Output {
    ImuSample sample;
    Vec3 gyro_bias = Vec3::Zero();  ///< true, at the sample [rad/s]
    Vec3 acc_bias = Vec3::Zero();   ///< [m/s^2]
  };
  Output next();

  const ImuCalibration& calibration() const { return calibration_; }

 private:
  struct Seen {
    Vec3 rate = Vec3::Zero(), force = Vec3::Zero();  ///< [rad/s], [m/s^2]
  };
  /// What acts on the sensor at a time of the motion.
  Seen acting(double t) const;
  /// The mean of it over the filter.
  Seen filtered(double t) const;

  const Motion& motion_;
  TimeNs begin_;
  ImuModel model_;
  ImuCalibration calibration_;
  RandomStream walk_, gyro_noise_, acc_noise_;
  Vec3 gyro_bias_ = Vec3::Zero(), acc_bias_ = Vec3::Zero();
  Vec3 gyro_per_kelvin_ = Vec3::Zero(), acc_per_kelvin_ = Vec3::Zero();  ///< [rad/s/K], [m/s^2/K]
  Vec3 vibration_phase_ = Vec3::Zero();                                  ///< [rad]
  std::int64_t count_ = 0;
};

/// Samples and the true biases at their times.
struct ImuRecord {
  std::vector<ImuSample> samples;
  std::vector<Vec3> gyro_bias, acc_bias;
};

/// Samples from `begin` (motion time 0) over `duration` seconds, both ends included.
ImuRecord simulate_imu(const Motion& motion, TimeNs begin, double duration, const ImuModel& model, std::uint64_t seed);
/// With the noise densities of `sensor`. Without noise: no bias either.
ImuRecord simulate_imu(const Motion& motion, TimeNs begin, double duration, const ImuModel& model,
                       const SensorModel& sensor, bool noise, std::uint64_t seed);

}  // namespace aslio::simulator
