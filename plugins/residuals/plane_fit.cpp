#include "residuals/plane_fit.hpp"

#include <algorithm>
#include <cmath>

namespace aslio::plugins {

namespace {

constexpr std::size_t W = PlaneBatch::kWidth;

/// Scatter matrices / k (upper triangles) about the mean.
struct Scatter {
  PlaneBatch::Row xx, xy, xz, yy, yz, zz;
};

void mean(const PlaneBatch::Row* rows, std::size_t k, PlaneBatch::Row& out) {
  const double share = 1.0 / static_cast<double>(k);
  for (std::size_t i = 0; i < W; ++i) out[i] = 0;
  for (std::size_t j = 0; j < k; ++j) {
    for (std::size_t i = 0; i < W; ++i) out[i] += rows[j][i];
  }
  for (std::size_t i = 0; i < W; ++i) out[i] *= share;
}

void scatter(const PlaneBatch& b, std::size_t k, Scatter& s) {
  const double share = 1.0 / static_cast<double>(k);
  s = {};
  for (std::size_t j = 0; j < k; ++j) {
    for (std::size_t i = 0; i < W; ++i) {
      const double x = b.x[j][i] - b.mean_x[i], y = b.y[j][i] - b.mean_y[i], z = b.z[j][i] - b.mean_z[i];
      s.xx[i] += share * x * x;
      s.xy[i] += share * x * y;
      s.xz[i] += share * x * z;
      s.yy[i] += share * y * y;
      s.yz[i] += share * y * z;
      s.zz[i] += share * z * z;
    }
  }
}

/// Eigenvalues and normals. Newton on det(S - e I) from e = 0 climbs monotonically to the smallest root (a cubic with
/// real roots is convex or concave left of them). Four steps are exact to 1e-6 while the smallest is below 0.3 of the
/// middle one; near it (0.7: up to 8 degrees) the points lie in no plane to speak of.
void normals(PlaneBatch& b, const Scatter& s) {
  for (std::size_t i = 0; i < W; ++i) {
    const double trace = s.xx[i] + s.yy[i] + s.zz[i];
    const double minors = s.xx[i] * s.yy[i] - s.xy[i] * s.xy[i] + s.xx[i] * s.zz[i] - s.xz[i] * s.xz[i] +
                          s.yy[i] * s.zz[i] - s.yz[i] * s.yz[i];
    const double det = s.xx[i] * (s.yy[i] * s.zz[i] - s.yz[i] * s.yz[i]) -
                       s.xy[i] * (s.xy[i] * s.zz[i] - s.yz[i] * s.xz[i]) +
                       s.xz[i] * (s.xy[i] * s.yz[i] - s.yy[i] * s.xz[i]);
    double e = 0;
    for (int step = 0; step < 4; ++step) {
      const double value = det - e * (minors - e * (trace - e));
      const double slope = minors - e * (2 * trace - 3 * e);
      e += std::max(0.0, value) / std::max(slope, 1e-300);
    }
    const double sum = trace - e, product = minors - e * sum;  // of the other two eigenvalues
    const double root = std::sqrt(std::max(0.0, 0.25 * sum * sum - product));
    b.smallest[i] = e;
    b.largest[i] = 0.5 * sum + root;
    b.middle[i] = 0.5 * sum - root;
    const double xx = s.xx[i] - e, yy = s.yy[i] - e, zz = s.zz[i] - e;
    // Every column of the adjugate is a multiple of the normal; that of the largest diagonal entry is the longest.
    const double a_xx = yy * zz - s.yz[i] * s.yz[i], a_yy = xx * zz - s.xz[i] * s.xz[i],
                 a_zz = xx * yy - s.xy[i] * s.xy[i];
    const double a_xy = s.xz[i] * s.yz[i] - s.xy[i] * zz, a_xz = s.xy[i] * s.yz[i] - s.xz[i] * yy,
                 a_yz = s.xy[i] * s.xz[i] - s.yz[i] * xx;
    const bool first = a_xx >= a_yy && a_xx >= a_zz, second = a_yy >= a_zz;
    const double x = first ? a_xx : second ? a_xy : a_xz;
    const double y = first ? a_xy : second ? a_yy : a_yz;
    const double z = first ? a_xz : second ? a_yz : a_zz;
    const double scale = 1.0 / std::sqrt(x * x + y * y + z * z);
    b.normal_x[i] = x * scale;
    b.normal_y[i] = y * scale;
    b.normal_z[i] = z * scale;
  }
}

}  // namespace

void PlaneBatch::fit(std::size_t k) {
  Scatter s;
  mean(x, k, mean_x);
  mean(y, k, mean_y);
  mean(z, k, mean_z);
  scatter(*this, k, s);
  normals(*this, s);
  for (std::size_t i = 0; i < W; ++i) farthest[i] = 0;
  for (std::size_t j = 0; j < k; ++j) {
    for (std::size_t i = 0; i < W; ++i) {
      const double distance = normal_x[i] * (x[j][i] - mean_x[i]) + normal_y[i] * (y[j][i] - mean_y[i]) +
                              normal_z[i] * (z[j][i] - mean_z[i]);
      farthest[i] = std::max(farthest[i], std::abs(distance));
    }
  }
}

}  // namespace aslio::plugins
