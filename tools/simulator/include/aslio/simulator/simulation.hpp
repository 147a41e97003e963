#pragma once
/// A scene brought to life: everything that happens is known at any time.

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "aslio/core/measurement.hpp"
#include "aslio/core/sensor.hpp"
#include "aslio/core/trajectory.hpp"
#include "aslio/simulator/cars.hpp"
#include "aslio/simulator/caster.hpp"
#include "aslio/simulator/scene.hpp"

namespace aslio::simulator {

inline constexpr double kMinScale = 0.1, kMaxScale = 3;

struct SimulationOptions {
  std::uint64_t seed = 1;  ///< noise, biases, people, turn times and gait; the world has its own
  std::optional<SensorKind> sensor = std::nullopt;  ///< instead of the scene's
  double scale = 1;                                 ///< positions of route and world; in [kMinScale, kMaxScale]
  TimeNs begin = 1'700'000'000 * kSecond;           ///< data time of the first measurement
  std::optional<double> duration = std::nullopt;    ///< the motion ends there, if not before [s]
  std::optional<Pose> T_imu_lidar = std::nullopt;   ///< true extrinsic, instead of the sensor's
};

/// Rays of 10 ms and the cells (keys as in cell_key()) that those on the static world hit, where they really went:
/// with the angular noise of the beam, before range noise and losses. In the order of the beams.
struct CellBlock {
  TimeNs begin = 0;
  std::vector<std::uint64_t> cells;
  std::size_t people_rays = 0;  ///< rays that met a person or a moving car, in no cell
};

/// What one packet period holds.
struct SimulatedPacket {
  LidarPacket packet;  ///< points in time order
  std::vector<CellBlock> blocks;
  std::size_t rays = 0;
  std::vector<Eigen::Vector3f> view;  ///< exact hits on the static world [m], in W, of one firing in eight
};

/// Edge of the cells of true overlap [m].
inline constexpr double kOverlapCell = 0.2;
/// Cell of a point, 21 bits per axis. The faces of the cells lie off round numbers: floors and walls that lay in a face
/// would be cut in two by the last bit of a coordinate, and be unknown twice.
std::uint64_t cell_key(const Vec3& p_W);

class Roughness;

/// Thread-safe: const after construction.
class Simulation {
 public:
  static constexpr TimeNs kPacketPeriod = kSecond / 10;

  /// Builds world, motion, people and the IMU record. Throws ConfigError or DataError that names the file and the key.
  Simulation(const SceneFile& scene, const SimulationOptions& options);
  ~Simulation();

  const SimulationOptions& options() const { return options_; }
  const Scene& scene() const { return scene_; }
  SensorKind sensor_kind() const { return kind_; }
  /// True extrinsic and ranges; what the recording claims (stress) is claimed_sensor().
  const SensorModel& sensor() const { return sensor_; }
  const SensorModel& claimed_sensor() const { return claimed_sensor_; }
  const Motion& motion() const { return *motion_; }
  const Caster& caster() const { return *caster_; }
  const Ground& ground() const { return ground_; }
  const People& people() const { return people_; }
  const Cars& cars() const { return cars_; }
  /// Largest distance between the motion and a pose it follows [m]; 0 for routes.
  double follow_error() const { return follow_error_; }
  /// Only for scenes with a route that is walked.
  const Route* route() const { return route_.get(); }
  /// Only for drives.
  const RoadLine* road() const { return road_.get(); }
  const ScanPattern& pattern() const { return *pattern_; }
  const Realism& realism() const { return realism_; }
  const Roughness& roughness() const { return *roughness_; }
  double duration() const { return duration_; }  ///< [s]
  TimeNs begin_time() const { return options_.begin; }
  TimeNs end_time() const;

  /// The IMU samples as recorded (true times; stress on stamps and losses is applied by the recorder) and true biases.
  const ImuRecord& imu() const { return imu_; }
  /// True poses T_W_I at 200 Hz, both ends included.
  Trajectory truth() const;

  /// Packets [0, packet_count()) of kPacketPeriod each, the last may be shorter.
  std::size_t packet_count() const;
  /// Casts every ray at the true pose at its own time. Any packet, in any order, from any thread.
  SimulatedPacket packet(std::size_t index) const;

 private:
  void build(const SceneFile& file);
  void build_drive(const SceneFile& file);
  void build_walk(const SceneFile& file);

  Scene scene_;
  Realism realism_;
  SimulationOptions options_;
  SensorKind kind_;
  SensorModel sensor_, claimed_sensor_;
  std::unique_ptr<Route> route_;
  std::unique_ptr<RoadLine> road_;
  std::unique_ptr<Motion> motion_;
  double follow_error_ = 0, duration_ = 0;
  std::unique_ptr<Caster> caster_;
  std::unique_ptr<Roughness> roughness_;
  Ground ground_;
  People people_;
  Cars cars_;
  std::unique_ptr<ScanPattern> pattern_;
  ImuRecord imu_;
};

}  // namespace aslio::simulator
