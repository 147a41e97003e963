#pragma once
/// The normal equations of a motion that registers points with cells (docs/equations.md INI-6, WID-1).

#include <array>
#include <span>

#include "sweep_cells.hpp"

namespace aslio::pipeline {

using Vec9 = Eigen::Matrix<double, 9, 1>;  ///< v, g, e of a ConstantMotion
using Mat9 = Eigen::Matrix<double, 9, 9>;

/// How far a registration looks, from coarse to fine: edge of the cells and least deviation from a surface [m].
struct RegistrationLevel {
  double edge, softness;
  int iterations;
};
inline constexpr std::array<RegistrationLevel, 3> kLevels = {{{2.0, 0.2, 5}, {1.0, 0.08, 5}, {0.5, 0.04, 6}}};

inline constexpr std::size_t kQueryPoints = 1200;  ///< that are registered, of a sweep or a window
inline constexpr double kMaxRange = 50.0;          ///< beyond, points lie too far apart for the cells [m]

/// One standard deviation of what is known beforehand: [m/s], [m/s^2], [rad/s].
struct MotionSigma {
  double v, g, e;
};

struct MotionNormal {
  Mat9 H = Mat9::Zero();
  Vec9 b = Vec9::Zero();

  void add_prior(const ConstantMotion& motion, const ConstantMotion& known, const MotionSigma& sigma);
  /// Every point with the nearest cell that binds; what lies far off hardly counts.
  void add_matches(std::span<const SweepPoint> points, const ConstantMotion& motion, SweepCells& cells);
  /// One step of Gauss and Newton; its length. A motion stays where it is when nothing finite comes out.
  double step(ConstantMotion& motion) const;
};

/// Mean agreement of points with the surfaces they meet: 0 none, 1 full. `all`: those that meet none count as well, as
/// not in agreement.
double agreement(std::span<const SweepPoint> points, const ConstantMotion& motion, SweepCells& cells, bool all);

}  // namespace aslio::pipeline
