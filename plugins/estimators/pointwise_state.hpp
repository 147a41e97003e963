#pragma once
/// State of a filter that takes points and IMU samples one after the other: rate and specific force of the body are
/// states, which the IMU measures (docs/equations.md PTW-1 to PTW-3; He et al., Point-LIO, 2023).

#include "aslio/core/types.hpp"

namespace aslio::plugins {

/// Error order (theta, p, v, w, a, g, b_w, b_a).
namespace pointwise {
inline constexpr int kDim = 24;
inline constexpr int theta = 0, p = 3, v = 6, w = 9, a = 12, g = 15, b_w = 18, b_a = 21;
using Vector = Eigen::Matrix<double, kDim, 1>;
using Matrix = Eigen::Matrix<double, kDim, kDim>;
}  // namespace pointwise

struct PointwiseState {
  TimeNs t = 0;
  Mat3 R = Mat3::Identity();  ///< R_W_I
  Vec3 p = Vec3::Zero();
  Vec3 v = Vec3::Zero();  ///< [m/s], in W
  Vec3 w = Vec3::Zero();  ///< true angular rate of I [rad/s], in I
  Vec3 a = Vec3::Zero();  ///< true specific force at the origin of I [m/s^2], in I
  Vec3 g = Vec3(0, 0, -kStandardGravity);
  Vec3 b_w = Vec3::Zero(), b_a = Vec3::Zero();

  /// Moves on to `to` with constant rate and world acceleration. eq. PTW-1.
  void advance(TimeNs to);
  /// x [+] delta; with `unit_gravity` the length of g is kept.
  void add(const pointwise::Vector& delta, bool unit_gravity);
  NavState nav() const;
  bool finite() const;
};

/// Variances of the random walks per second squared of a step: Q of `P <- F P F^T + Q dt^2`.
struct PointwiseNoise {
  double velocity = 20;     ///< [(m/s^2)^2]
  double rate = 1000;       ///< [(rad/s^2)^2]
  double force = 500;       ///< [(m/s^3)^2]
  double gyro_bias = 1e-4;  ///< [(rad/s^2)^2]
  double acc_bias = 1e-4;   ///< [(m/s^3)^2]
};

/// F of one step of `dt` seconds that begins in `x`. eq. PTW-2.
class PointwiseTransition {
 public:
  PointwiseTransition(const PointwiseState& x, double dt);
  /// P <- F P F^T + Q dt^2.
  void apply(const PointwiseNoise& noise, pointwise::Matrix& P) const;
  pointwise::Matrix dense() const;

 private:
  void move_rows(pointwise::Matrix& X) const;

  double dt_;
  Mat3 theta_theta_, theta_w_, v_theta_, v_a_;
};

/// Scalar measurements that belong to one moment, taken one by one: the same as all at once, since each is corrected
/// for what those before it have moved. eq. PTW-3.
class SequentialUpdate {
 public:
  explicit SequentialUpdate(pointwise::Matrix& P) : P_(P) {}
  /// r + h . delta_pose = noise of variance `variance`, h over (theta, p).
  void pose(const Vec6& h, double r, double variance) {
    take(P_.leftCols<6>() * h, h.dot(delta_.head<6>()) + r, variance,
         [&h](const pointwise::Vector& x) { return h.dot(x.head<6>()); });
  }
  /// r + (delta_i + delta_j) = noise of variance `variance`.
  void sum(int i, int j, double r, double variance) {
    take(P_.col(i) + P_.col(j), delta_[i] + delta_[j] + r, variance,
         [i, j](const pointwise::Vector& x) { return x[i] + x[j]; });
  }
  const pointwise::Vector& delta() const { return delta_; }
  /// Sum of innovation^2 over its variance.
  double nis() const { return nis_; }

 private:
  template <class Project>
  void take(const pointwise::Vector& Ph, double innovation, double variance, const Project& project) {
    const double total = project(Ph) + variance;
    delta_ -= (innovation / total) * Ph;
    const pointwise::Vector scaled = Ph / std::sqrt(total);
    P_.noalias() -= scaled * scaled.transpose();
    nis_ += innovation * innovation / total;
  }

  pointwise::Matrix& P_;
  pointwise::Vector delta_ = pointwise::Vector::Zero();
  double nis_ = 0;
};

}  // namespace aslio::plugins
