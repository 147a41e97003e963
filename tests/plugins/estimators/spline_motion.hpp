#pragma once
/// Control poses and states of splines, for the tests of the recursive spline.

#include <random>

#include "estimators/spline_state.hpp"

namespace aslio::test {

inline Vec3 some_vector(std::mt19937_64& engine, double size) {
  const auto one = [&] { return size * (2.0 * static_cast<double>(engine() >> 11) * 0x1p-53 - 1.0); };
  const double x = one(), y = one();
  return {x, y, one()};
}

/// Anywhere, with up to 0.5 rad and 0.1 m per axis from one to the next.
inline plugins::ControlPoses some_control_poses(std::mt19937_64& engine) {
  plugins::ControlPoses out;
  out[0] = {exp_so3(some_vector(engine, 2)), some_vector(engine, 10)};
  for (std::size_t i = 1; i < 4; ++i) {
    out[i] = {out[i - 1].R * exp_so3(some_vector(engine, 0.5)), out[i - 1].p + some_vector(engine, 0.1)};
  }
  return out;
}

inline plugins::SplineState some_spline_state(std::mt19937_64& engine) {
  plugins::SplineState x;
  x.begin = 1'700'000'000 * kSecond;
  x.interval = kSecond / 50;
  x.control = some_control_poses(engine);
  x.b_w = some_vector(engine, 0.01);
  x.b_a = some_vector(engine, 0.1);
  x.g = Vec3(0.1, -0.2, -9.8);
  return x;
}

inline plugins::spline::Matrix some_spline_covariance(std::mt19937_64& engine) {
  plugins::spline::Matrix root;
  for (Eigen::Index i = 0; i < root.size(); i += 3) root.reshaped().segment<3>(i) = some_vector(engine, 0.01);
  return root * root.transpose() + 1e-6 * plugins::spline::Matrix::Identity();
}

}  // namespace aslio::test
