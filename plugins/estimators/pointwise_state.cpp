#include "estimators/pointwise_state.hpp"

#include <Eigen/Geometry>

namespace aslio::plugins {

namespace pw = pointwise;

// eq. PTW-1.
void PointwiseState::advance(TimeNs to) {
  const double dt = to_seconds(to - t);
  const Vec3 a_W = R * a + g;
  p += dt * (v + 0.5 * dt * a_W);
  v += dt * a_W;
  R = orthonormalised(R * exp_so3(dt * w));
  t = to;
}

void PointwiseState::add(const pw::Vector& delta, bool unit_gravity) {
  R = orthonormalised(R * exp_so3(delta.segment<3>(pw::theta)));
  p += delta.segment<3>(pw::p);
  v += delta.segment<3>(pw::v);
  w += delta.segment<3>(pw::w);
  a += delta.segment<3>(pw::a);
  b_w += delta.segment<3>(pw::b_w);
  b_a += delta.segment<3>(pw::b_a);
  const double length = g.norm();
  g += delta.segment<3>(pw::g);
  if (unit_gravity) g *= length / g.norm();
}

NavState PointwiseState::nav() const {
  NavState out;
  out.t = t;
  out.R = R;
  out.p = p;
  out.v = v;
  out.b_w = b_w;
  out.b_a = b_a;
  out.g = g;
  return out;
}

bool PointwiseState::finite() const {
  return R.allFinite() && p.allFinite() && v.allFinite() && w.allFinite() && a.allFinite() && g.allFinite() &&
         b_w.allFinite() && b_a.allFinite();
}

PointwiseTransition::PointwiseTransition(const PointwiseState& x, double dt)
    : dt_(dt),
      theta_theta_(exp_so3(-dt * x.w)),
      theta_w_(dt * right_jacobian_so3(dt * x.w)),
      v_theta_(-dt * x.R * hat(x.a)),
      v_a_(dt * x.R) {}

/// X <- F X.
void PointwiseTransition::move_rows(pw::Matrix& X) const {
  using Rows = Eigen::Matrix<double, 3, pw::kDim>;
  Rows increment = dt_ * X.middleRows<3>(pw::g);  // of v
  increment.noalias() += v_theta_ * X.middleRows<3>(pw::theta);
  increment.noalias() += v_a_ * X.middleRows<3>(pw::a);
  Rows turn;
  turn.noalias() = theta_theta_ * X.middleRows<3>(pw::theta);
  turn.noalias() += theta_w_ * X.middleRows<3>(pw::w);
  X.middleRows<3>(pw::theta) = turn;
  X.middleRows<3>(pw::p) += dt_ * (X.middleRows<3>(pw::v) + 0.5 * increment);
  X.middleRows<3>(pw::v) += increment;
}

// eq. PTW-2.
void PointwiseTransition::apply(const PointwiseNoise& noise, pw::Matrix& P) const {
  move_rows(P);
  pw::Matrix moved = P.transpose();
  move_rows(moved);
  P = 0.5 * (moved + moved.transpose());
  const double dt2 = dt_ * dt_;
  P.diagonal().segment<3>(pw::v).array() += noise.velocity * dt2;
  P.diagonal().segment<3>(pw::w).array() += noise.rate * dt2;
  P.diagonal().segment<3>(pw::a).array() += noise.force * dt2;
  P.diagonal().segment<3>(pw::b_w).array() += noise.gyro_bias * dt2;
  P.diagonal().segment<3>(pw::b_a).array() += noise.acc_bias * dt2;
}

pw::Matrix PointwiseTransition::dense() const {
  pw::Matrix F = pw::Matrix::Identity();
  move_rows(F);
  return F;
}

}  // namespace aslio::plugins
