#include "aslio/toolkit/begin_end.hpp"

#include <Eigen/Cholesky>

namespace aslio {

void BeginEnd::set(TimeNs begin_t, const Pose& begin, TimeNs end_t, const Pose& end) {
  begin_t_ = begin_t;
  end_t_ = end_t;
  begin_ = begin;
  end_ = end;
  phi_ = log_so3(begin.R.transpose() * end.R);
  left_inverse_ = left_jacobian_inverse_so3(phi_);
  right_inverse_ = right_jacobian_inverse_so3(phi_);
}

double BeginEnd::share(TimeNs t) const {
  if (t >= end_t_) return 1.0;
  return t <= begin_t_ ? 0.0 : static_cast<double>(t - begin_t_) / static_cast<double>(end_t_ - begin_t_);
}

BeginEnd::At BeginEnd::at(double alpha) const {
  const Vec3 turned = alpha * phi_;
  const Mat3 turn = exp_so3(turned), rate = alpha * right_jacobian_so3(turned);
  At out;
  out.alpha = alpha;
  out.T = {begin_.R * turn, (1.0 - alpha) * begin_.p + alpha * end_.p};
  out.of_begin = turn.transpose() - rate * left_inverse_;
  out.of_end = rate * right_inverse_;
  return out;
}

Pose BeginEnd::moved(TimeNs t, const Eigen::VectorXd& xi) const {
  BeginEnd other;
  other.set(begin_t_, begin_.moved(xi.head<6>()), end_t_, end_.moved(xi.tail<6>()));
  return other.pose(t);
}

void BeginEnd::jacobian(TimeNs t, Eigen::MatrixXd& out) const {
  const At here = at(share(t));
  out.resize(6, 12);
  out.setZero();
  out.block<3, 3>(0, 0) = here.of_begin;
  out.block<3, 3>(0, 6) = here.of_end;
  out.block<3, 3>(3, 3) = (1.0 - here.alpha) * Mat3::Identity();
  out.block<3, 3>(3, 9) = here.alpha * Mat3::Identity();
}

void BeginEndInformation::add(const BeginEnd::At& at, const Vec3& p_W, const Vec3& u, double z, double information) {
  const Vec3 u_I = at.T.R.transpose() * u;
  const Vec3 p_I = at.T.R.transpose() * (p_W - at.T.p);
  const Vec3 turn = p_I.cross(u_I);
  Vec12 h;
  h << at.of_begin.transpose() * turn, (1.0 - at.alpha) * u, at.of_end.transpose() * turn, at.alpha * u;
  const Vec12 weighted = information * h;
  for (int column = 0; column < 12; ++column) A.col(column).noalias() += h[column] * weighted;
  b += z * weighted;
  squared_sum += z * z;
  ++accepted;
}

BeginEndInformation& BeginEndInformation::operator+=(const BeginEndInformation& other) {
  A += other.A;
  b += other.b;
  squared_sum += other.squared_sum;
  accepted += other.accepted;
  return *this;
}

Mat6 end_information(const Mat12& A) {
  // The begin may be free in some direction: a trace of a prior keeps the inverse finite.
  const Mat6 begin = A.topLeftCorner<6, 6>() + 1e-9 * (1.0 + A.topLeftCorner<6, 6>().trace()) * Mat6::Identity();
  const Mat6 across = A.topRightCorner<6, 6>();
  const Mat6 end = A.bottomRightCorner<6, 6>() - across.transpose() * begin.ldlt().solve(across);
  return 0.5 * (end + end.transpose());
}

}  // namespace aslio
