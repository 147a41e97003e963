#include "estimators/preintegration.hpp"

#include <cmath>

#include "aslio/core/imu_mean.hpp"
#include "aslio/toolkit/imu_noise.hpp"

namespace aslio::plugins {

InertialNoise InertialNoise::over(TimeNs imu_gap) const {
  if (imu_gap <= 0) return *this;
  const UnreadMotion unread(imu_gap);
  InertialNoise out = *this;
  out.gyro = std::sqrt(gyro * gyro + unread.gyro);
  out.acc = std::sqrt(acc * acc + unread.acc);
  return out;
}

Preintegration::Preintegration(std::span<const ImuSample> samples, const NavState& known, const InertialNoise& noise)
    : b_w(known.b_w), b_a(known.b_a) {
  for (std::size_t i = 1; i < samples.size(); ++i) step(samples[i - 1], samples[i], known, noise);
}

void Preintegration::step(const ImuSample& from, const ImuSample& to, const NavState& known,
                          const InertialNoise& noise) {
  const ImuMean u(known, from, to);  // eq. MOT-6: sensitivity and delay would come back as a bias
  const double dt = u.dt;
  if (dt <= 0) return;
  const Vec3 phi = dt * u.w, half = 0.5 * phi;
  const Mat3 half_turn = exp_so3(half), J = dt * right_jacobian_so3(phi);
  const Vec3 force = half_turn * u.a;  // in the axes of the begin of the step

  // Velocity gained in the step, and how it depends on attitude and biases.
  const Vec3 gain = dt * (dR * force);
  const Mat3 gain_theta = -dt * dR * hat(force);
  const Mat3 gain_gyro = 0.5 * dt * dt * dR * half_turn * hat(u.a) * right_jacobian_so3(half);  // of a gyro bias
  const Mat3 gain_acc = -dt * dR * half_turn;
  const Mat3 turn = exp_so3(-phi);

  // eq. PRE-3, error (theta, p, v)
  Mat9 F = Mat9::Identity();
  F.block<3, 3>(0, 0) = turn;
  F.block<3, 3>(3, 0) = 0.5 * dt * gain_theta;
  F.block<3, 3>(3, 6) = dt * Mat3::Identity();
  F.block<3, 3>(6, 0) = gain_theta;
  Eigen::Matrix<double, 9, 6> G;
  G << -J, Mat3::Zero(), 0.5 * dt * gain_gyro, 0.5 * dt * gain_acc, gain_gyro, gain_acc;
  const double gyro = noise.gyro * noise.gyro / dt, acc = noise.acc * noise.acc / dt;
  covariance = (F * covariance * F.transpose()).eval();
  covariance += gyro * G.leftCols<3>() * G.leftCols<3>().transpose();
  covariance += acc * G.rightCols<3>() * G.rightCols<3>().transpose();
  if (const DoubtedMotion doubted(from, to); doubted.any) {  // eq. MOT-12
    covariance += G.leftCols<3>() * (doubted.gyro / dt).asDiagonal() * G.leftCols<3>().transpose();
    covariance += G.rightCols<3>() * (doubted.acc / dt).asDiagonal() * G.rightCols<3>().transpose();
  }
  covariance.diagonal().segment<3>(3).array() += noise.integration * noise.integration * dt;

  // eq. PRE-2
  const Mat3 gained_bw = gain_theta * dR_bw + gain_gyro;
  dp_bw += dt * dv_bw + 0.5 * dt * gained_bw;
  dp_ba += dt * dv_ba + 0.5 * dt * gain_acc;
  dv_bw += gained_bw;
  dv_ba += gain_acc;
  dR_bw = (turn * dR_bw - J).eval();

  // eq. PRE-1
  dp += dt * dv + 0.5 * dt * gain;
  dv += gain;
  dR = orthonormalised(dR * exp_so3(phi));
  seconds += dt;
}

}  // namespace aslio::plugins
