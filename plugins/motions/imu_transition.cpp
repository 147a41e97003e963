#include "motions/imu_transition.hpp"

namespace aslio::plugins {

namespace {

using Rows = Eigen::Matrix<double, 3, kStateDim>;

/// theta, p and v rows of F X for a square X whose rows are blocks of the error state.
struct MovedRows {
  Rows theta, p, v;
};

MovedRows moved_rows(const ImuTransition& f, const StateMatrix& X) {
  const auto x_theta = X.middleRows<3>(block::theta);
  const auto x_v = X.middleRows<3>(block::v);
  Rows x_bw = X.middleRows<3>(block::b_w);
  for (int c = 0; c < 3; ++c) x_bw += f.w_measured[c] * X.middleRows<3>(block::s + 3 * c);
  x_bw -= f.w_change * X.row(block::d);
  const Rows x_ba = X.middleRows<3>(block::b_a) - f.a_change * X.row(block::d);
  MovedRows out;
  out.theta.noalias() = f.theta_theta * x_theta;
  out.theta.noalias() += f.theta_bw * x_bw;
  Rows increment = f.dt * X.middleRows<3>(block::g);
  increment.noalias() += f.v_theta * x_theta;
  increment.noalias() += f.v_bw * x_bw;
  increment.noalias() += f.v_ba * x_ba;
  out.v = x_v + increment;
  out.p = X.middleRows<3>(block::p) + f.dt * x_v + f.position_factor * increment;
  return out;
}

void assign_rows(const MovedRows& rows, StateMatrix& X) {
  X.middleRows<3>(block::theta) = rows.theta;
  X.middleRows<3>(block::p) = rows.p;
  X.middleRows<3>(block::v) = rows.v;
}

}  // namespace

void ImuTransition::apply(const ImuNoise& noise, StateMatrix& P) const {
  // P <- F P F^T: F acts on rows, then (P symmetric) on the rows of the transpose.
  assign_rows(moved_rows(*this, P), P);
  StateMatrix transposed = P.transpose();
  assign_rows(moved_rows(*this, transposed), transposed);
  P = transposed;

  // P += G Q G^T. eq. MOT-2: gyro noise enters theta, v and p through the columns of b_w, accelerometer noise through
  // b_a.
  Eigen::Matrix<double, 9, 3> gyro;
  gyro << theta_bw, position_factor * v_bw, v_bw;
  Eigen::Matrix<double, 6, 3> acc;
  acc << position_factor * v_ba, v_ba;
  P.topLeftCorner<9, 9>().noalias() += noise.gyro * gyro * gyro.transpose();
  P.block<6, 6>(block::p, block::p).noalias() += noise.acc * acc * acc.transpose();
  if (noise.uneven()) {  // eq. MOT-12
    P.topLeftCorner<9, 9>() += gyro * noise.gyro_axes.asDiagonal() * gyro.transpose();
    P.block<6, 6>(block::p, block::p) += acc * noise.acc_axes.asDiagonal() * acc.transpose();
  }
  P.diagonal().segment<3>(block::b_w).array() += noise.gyro_bias * dt * dt;
  P.diagonal().segment<3>(block::b_a).array() += noise.acc_bias * dt * dt;
}

void ImuTransition::dense(StateMatrix& F, Eigen::Matrix<double, kStateDim, 12>& G) const {
  F = StateMatrix::Identity();
  assign_rows(moved_rows(*this, F), F);
  G.setZero();
  G.block<3, 3>(block::theta, 0) = theta_bw;
  G.block<3, 3>(block::v, 0) = v_bw;
  G.block<3, 3>(block::p, 0) = position_factor * v_bw;
  G.block<3, 3>(block::v, 3) = v_ba;
  G.block<3, 3>(block::p, 3) = position_factor * v_ba;
  G.block<3, 3>(block::b_w, 6) = dt * Mat3::Identity();
  G.block<3, 3>(block::b_a, 9) = dt * Mat3::Identity();
}

}  // namespace aslio::plugins
