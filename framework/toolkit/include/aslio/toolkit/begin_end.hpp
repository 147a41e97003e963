#pragma once
/// A window as a path between two poses, both unknown (CT-ICP), and the normal equations of its points.

#include <Eigen/Geometry>

#include "aslio/stages/estimator.hpp"

namespace aslio {

using Vec12 = Eigen::Matrix<double, 12, 1>;
using Mat12 = Eigen::Matrix<double, 12, 12>;

/// R(alpha) = R_b Exp(alpha phi), phi = Log(R_b^T R_e); p(alpha) = (1 - alpha) p_b + alpha p_e. Unknowns (theta_b, p_b,
/// theta_e, p_e). eq. CT-1
class BeginEnd final : public TrajectoryModel {
 public:
  /// The pose at one share of the window, and d theta(alpha) / d theta of both ends. eq. CT-2
  struct At {
    double alpha = 0;
    Pose T;
    Mat3 of_begin, of_end;
  };

  void set(TimeNs begin_t, const Pose& begin, TimeNs end_t, const Pose& end);
  const Pose& begin() const { return begin_; }
  const Pose& end() const { return end_; }
  double share(TimeNs t) const;
  At at(double alpha) const;

  Pose pose(TimeNs t) const override { return at(share(t)).T; }
  int dof() const override { return 12; }
  Pose moved(TimeNs t, const Eigen::VectorXd& xi) const override;
  void jacobian(TimeNs t, Eigen::MatrixXd& out) const override;

 private:
  TimeNs begin_t_ = 0, end_t_ = 0;
  Pose begin_, end_;
  Vec3 phi_ = Vec3::Zero();
  Mat3 left_inverse_ = Mat3::Identity(), right_inverse_ = Mat3::Identity();  ///< Jacobians of Log at phi
};

/// A = sum h^T h / R and b = sum h^T z / R over the rows of a window.
struct BeginEndInformation {
  Mat12 A = Mat12::Zero();
  Vec12 b = Vec12::Zero();
  double squared_sum = 0;  ///< of the residuals that take part [m^2]
  std::size_t accepted = 0;

  /// Residual z of the world point p_W measured at `at`, u = dz/dp_W, information 1/R. eq. CT-2
  void add(const BeginEnd::At& at, const Vec3& p_W, const Vec3& u, double z, double information);
  BeginEndInformation& operator+=(const BeginEndInformation& other);
};

/// What is known of the end once the begin is solved for: A_ee - A_eb A_bb^-1 A_be. eq. CT-4
Mat6 end_information(const Mat12& A);

}  // namespace aslio
