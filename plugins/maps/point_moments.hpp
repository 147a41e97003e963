#pragma once
/// What a plane needs to know of points: their number, sum and squares, which move as the points do (docs/equations.md
/// MAP-10; the point clusters of BALM2, Liu et al. 2023).

#include <array>

#include "aslio/core/lie.hpp"

namespace aslio::plugins {

/// Weighted sums over points p [m] in one frame: w, w p and w p p^T. Exact under rigid motions, so that points which
/// move together need not be kept.
struct PointMoments {
  double n = 0;                    ///< sum of weights
  Vec3 sum = Vec3::Zero();         ///< [m]
  std::array<double, 6> square{};  ///< xx, xy, xz, yy, yz, zz [m^2]

  void add(const Vec3& p) {
    n += 1.0;
    sum += p;
    std::size_t k = 0;
    for (int i = 0; i < 3; ++i)
      for (int j = i; j < 3; ++j) square[k++] += p[i] * p[j];
  }
  PointMoments& operator+=(const PointMoments& other) {
    n += other.n;
    sum += other.sum;
    for (std::size_t k = 0; k < square.size(); ++k) square[k] += other.square[k];
    return *this;
  }
  Mat3 squares() const {
    Mat3 S;
    S << square[0], square[1], square[2], square[1], square[3], square[4], square[2], square[4], square[5];
    return S;
  }
  Vec3 mean() const { return sum / n; }
  /// About the mean, not divided by n [m^2].
  Mat3 scatter() const { return squares() - sum * sum.transpose() / n; }
  /// Of the same points, each counted `weight` times.
  PointMoments weighted(double weight) const {
    PointMoments out = *this;
    out.n *= weight;
    out.sum *= weight;
    for (double& s : out.square) s *= weight;
    return out;
  }
  /// Of the points T p. eq. MAP-10
  PointMoments moved(const Pose& T) const {
    PointMoments out;
    const Vec3 turned = T.R * sum;
    const Mat3 across = turned * T.p.transpose();
    const Mat3 S = T.R * squares() * T.R.transpose() + across + across.transpose() + n * T.p * T.p.transpose();
    out.n = n;
    out.sum = turned + n * T.p;
    out.square = {S(0, 0), S(0, 1), S(0, 2), S(1, 1), S(1, 2), S(2, 2)};
    return out;
  }
};

}  // namespace aslio::plugins
