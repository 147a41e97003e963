#pragma once
/// State of a filter of a recursive spline: four control poses, and what the IMU needs beside them
/// (docs/equations.md SPL-4 to SPL-7; after Cao, Talbot and Li, RESPLE, 2025).

#include "aslio/stages/motion.hpp"
#include "estimators/cubic_spline.hpp"

namespace aslio::plugins {

/// Error order: (theta, p) of each of the four control poses, then b_w, b_a, g.
namespace spline {
inline constexpr int kControl = 24, kDim = 33, kMomentDim = 21;
inline constexpr int b_w = 24, b_a = 27, g = 30;
constexpr int theta(int i) { return 6 * i; }
constexpr int p(int i) { return 6 * i + 3; }
using Vector = Eigen::Matrix<double, kDim, 1>;
using Matrix = Eigen::Matrix<double, kDim, kDim>;
/// Of one moment, error order (theta, p, v, w, b_w, b_a, g).
namespace moment {
inline constexpr int theta = 0, p = 3, v = 6, w = 9, b_w = 12, b_a = 15, g = 18;
}
using MomentMatrix = Eigen::Matrix<double, kMomentDim, kMomentDim>;
}  // namespace spline

struct SplineState {
  TimeNs begin = 0;     ///< of the segment that the control poses make
  TimeNs interval = 1;  ///< between knots [ns], > 0
  ControlPoses control;
  Vec3 b_w = Vec3::Zero(), b_a = Vec3::Zero();
  Vec3 g = Vec3(0, 0, -kStandardGravity);

  TimeNs end() const { return begin + interval; }
  /// Time of control pose i after t [s].
  double after(int i, TimeNs t) const { return to_seconds(begin - t + (i - 1) * interval); }
  /// Of the segment that has passed at t, in [0, 1].
  double share(TimeNs t) const;
  CubicSplineSegment segment() const { return {control, to_seconds(interval)}; }
  SplineMoment moment(TimeNs t) const { return segment().at(share(t)); }
  NavState nav(TimeNs t) const;
  bool finite() const;

  /// A motion of constant velocity [m/s, W] and rate [rad/s, I] through `at` at t; the segment begins there.
  void set(TimeNs t, const Pose& at, const Vec3& v, const Vec3& w);
  /// Another velocity, the position at t being the same.
  void change_velocity(TimeNs t, const Vec3& by);
  /// x [+] delta; with `unit_gravity` the length of g is kept.
  void add(const spline::Vector& delta, bool unit_gravity);
  /// x [-] reference.
  spline::Vector minus(const SplineState& reference) const;
};

/// How far the motion departs from constant velocity and rate.
struct SplineNoise {
  double acceleration = 10;  ///< standard deviation over one interval [m/s^2]
  double turn = 10;          ///< the same of the angular acceleration [rad/s^2]
  double kept = 0;           ///< share of the variance of a new control pose that the others get with it
  double gyro_bias = 1e-7;   ///< of the random walk [(rad/s)^2/s]
  double acc_bias = 1e-5;    ///< [(m/s^2)^2/s]
};

/// A state, and the covariance of its errors.
struct SplineBelief {
  SplineState x;
  spline::Matrix P = spline::Matrix::Zero();

  /// The next segment: a control pose more, by constant velocity; the oldest leaves. eq. SPL-5.
  void extend(const SplineNoise& noise);
  /// Towards t, which lies behind the segment: by one control pose, or over more than 10 s to t in closed form. eq.
  /// SPL-6.
  void advance(TimeNs t, const SplineNoise& noise);
  /// P for a motion of constant velocity and rate through x.moment(t), of which `P_moment` is known. eq. SPL-6.
  void spread(TimeNs t, const spline::MomentMatrix& P_moment, const SplineNoise& noise);
  spline::MomentMatrix moment_covariance(TimeNs t) const;
  /// Error order of NavState.
  StateMatrix nav_covariance(TimeNs t) const;

 private:
  void jump(TimeNs t, const SplineNoise& noise);
};

/// Normal equations of measurements of one segment: A = sum h^T h / R, b = sum h^T z / R.
struct SplineInformation {
  spline::Matrix A = spline::Matrix::Zero();
  spline::Vector b = spline::Vector::Zero();
  double weighted_sum = 0;  ///< sum z^2 / R
  std::size_t rows = 0;

  /// z = h(p_W) with dz/dp_W = u, of the point p_I seen from attitude R. Returns the row of (theta, p) of that moment.
  Vec6 add_point(const SplineSlopes& slopes, const Mat3& R, const Vec3& p_I, const Vec3& u, double z,
                 double information);
  /// Axes of `sample` whose bit is set in the masks (1, 2, 4 of x, y, z). eq. SPL-7.
  void add_gyro(const SplineMoment& at, const SplineSlopes& slopes, const SplineState& x, const ImuSample& sample,
                unsigned axes, double variance);
  void add_acc(const SplineMoment& at, const SplineSlopes& slopes, const SplineState& x, const ImuSample& sample,
               unsigned axes, double variance);

 private:
  void add(const spline::Vector& h, double z, double information);
};

/// One step of the iterated filter, about the iterate x. eq. SPL-8.
struct SplineStep {
  spline::Vector delta;
  spline::Matrix P;  ///< posterior, symmetric

  /// `prior` is the covariance at the prior, d = x [-] prior.
  SplineStep(const spline::Matrix& prior, const spline::Vector& d, const SplineInformation& information);
};

/// z^T (H P H^T + R)^-1 z of rows taken at the prior. eq. IESKF-10.
double squared_innovation(const spline::Matrix& P, const SplineInformation& information);

}  // namespace aslio::plugins
