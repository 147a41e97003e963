#pragma once
/// Bundle adjustment of poses on planes (docs/equations.md MAP-10, MAP-11; after BALM2, Liu et al. 2023).

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "maps/point_moments.hpp"

namespace aslio::plugins {

/// Poses of a few keyframes at the least sum of squares of three kinds of terms: the distances of points from the
/// planes they belong to, each plane being the best one through its points; increments between poses; and priors of
/// poses. A plane is not an unknown: its term is the least eigenvalue of the scatter of its points, as a function of
/// the poses that saw them.
///
/// Contract. Lengths in metres, angles in radians; weights are inverse variances, so that the sum has no unit. Poses
/// are T_W_B of any frame B that the clusters of the keyframe are told in; W should have its origin within some 100 m,
/// as squares of coordinates are summed. A plane whose two least eigenvalues are equal has no normal, and is left out.
/// What no term tells needs a prior: an unknown that nothing holds makes solve() fail, and the poses stay. A
/// plane that is not finite is left out. A failure after some steps leaves the poses of the least sum so far. The order
/// of the calls decides the bits, nothing else does. clear() keeps the storage. Time: of a plane that K keyframes see,
/// K^2; of K poses, K^3.
class PlaneBundle {
 public:
  struct Params {
    int max_iterations = 3;   ///< steps that lower the sum, at most
    double converged = 1e-6;  ///< length of a step [rad, m] after which there is no other
  };
  /// The points that one keyframe sees of a plane, in its frame B.
  struct Cluster {
    std::uint32_t pose = 0;
    PointMoments points;
  };
  enum class Outcome : std::uint8_t {
    converged,
    stopped,  ///< at the last iteration
    failed    ///< no step lowers the sum, or nothing holds an unknown
  };
  struct Result {
    Outcome outcome = Outcome::converged;
    int steps = 0;                 ///< that were taken
    double before = 0, after = 0;  ///< the sum of squares
  };

  explicit PlaneBundle(const Params& params) : params_(params) {}

  void clear();
  /// Its number, from 0 on.
  std::uint32_t add_pose(const Pose& pose);
  /// `fixed`: points that do not move, in W; `clusters`: of poses that were added, each at most once. Weighted.
  void add_plane(const PointMoments& fixed, std::span<const Cluster> clusters);
  /// T_from^-1 T_to, known to `information` (theta, p in the frame of `from`).
  void add_increment(std::uint32_t from, std::uint32_t to, const Pose& measured, const Mat6& information);
  /// T of one pose, known to `information` (theta about the axes of B, p in W).
  void add_prior(std::uint32_t pose, const Pose& mean, const Mat6& information);

  Result solve();
  const std::vector<Pose>& poses() const { return poses_; }
  std::size_t planes() const { return planes_.size(); }

  /// Sum of squares at some poses, as many as were added.
  double cost(const std::vector<Pose>& poses) const;
  /// The same with its slope and curvature for R Exp(theta), p + dp of each pose. Those of the planes are exact; the
  /// curvature of increments and priors is that of Gauss and Newton.
  double linearise(const std::vector<Pose>& poses, Eigen::VectorXd& slope, Eigen::MatrixXd& curvature) const;

 private:
  struct Plane {
    PointMoments fixed;
    std::size_t begin = 0, end = 0;  ///< in clusters_
  };
  struct Increment {
    std::uint32_t from = 0, to = 0;
    Pose measured;
    Mat6 information;
  };
  struct Prior {
    std::uint32_t pose = 0;
    Pose mean;
    Mat6 information;
  };
  struct Shape;
  using Coupling = Eigen::Matrix<double, 6, 3>;  ///< slopes of a plane's offset and of its two tilts

  bool shape_of(const Plane& plane, const std::vector<Pose>& poses, Shape& out) const;
  double plane_term(const Plane& plane, const std::vector<Pose>& poses, std::vector<Coupling>& coupled,
                    Eigen::VectorXd& slope, Eigen::MatrixXd& curvature) const;
  bool step(const Eigen::VectorXd& slope, const Eigen::MatrixXd& curvature, double damping);

  Params params_;
  std::vector<Pose> poses_, tried_;
  std::vector<Plane> planes_;
  std::vector<Cluster> clusters_;
  std::vector<Increment> increments_;
  std::vector<Prior> priors_;
  Eigen::VectorXd slope_, move_;
  Eigen::MatrixXd curvature_;
};

}  // namespace aslio::plugins
