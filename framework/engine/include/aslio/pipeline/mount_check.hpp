#pragma once
/// Whether the corrections by the points repeat the turn, as they do when T_imu_lidar is wrong.

#include "aslio/core/types.hpp"

namespace aslio::pipeline {

/// Regression of the corrections of the attitude on the measured turn, axis by axis (docs/equations.md MON-7). A
/// rotation of the LiDAR that is wrong contradicts the gyro about the axes that it moves, also where most of the turn
/// is about another one. A lever arm that is wrong makes the points contradict a little of every turn, without end. No
/// allocation. Not thread-safe.
class MountCheck {
 public:
  /// `correction` of the attitude, prior to posterior, and the turn that the gyro `measured`, in I [rad]; over `dt`
  /// [s].
  void add(const Vec3& correction, const Vec3& measured, double dt);
  /// What comes next does not count with what came last; what was learnt stays.
  void interrupt();

  /// Share of the turn about an axis that the points contradict beyond doubt, over what is allowed: the largest of the
  /// three axes. Above 1 the mounting is wrong; 0 at the begin.
  double contradiction() const { return contradiction_; }
  /// Of that axis: the share contradicted, and the axis in I.
  double share() const { return share_; }
  const Vec3& axis() const { return axis_; }

 private:
  void close();
  void judge();

  Mat3 power_ = Mat3::Zero();    ///< sum of w w^T [rad^2/s^2]
  Mat3 product_ = Mat3::Zero();  ///< sum of y w^T
  double square_ = 0;            ///< sum of |y|^2
  double rows_ = 0;              ///< number of rows, with what is forgotten taken off
  Vec3 correction_ = Vec3::Zero(), measured_ = Vec3::Zero();
  double time_ = 0;  ///< of the row that is being filled [s]
  double contradiction_ = 0, share_ = 0;
  Vec3 axis_ = Vec3::Zero();
};

}  // namespace aslio::pipeline
