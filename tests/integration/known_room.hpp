#pragma once
/// An estimator in a room whose walls it knows exactly: nothing enters the map, so that its errors are those of the
/// filter alone.

#include <Eigen/Geometry>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "aslio/simulator/imu_model.hpp"
#include "aslio/simulator/motion.hpp"
#include "aslio/simulator/random.hpp"
#include "aslio/stages/estimator.hpp"
#include "plugins/build_environment.hpp"

namespace aslio::test {

/// The room of plugins/estimators/room.hpp as a map of surfaces: the nearest wall, unless a second one is within 0.15
/// m.
class TrueWalls final : public Map {
 public:
  MapContent content() const override { return MapContent::surfaces; }
  void correspond(std::span<const Vec3> queries, const MapQuery& query, Neighbours& out) const override;
  void surfaces(std::span<const Vec3> queries, const MapQuery& query, std::span<Surface> out) const override;
  InsertCount insert(std::span<const WorldPoint>, std::uint32_t) override { return {}; }
  void trim(const Vec3&) override {}
  void clear() override {}
  std::size_t size() const override { return 6; }
  std::size_t memory_bytes() const override { return sizeof(*this); }
  double radius() const override { return 1e9; }
  void visit(const std::function<void(const Vec3&)>&) const override {}
};

/// How measured points differ from the walls.
enum class PointNoise : std::uint8_t {
  all_directions,  ///< equally in x, y and z: the residual of a plane has the same sigma at any incidence
  along_the_ray    ///< in range alone: sigma cos(incidence)
};

struct KnownRoomSetting {
  std::vector<std::string> overrides;  ///< of the defaults of `ieskf` with `noise: physical`
  simulator::ImuModel imu;
  double sigma = 0.02;  ///< of the points, and what the filter takes it for [m]
  PointNoise noise = PointNoise::all_directions;
  TimeNs window = kSecond / 10;
  int points = 400;                       ///< per window
  std::string map;                        ///< "{type: ..}", filled with points of the walls; empty: TrueWalls
  bool accelerometer_calibrated = false;  ///< its scale factors and cross-axis terms are taken back
  double sigma_velocity = 0.05, sigma_gyro_bias = 1e-3, sigma_acc_bias = 0.2, sigma_tilt = 0.02;
};

/// One run over a motion inside the room, seen by the pattern of an Avia in the origin of the IMU. The state at the
/// start is off by an error drawn from the filter's own covariance.
class KnownRoom {
 public:
  KnownRoom(const simulator::Motion& motion, const KnownRoomSetting& setting, std::uint64_t seed);

  bool at_end() const;
  /// The next window.
  const Update& step();
  /// What a perfect estimate would be at an IMU sample, calibration and delay included.
  NavState truth(TimeNs t) const;
  /// d^T P^-1 d for the error d of the pose (theta, p).
  double pose_nees(const Update& update) const;

 private:
  void start();
  void build_map();
  void record_imu(std::uint64_t seed);

  const simulator::Motion& motion_;
  KnownRoomSetting setting_;
  BuildEnvironment environment_;
  simulator::RandomStream random_;
  double pattern_phase_ = 0;  ///< [s]
  simulator::ImuRecord imu_;
  simulator::ImuCalibration calibration_;
  std::unique_ptr<Estimator> estimator_;
  std::unique_ptr<HistoryPolicy> history_;
  std::unique_ptr<Map> map_;
  SamplerChain samplers_;
  Window window_;
  std::vector<TimedPoint> points_;
};

}  // namespace aslio::test
