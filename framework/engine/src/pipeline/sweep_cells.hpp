#pragma once
/// A sweep as cells of space with the mean and the spread of their points: what another sweep is registered to.

#include <Eigen/Geometry>
#include <optional>
#include <span>
#include <vector>

#include "aslio/core/cell_index.hpp"
#include "aslio/core/types.hpp"

namespace aslio::pipeline {

/// A point of a sweep in a frame that does not turn, which is that of the IMU at the begin of the search (B).
struct SweepPoint {
  Vec3 q = Vec3::Zero();  ///< lever: R_B_I(t) p_I [m]
  Vec3 y = Vec3::Zero();  ///< q and what the specific force alone has moved the sensor by since the begin [m]
  double t = 0;           ///< since the begin [s]
};

/// What the sweeps are registered by: x(t) = y + v t + g t^2 / 2 + t (e x q). eq. INI-6
struct ConstantMotion {
  Vec3 v = Vec3::Zero();  ///< velocity at the begin [m/s], in B
  Vec3 g = Vec3::Zero();  ///< gravity; without IMU data the acceleration [m/s^2], in B
  Vec3 e = Vec3::Zero();  ///< rate that the gyro does not tell [rad/s], in B

  Vec3 place(const SweepPoint& p) const { return p.y + p.t * (v + 0.5 * p.t * g + e.cross(p.q)); }
};

struct SweepCell {
  std::uint32_t count = 0;
  SweepPoint mean;             ///< of the points
  double mean_square_t = 0;    ///< [s^2]
  Vec3 centre = Vec3::Zero();  ///< mean of the placed points [m]
  Mat3 scatter = Mat3::Zero();
  /// Inverse of what a point is expected to lie off by [1/m^2]: a plane binds along its normal alone.
  Mat3 information = Mat3::Zero();
  enum class Shape : std::uint8_t { unknown, binds, loose } shape = Shape::unknown;
};

class SweepCells {
 public:
  /// Replaces all cells by those of `points`, placed by `motion`. `edge`, `softness`: of the cells, and the least that
  /// a point may lie off a surface [m].
  void build(std::span<const SweepPoint> points, const ConstantMotion& motion, double edge, double softness);
  /// The cell with the nearest centre among the 27 around `x`, of those that bind; nullptr without one. A single scan
  /// line over a road or a wall binds nothing: it moves with the sensor.
  const SweepCell* nearest(const Vec3& x);

 private:
  void look_at(SweepCell& cell) const;

  double inverse_edge_ = 1, softness_ = 0;
  Vec3 up_ = Vec3::UnitZ();
  CellIndex index_;
  std::vector<SweepCell> cells_;
};

/// Which cells hold a point of a sweep.
class OccupiedCells {
 public:
  void build(std::span<const SweepPoint> points, const ConstantMotion& motion, double edge);
  bool occupied(const Vec3& x) const;

 private:
  double inverse_edge_ = 1;
  CellIndex index_;
};

}  // namespace aslio::pipeline
