#include "aslio/pipeline/mount_check.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace aslio::pipeline {

namespace {

constexpr double kRow = 0.1;      ///< [s] of motion that make one row
constexpr double kMemory = 20.0;  ///< [s]
constexpr double kMinRows = 50;
constexpr double kSigmas = 4.0;
// Shares that are allowed, chosen on seeds from 100 up (docs/results/monitor.md): sound runs reach two thirds of them.
constexpr double kFast = 0.5;  ///< RMS of the rate [rad/s]
constexpr double kAllowedFast = 0.075, kAllowed = 0.375;
/// Below this RMS of the rate an axis says nothing: the points contradict noise and bias of a gyro in full [rad/s].
constexpr double kStill = 0.05;

}  // namespace

void MountCheck::interrupt() {
  correction_ = measured_ = Vec3::Zero();
  time_ = 0;
}

void MountCheck::add(const Vec3& correction, const Vec3& measured, double dt) {
  correction_ += correction;
  measured_ += measured;
  time_ += dt;
  if (time_ >= kRow) close();
}

// eq. MON-7.
void MountCheck::close() {
  const double keep = std::exp(-time_ / kMemory);
  const Vec3 y = correction_ / time_, w = measured_ / time_;
  power_ = keep * power_ + w * w.transpose();
  product_ = keep * product_ + y * w.transpose();
  square_ = keep * square_ + y.squaredNorm();
  rows_ = keep * rows_ + 1;
  interrupt();
  if (rows_ >= kMinRows) judge();
}

void MountCheck::judge() {
  Eigen::SelfAdjointEigenSolver<Mat3> axes;
  axes.computeDirect(power_);
  const Vec3& power = axes.eigenvalues();
  Vec3 share = Vec3::Zero();
  double rest = square_;
  for (int i = 0; i < 3; ++i) {
    if (power[i] < 1e-9) continue;
    share[i] = (product_ * axes.eigenvectors().col(i)).norm() / power[i];
    rest -= share[i] * share[i] * power[i];
  }
  const double variance = std::max(rest, 0.0) / (3 * rows_);
  contradiction_ = 0;
  for (int i = 0; i < 3; ++i) {
    const double rate = std::sqrt(std::max(power[i], 0.0) / rows_);
    if (rate < kStill) continue;
    const double allowed = rate > kFast ? kAllowedFast : kAllowed;
    const double surely = (share[i] - kSigmas * std::sqrt(variance / power[i])) / allowed;
    if (surely <= contradiction_) continue;
    contradiction_ = surely;
    share_ = share[i];
    axis_ = axes.eigenvectors().col(i);
  }
}

}  // namespace aslio::pipeline
