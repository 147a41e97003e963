#pragma once
/// A motion that follows recorded poses.

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>

#include "aslio/core/types.hpp"
#include "aslio/simulator/motion.hpp"

namespace aslio::config {
class Binder;
}

namespace aslio::simulator {

/// `motion:` of a scene file that follows a trajectory.
struct FollowParams {
  std::string file;            ///< TUM, T_W_I; relative to the scene file
  double knot_interval = 0.1;  ///< of the spline [s]: shorter follows closer, longer smooths the noise of an estimate
  static void describe(config::Binder& b, FollowParams& params);
};

/// Quintic B-spline (four times continuously differentiable) fitted to the poses by least squares; position and
/// quaternion by component, the latter normalised afterwards. Time 0 is the first pose. Throws DataError when there are
/// fewer poses than the spline needs, one is not finite or not later than the one before, a gap spans more than two
/// knots, the quaternion turns too far between poses, or they are further apart than any carrier moves (100 m/s).
/// `fit_error`, where given, receives the largest distance between a pose and the motion [m].
std::unique_ptr<Motion> follow_poses(std::span<const StampedPose> poses, double knot_interval,
                                     double* fit_error = nullptr);
/// The poses of a TUM file. Errors name the file.
std::unique_ptr<Motion> follow_file(const std::filesystem::path& path, double knot_interval,
                                    double* fit_error = nullptr);

}  // namespace aslio::simulator
