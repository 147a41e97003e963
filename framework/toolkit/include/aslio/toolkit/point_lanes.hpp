#pragma once
/// Eight points at a time, coordinate by coordinate, which a compiler turns into vector instructions.

#include <algorithm>
#include <array>
#include <cmath>

#include "aslio/core/lie.hpp"

namespace aslio {

struct PointLanes {
  static constexpr std::size_t kWidth = 8;
  using Lane = std::array<double, kWidth>;

  Lane x{}, y{}, z{};

  void set(std::size_t l, const Vec3& p) {
    x[l] = p.x();
    y[l] = p.y();
    z[l] = p.z();
  }
  Vec3 operator[](std::size_t l) const { return {x[l], y[l], z[l]}; }

  /// R p + t.
  PointLanes moved(const Mat3& R, const Vec3& t) const {
    PointLanes out;
    for (std::size_t l = 0; l < kWidth; ++l) {
      out.x[l] = R(0, 0) * x[l] + R(0, 1) * y[l] + R(0, 2) * z[l] + t.x();
      out.y[l] = R(1, 0) * x[l] + R(1, 1) * y[l] + R(1, 2) * z[l] + t.y();
      out.z[l] = R(2, 0) * x[l] + R(2, 1) * y[l] + R(2, 2) * z[l] + t.z();
    }
    return out;
  }
  /// p + A w x p + B w x (w x p): turned about w by A = sin(a)/|w|, B = (1 - cos(a))/|w|^2.
  PointLanes turned(const Vec3& w, const Lane& A, const Lane& B) const {
    PointLanes out;
    for (std::size_t l = 0; l < kWidth; ++l) {
      const double cx = w.y() * z[l] - w.z() * y[l], cy = w.z() * x[l] - w.x() * z[l], cz = w.x() * y[l] - w.y() * x[l];
      out.x[l] = x[l] + A[l] * cx + B[l] * (w.y() * cz - w.z() * cy);
      out.y[l] = y[l] + A[l] * cy + B[l] * (w.z() * cx - w.x() * cz);
      out.z[l] = z[l] + A[l] * cz + B[l] * (w.x() * cy - w.y() * cx);
    }
    return out;
  }
};

/// A and B of PointLanes::turned() for the angles |w| tau; `w2` = |w|^2.
inline void turn_factors(double w2, const PointLanes::Lane& tau, PointLanes::Lane& A, PointLanes::Lane& B) {
  const auto [least, most] = std::minmax_element(tau.begin(), tau.end());
  if (w2 * std::max(*least * *least, *most * *most) < 0.01) {  // below 0.1 rad: series exact to 1e-12
    for (std::size_t l = 0; l < tau.size(); ++l) {
      const double x = w2 * tau[l] * tau[l];
      A[l] = tau[l] * (1.0 - x * (1.0 / 6) * (1.0 - x * (1.0 / 20) * (1.0 - x * (1.0 / 42))));
      B[l] = tau[l] * tau[l] * (0.5 - x * (1.0 / 24) * (1.0 - x * (1.0 / 30) * (1.0 - x * (1.0 / 56))));
    }
    return;
  }
  const double rate = std::sqrt(w2);
  for (std::size_t l = 0; l < tau.size(); ++l) {
    A[l] = std::sin(rate * tau[l]) / rate;
    B[l] = (1.0 - std::cos(rate * tau[l])) / w2;
  }
}

}  // namespace aslio
