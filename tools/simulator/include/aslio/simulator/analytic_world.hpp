#pragma once
/// A small world in which everything is known in closed form: rooms and a corridor built of boxes, a walk with sharp
/// turns that ends where it began, a Livox Avia and its IMU. Data for tests and first experiments.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>

#include "aslio/core/sensor.hpp"
#include "aslio/core/trajectory.hpp"
#include "aslio/io/source.hpp"
#include "aslio/simulator/boxes.hpp"
#include "aslio/simulator/imu_model.hpp"
#include "aslio/simulator/walk.hpp"

namespace aslio::simulator {

struct Options {
  std::uint64_t seed = 1;
  double duration_scale = 1;  ///< stretches the 20 s walk; speeds and turn rates are divided by it. In [0.5, 100]
  bool lidar_noise = true;    ///< range and angle noise, random dropout
  bool imu_noise = true;      ///< white noise, biases and their walk
  double imu_rate = 200;      ///< [Hz], in [20, 10000]
  bool people = false;        ///< two people walk about
  TimeNs begin = 1'700'000'000 * kSecond;  ///< data time of the first measurement
};

/// Errors of the simulated LiDAR.
struct LidarNoise {
  double range = 0.02;                  ///< standard deviation [m]
  double angle = 4.363e-4;              ///< standard deviation of azimuth and elevation [rad] (0.025 deg)
  double dropout = 0.02;                ///< share of rays without a return
  double max_incidence_cos = 0.173648;  ///< flatter than 80 deg: no return (also without noise)
};

/// The world W is gravity-aligned with its origin at the IMU's pose at the start (and at the end).
/// Thread-compatible: const after construction.
class AnalyticWorld {
 public:
  /// Throws ConfigError when an option is out of range.
  explicit AnalyticWorld(const Options& options = {});

  /// The measurements from the start, in recording order: IMU samples in SI units, a packet each 0.1 s once it is
  /// complete. Every ray is cast at the true pose at its own time. Equal options give equal bits. The world must
  /// outlive its sources.
  std::unique_ptr<io::MeasurementSource> source() const;

  const Options& options() const { return options_; }
  const SensorModel& sensor() const { return sensor_; }
  const LidarNoise& lidar_noise() const { return lidar_noise_; }
  const BoxScene& scene() const { return scene_; }
  TimeNs begin_time() const { return options_.begin; }
  TimeNs end_time() const;

  /// True motion of the IMU at any time.
  MotionState motion(TimeNs t) const;
  Pose pose(TimeNs t) const;
  /// True state with the biases at the IMU sample at or before `t` (clamped to the recording).
  NavState state(TimeNs t) const;
  /// True poses T_W_I at 200 Hz, both ends included.
  Trajectory truth() const;
  /// The IMU samples and biases.
  const ImuRecord& imu() const { return imu_; }
  /// The people at time `t` (empty without).
  std::vector<Box> people(TimeNs t) const;

 private:
  Options options_;
  SensorModel sensor_;
  LidarNoise lidar_noise_;
  BoxScene scene_;
  Walk motion_;
  ImuRecord imu_;
};

/// Writes `world.bag` (Livox CustomMsg on /livox/lidar, sensor_msgs/Imu in g on /livox/imu) and `truth.tum` into
/// `folder`, which is created. Each file appears when it is complete. `progress` hears shares in [0, 1].
/// Throws DataError that names the path when it cannot be written.
void write_recording(const AnalyticWorld& world, const std::filesystem::path& folder,
                     const std::function<void(double)>& progress = {});

}  // namespace aslio::simulator
