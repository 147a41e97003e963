#include "estimators/inertial_terms.hpp"

#include <Eigen/Cholesky>
#include <cmath>

namespace aslio::plugins {

NavState moved(const NavState& x, const Vec15& xi) {
  NavState out = x;
  out.R = orthonormalised(x.R * exp_so3(xi.segment<3>(0)));
  out.p += xi.segment<3>(3);
  out.v += xi.segment<3>(6);
  out.b_w += xi.segment<3>(9);
  out.b_a += xi.segment<3>(12);
  return out;
}

Vec15 difference(const NavState& x, const NavState& reference) {
  Vec15 out;
  out << log_so3(reference.R.transpose() * x.R), x.p - reference.p, x.v - reference.v, x.b_w - reference.b_w,
      x.b_a - reference.b_a;
  return out;
}

StateTerm::At StateTerm::at(const NavState& i, const NavState* j) const {
  At out;
  out.r.setZero(rows_);
  out.J_i.setZero(rows_, kNodeDim);
  out.J_j.setZero(rows_, kNodeDim);
  fill(i, j, out);
  return out;
}

void PriorTerm::fill(const NavState& i, const NavState*, At& out) const {
  const Vec15 off = difference(i, reference_);
  out.r = U_ * off + offset_;
  out.J_i = U_;
  out.J_i.leftCols<3>() = (U_.leftCols<3>() * right_jacobian_inverse_so3(off.segment<3>(0))).eval();
}

InertialTerm::InertialTerm(int first, const Preintegration& motion, const Vec3& gravity, const InertialNoise& noise)
    : StateTerm(kNodeDim, first, true),
      motion_(motion),
      g_(gravity),
      whiten_gyro_bias_(1.0 / (noise.gyro_bias * std::sqrt(motion.seconds))),
      whiten_acc_bias_(1.0 / (noise.acc_bias * std::sqrt(motion.seconds))) {
  // W^T W = covariance^-1 with W = L^-1.
  const Eigen::LLT<Preintegration::Mat9> llt(motion.covariance);
  whiten_ = llt.matrixL().solve(Preintegration::Mat9::Identity());
}

void InertialTerm::fill(const NavState& i, const NavState* j, At& out) const {
  const Preintegration& m = motion_;
  const double t = m.seconds;
  const Mat3 Rt = i.R.transpose();
  const Vec3 d_w = i.b_w - m.b_w, d_a = i.b_a - m.b_a, turned = m.dR_bw * d_w;
  const Vec3 moved_p = Rt * (j->p - i.p - t * i.v - 0.5 * t * t * g_), moved_v = Rt * (j->v - i.v - t * g_);
  const Mat3 E = (m.dR * exp_so3(turned)).transpose() * Rt * j->R;
  const Vec3 off = log_so3(E);
  const Mat3 rate = right_jacobian_inverse_so3(off);

  out.r.segment<3>(0) = off;
  out.r.segment<3>(3) = moved_p - (m.dp + m.dp_bw * d_w + m.dp_ba * d_a);
  out.r.segment<3>(6) = moved_v - (m.dv + m.dv_bw * d_w + m.dv_ba * d_a);
  out.r.segment<3>(9) = whiten_gyro_bias_ * (j->b_w - i.b_w);
  out.r.segment<3>(12) = whiten_acc_bias_ * (j->b_a - i.b_a);

  out.J_i.block<3, 3>(0, 0) = -rate * j->R.transpose() * i.R;
  out.J_i.block<3, 3>(0, 9) = -rate * E.transpose() * right_jacobian_so3(turned) * m.dR_bw;
  out.J_i.block<3, 3>(3, 0) = hat(moved_p);
  out.J_i.block<3, 3>(3, 3) = -Rt;
  out.J_i.block<3, 3>(3, 6) = -t * Rt;
  out.J_i.block<3, 3>(3, 9) = -m.dp_bw;
  out.J_i.block<3, 3>(3, 12) = -m.dp_ba;
  out.J_i.block<3, 3>(6, 0) = hat(moved_v);
  out.J_i.block<3, 3>(6, 6) = -Rt;
  out.J_i.block<3, 3>(6, 9) = -m.dv_bw;
  out.J_i.block<3, 3>(6, 12) = -m.dv_ba;
  out.J_i.block<3, 3>(9, 9) = -whiten_gyro_bias_ * Mat3::Identity();
  out.J_i.block<3, 3>(12, 12) = -whiten_acc_bias_ * Mat3::Identity();
  out.J_j.block<3, 3>(0, 0) = rate;
  out.J_j.block<3, 3>(3, 3) = Rt;
  out.J_j.block<3, 3>(6, 6) = Rt;
  out.J_j.block<3, 3>(9, 9) = whiten_gyro_bias_ * Mat3::Identity();
  out.J_j.block<3, 3>(12, 12) = whiten_acc_bias_ * Mat3::Identity();

  out.r.head<9>() = (whiten_ * out.r.head<9>()).eval();
  out.J_i.topRows<9>() = (whiten_ * out.J_i.topRows<9>()).eval();
  out.J_j.topRows<9>() = (whiten_ * out.J_j.topRows<9>()).eval();
}

void PoseTerm::fill(const NavState& i, const NavState*, At& out) const {
  const Vec3 off = log_so3(found_.R.transpose() * i.R);
  out.r.segment<3>(0) = rotation_ * off;
  out.r.segment<3>(3) = position_ * (i.p - found_.p);
  out.J_i.block<3, 3>(0, 0) = rotation_ * right_jacobian_inverse_so3(off);
  out.J_i.block<3, 3>(3, 3) = position_ * Mat3::Identity();
}

}  // namespace aslio::plugins
