#pragma once
/// T_W_I over one slice of a smoother, between the states at its ends, and what the points of the slice tell of both.

#include <Eigen/Geometry>
#include <span>
#include <vector>

#include "aslio/stages/estimator.hpp"
#include "estimators/smoothing_pass.hpp"

namespace aslio::plugins {

/// The IMU carries the pose on from the begin; what it then misses the end by grows evenly over the slice:
/// R(t) = Exp(a psi) R_imu(t), p(t) = p_imu(t) + a m. eq. SMO-1.
class SlicePath {
 public:
  /// The pose at one time, and d(theta)(t) / d(theta) of the poses at both ends; positions: 1 - share, share.
  struct Slope {
    double share = 0;
    Mat3 of_begin, of_end;
  };

  void clear(const NavState& begin, TimeNs end);
  /// Pre: in order of time; `after` is the state at the end of the segment.
  void append(const MotionSegment& segment, const NavState& after);
  /// Makes the path end in `end`.
  void meet(const NavState& end);
  /// The same with both ends elsewhere: what the IMU carried turns and goes with the begin, in W its velocities and
  /// accelerations stay.
  SlicePath between(const Pose& begin, const Pose& end) const;

  const NavState& begin() const { return begin_; }
  const NavState& predicted() const { return predicted_; }  ///< the end as the IMU has it
  const NavState& end() const { return end_; }
  double share(TimeNs t) const;
  Pose pose(TimeNs t) const;
  Slope slope(TimeNs t) const;
  /// Appends the states at the ends of the segments.
  void list_states(std::vector<NavState>& out) const;
  /// Where points lie that were measured at `times`, in order of time, at p_I = `body`: p_W, R(t) p_I and the share.
  void place(std::span<const Vec3> body, std::span<const TimeNs> times, std::span<Vec3> world, std::span<Vec3> lever,
             std::span<double> share) const;

 private:
  const MotionSegment* segment_of(TimeNs t) const;

  NavState begin_, predicted_, end_;
  TimeNs end_t_ = 0;
  std::vector<MotionSegment> segments_;
  Vec3 turn_ = Vec3::Zero(), move_ = Vec3::Zero();  ///< psi and m, in W
};

/// Poses over the fresh slices of a window. Unknowns: those at the begin of the first and at the end of each.
class SliceChain final : public TrajectoryModel {
 public:
  void clear() { paths_.clear(); }
  void append(const SlicePath& path) { paths_.push_back(&path); }

  Pose pose(TimeNs t) const override { return paths_[slice_of(t)]->pose(t); }
  Pose moved(TimeNs t, const Eigen::VectorXd& xi) const override;
  int dof() const override { return 6 * static_cast<int>(paths_.size() + 1); }
  void jacobian(TimeNs t, Eigen::MatrixXd& out) const override;

 private:
  std::size_t slice_of(TimeNs t) const;

  std::vector<const SlicePath*> paths_;
};

/// Sums over the rows of one slice, with g = (l x u, u) for the lever l = R(t) p_I, both in W, and the share a of the
/// slice: moments of a tell what belongs to its begin and what to its end.
struct SliceInformation {
  Mat6 A0 = Mat6::Zero(), A1 = Mat6::Zero(), A2 = Mat6::Zero();  ///< sums of g g^T / R, a g g^T / R, a^2 g g^T / R
  Vec6 b0 = Vec6::Zero(), b1 = Vec6::Zero();                     ///< sums of g z / R and a g z / R
  double squared_sum = 0;                                        ///< of the residuals that take part [m^2]
  double weighted_sum = 0;                                       ///< sum z^2 / R
  std::size_t accepted = 0;

  void add(const Vec3& lever, double share, const Vec3& u, double z, double information) {
    Vec6 g;
    g << lever.cross(u), u;
    const Vec6 weighted = information * g;
    const Mat6 known = weighted * g.transpose();
    A0 += known;
    A1 += share * known;
    A2 += share * share * known;
    b0 += z * weighted;
    b1 += share * z * weighted;
    squared_sum += z * z;
    weighted_sum += z * z * information;
    ++accepted;
  }
  SliceInformation& operator+=(const SliceInformation& other);
  /// Normal equations for the errors (theta, p) of both ends, in attitudes `begin` and `end`. eq. SMO-1
  void tell(const Mat3& begin, const Mat3& end, SliceEquations& out) const;
};

}  // namespace aslio::plugins
