#include "motion_normal.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "aslio/core/lie.hpp"

namespace aslio::pipeline {

void MotionNormal::add_prior(const ConstantMotion& motion, const ConstantMotion& known, const MotionSigma& sigma) {
  const auto add = [this](int at, const Vec3& off, double deviation) {
    const double information = 1.0 / (deviation * deviation);
    H.diagonal().segment<3>(at).array() += information;
    b.segment<3>(at) += information * off;
  };
  add(0, motion.v - known.v, sigma.v);
  add(3, motion.g - known.g, sigma.g);
  add(6, motion.e - known.e, sigma.e);
}

void MotionNormal::add_matches(std::span<const SweepPoint> points, const ConstantMotion& motion, SweepCells& cells) {
  for (const SweepPoint& p : points) {
    const Vec3 x = motion.place(p);
    const SweepCell* cell = cells.nearest(x);
    if (cell == nullptr) continue;
    const Vec3 r = x - cell->centre;
    const Vec3 weighted = cell->information * r;
    const double square = r.dot(weighted);
    if (!(square < 100.0)) continue;
    const double robust = 1.0 / std::pow(1.0 + square / 4.0, 2);  // Geman-McClure at two sigma
    Eigen::Matrix<double, 3, 9> J;
    J.leftCols<3>() = (p.t - cell->mean.t) * Mat3::Identity();
    J.middleCols<3>(3) = 0.5 * (p.t * p.t - cell->mean_square_t) * Mat3::Identity();
    J.rightCols<3>() = -(p.t * hat(p.q) - cell->mean.t * hat(cell->mean.q));
    H += robust * J.transpose() * cell->information * J;
    b += robust * J.transpose() * weighted;
  }
}

double MotionNormal::step(ConstantMotion& motion) const {
  const Vec9 step = -H.ldlt().solve(b);
  if (!step.allFinite()) return 0.0;
  motion.v += step.head<3>();
  motion.g += step.segment<3>(3);
  motion.e += step.tail<3>();
  return step.norm();
}

double agreement(std::span<const SweepPoint> points, const ConstantMotion& motion, SweepCells& cells, bool all) {
  double sum = 0;
  std::size_t n = 0;
  for (const SweepPoint& p : points) {
    const Vec3 x = motion.place(p);
    const SweepCell* cell = cells.nearest(x);
    if (cell == nullptr) continue;
    ++n;
    const Vec3 r = x - cell->centre;
    sum += std::exp(-0.5 * r.dot(cell->information * r));
  }
  return sum / static_cast<double>(std::max<std::size_t>(all ? points.size() : n, 1));
}

}  // namespace aslio::pipeline
