#pragma once
/// A body that walks and swings about all axes, and what sensors on it measure.

#include <cmath>
#include <random>
#include <vector>

#include "aslio/evaluation/turns.hpp"

namespace test {

using aslio::ImuSample;
using aslio::Mat3;
using aslio::Pose;
using aslio::StampedPose;
using aslio::TimeNs;
using aslio::Vec3;

/// Noise that is the same on every machine.
class Noise {
 public:
  explicit Noise(std::uint64_t seed) : engine_(seed) {}
  Vec3 vector(double sigma) { return sigma * Vec3(normal(), normal(), normal()); }

 private:
  double uniform() { return (static_cast<double>(engine_() >> 11) + 0.5) * 0x1p-53; }
  double normal() { return std::sqrt(-2.0 * std::log(uniform())) * std::cos(2.0 * M_PI * uniform()); }
  std::mt19937_64 engine_;
};

/// How far the body swings about each axis [rad], and whether it moves.
struct Swing {
  Vec3 angle{0.15, 0.12, 0.5};
  double stride = 1.0;  ///< of the translation
};

/// T_W_I at `t` [s]; z of W is up.
inline Pose body(double t, const Swing& swing = {}) {
  const Vec3 a(swing.angle.x() * std::sin(5.1 * t + 0.4) * (1 + 0.3 * std::sin(0.7 * t)),
               swing.angle.y() * std::sin(4.3 * t) + 0.5 * swing.angle.y() * std::sin(1.1 * t),
               swing.angle.z() * std::sin(0.9 * t) + 0.3 * swing.angle.z() * std::sin(2.3 * t + 1.0));
  const Mat3 R = aslio::exp_so3({0, 0, a.z()}) * aslio::exp_so3({0, a.y(), 0}) * aslio::exp_so3({a.x(), 0, 0});
  const Vec3 p(1.1 * std::sin(0.8 * t) + 0.06 * std::sin(6.0 * t),
               0.9 * std::cos(0.6 * t) + 0.05 * std::sin(5.2 * t + 1),
               0.06 * std::sin(7.0 * t) + 0.2 * std::sin(0.5 * t));
  return {R, swing.stride * p};
}

/// Samples at 200 Hz over [begin, end] s, with the mean densities of a good MEMS sensor times `noise`.
inline std::vector<ImuSample> imu_of(double begin, double end, const Swing& swing = {}, double noise = 0,
                                     std::uint64_t seed = 1) {
  Noise random(seed);
  std::vector<ImuSample> out;
  const double h = 1e-4;
  for (double t = begin; t <= end; t += 0.005) {
    const Pose at = body(t, swing), before = body(t - h, swing), after = body(t + h, swing);
    ImuSample s;
    s.t = aslio::to_ns(t);
    s.gyro = aslio::log_so3(before.R.transpose() * after.R) / (2 * h) + random.vector(noise * 0.003);
    const Vec3 a = (after.p - 2 * at.p + before.p) / (h * h);
    s.acc = at.R.transpose() * (a + Vec3(0, 0, aslio::kStandardGravity)) + random.vector(noise * 0.02);
    out.push_back(s);
  }
  return out;
}

/// Poses at 10 Hz of a LiDAR that sits at T_I_L, in a world of its own, with noise.
inline aslio::evaluation::MotionStretch lidar_of(double begin, double end, const Pose& T_I_L, const Swing& swing = {},
                                                 double noise = 0, std::uint64_t seed = 2) {
  Noise random(seed);
  const Pose world{aslio::exp_so3({0.1, -0.05, 1.0}), Vec3(3, 2, 1)};
  aslio::evaluation::MotionStretch out;
  for (double t = begin; t <= end; t += 0.1) {
    Pose T = world * body(t, swing) * T_I_L;
    T.R = T.R * aslio::exp_so3(random.vector(noise * 0.001));
    T.p += random.vector(noise * 0.005);
    out.poses.push_back({aslio::to_ns(t), T});
  }
  return out;
}

}  // namespace test
