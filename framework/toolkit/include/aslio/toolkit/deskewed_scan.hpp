#pragma once
/// The fresh points of one window on their way from raw to world: sampled, de-skewed to the end of the window, sampled
/// again, placed. Shared by estimators that register a whole window. All storage is reused.

#include <array>
#include <span>
#include <vector>

#include "aslio/toolkit/window_trajectory.hpp"

namespace aslio {

class DeskewedScan {
 public:
  explicit DeskewedScan(const SensorModel& sensor) : T_imu_lidar_(sensor.T_imu_lidar) {}

  /// T_imu_lidar from now on, in place of the sensor file's.
  void set_extrinsic(const Pose& T_imu_lidar) { T_imu_lidar_ = T_imu_lidar; }

  /// sample_raw(), deskew() and sample_body(), each on its clock.
  void load(std::span<const TimedPoint> fresh, const WindowTrajectory& trajectory, SamplerChain& samplers,
            StageTimes& times);
  /// Raw phase of the chain over the fresh points; keeps those some use still wants.
  void sample_raw(std::span<const TimedPoint> fresh, SamplerChain& samplers);
  /// p_I at the end of the window for every kept point (docs/equations.md DSK-1), moved as samplers have moved it.
  void deskew(const WindowTrajectory& trajectory);
  /// p_I of every kept point as measured, without de-skew.
  void bring_to_imu();
  /// Body phase of the chain, then the lists per use.
  void sample_body(SamplerChain& samplers);
  /// p_I of every kept point as measured, those of the match use included, once the samplers have seen them de-skewed.
  void take_as_measured();
  /// match_body() again, for another trajectory; the choice of points, and how samplers have moved them, stays.
  void deskew_matches(const WindowTrajectory& trajectory);
  /// Where the sensor is when the IMU is at T (W from I), W [m].
  Vec3 viewpoint(const Pose& T) const { return T * T_imu_lidar_.p; }
  /// World points of every use, with the correction of the trajectory, and as seen from its end.
  void place(const WindowTrajectory& trajectory);
  /// The same for points as measured, each from the pose of its own time.
  void place_along(const TrajectoryModel& trajectory);

  /// Points of the match use: where deskew() brought them, their range [m] and time.
  std::span<const Vec3> match_body() const { return match_body_; }
  std::span<const float> match_range() const { return match_range_; }
  std::span<const TimeNs> match_time() const { return match_time_; }
  /// As the samplers have marked them (SampleBatch::features).
  std::span<const std::uint8_t> match_feature() const { return match_feature_; }
  std::span<const WorldPoint> world(PointUse use) const {
    return world_[slot(alike_ && use == PointUse::overlap ? PointUse::map : use)];
  }

 private:
  static constexpr std::size_t slot(PointUse use) {
    return use == PointUse::overlap ? 0 : use == PointUse::map ? 1 : 2;
  }

  void reserve(std::size_t points);
  void list_matches();
  void begin_world();
  void list_world(std::size_t i, const Vec3& p_W, const Vec3& viewpoint_W);

  Pose T_imu_lidar_;
  std::vector<TimedPoint> raw_;
  std::vector<std::uint32_t> index_;  ///< into the window's fresh points
  std::vector<PointUses> uses_;
  std::vector<std::uint8_t> features_;
  std::vector<Eigen::Vector3f> body_;
  std::vector<Eigen::Vector3f> moved_;  ///< by how much samplers have moved body_; empty where none does
  std::vector<Vec3> match_body_;
  std::vector<float> match_range_;
  std::vector<std::uint32_t> match_raw_;  ///< into raw_
  std::vector<TimeNs> match_time_;
  std::vector<std::uint8_t> match_feature_;
  std::array<std::vector<WorldPoint>, 3> world_;
  bool alike_ = false;  ///< every point of the overlap use is one of the map use and the other way round: one list
};

}  // namespace aslio
