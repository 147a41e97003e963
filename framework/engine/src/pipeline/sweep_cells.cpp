#include "sweep_cells.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>

namespace aslio::pipeline {

namespace {

constexpr std::uint32_t kMinCellPoints = 5;  // that say how a surface lies

}  // namespace

void SweepCells::build(std::span<const SweepPoint> points, const ConstantMotion& motion, double edge, double softness) {
  inverse_edge_ = 1.0 / edge;
  softness_ = softness;
  up_ = motion.g.squaredNorm() > 0 ? Vec3(-motion.g.normalized()) : Vec3(Vec3::UnitZ());
  index_.clear();
  cells_.clear();
  for (const SweepPoint& p : points) {
    const Vec3 x = motion.place(p);
    const auto cell = cell_of(x, inverse_edge_);
    if (!cell) continue;
    const std::uint64_t key = pack(*cell);
    std::uint32_t number = index_.find(key);
    if (number == CellIndex::kNone) {
      number = static_cast<std::uint32_t>(cells_.size());
      index_.insert(key, number);
      cells_.emplace_back();
    }
    SweepCell& into = cells_[number];
    ++into.count;
    into.mean.q += p.q;
    into.mean.y += p.y;
    into.mean.t += p.t;
    into.mean_square_t += p.t * p.t;
    const Vec3 deviation = x - into.centre;  // Welford's running mean and scatter
    into.centre += deviation / into.count;
    into.scatter += deviation * (x - into.centre).transpose();
  }
  for (SweepCell& cell : cells_) {
    const double n = cell.count;
    cell.mean.q /= n;
    cell.mean.y /= n;
    cell.mean.t /= n;
    cell.mean_square_t /= n;
  }
}

void SweepCells::look_at(SweepCell& cell) const {
  constexpr double upright = 0.85;           // cosine: posts and trunks bind, lines of the scanner do not
  constexpr double line = 0.1, plane = 0.2;  // spreads of a line and of a plane, relative to the next larger one
  cell.shape = SweepCell::Shape::loose;
  if (cell.count < kMinCellPoints) return;
  Eigen::SelfAdjointEigenSolver<Mat3> solver;
  solver.computeDirect(cell.scatter / cell.count);
  const Vec3 spread = solver.eigenvalues().cwiseMax(0.0);
  const Mat3& axes = solver.eigenvectors();
  Vec3 inverse = (spread.array() + softness_ * softness_).inverse();
  if (spread[1] < line * spread[2]) {
    if (std::abs(axes.col(2).dot(up_)) < upright) return;
    inverse[2] = 0;
  } else if (spread[0] < plane * spread[1]) {
    inverse[1] = inverse[2] = 0;
  }
  cell.information = axes * inverse.asDiagonal() * axes.transpose();
  cell.shape = SweepCell::Shape::binds;
}

const SweepCell* SweepCells::nearest(const Vec3& x) {
  const auto home = cell_of(x, inverse_edge_);
  if (!home) return nullptr;
  SweepCell* best = nullptr;
  double least = std::numeric_limits<double>::infinity();
  for (std::int32_t dx = -1; dx <= 1; ++dx) {
    for (std::int32_t dy = -1; dy <= 1; ++dy) {
      for (std::int32_t dz = -1; dz <= 1; ++dz) {
        const std::uint32_t number = index_.find(pack({home->x + dx, home->y + dy, home->z + dz}));
        if (number == CellIndex::kNone) continue;
        SweepCell& cell = cells_[number];
        const double distance = (cell.centre - x).squaredNorm();
        if (distance >= least) continue;
        if (cell.shape == SweepCell::Shape::unknown) look_at(cell);
        if (cell.shape == SweepCell::Shape::loose) continue;
        least = distance;
        best = &cell;
      }
    }
  }
  return best;
}

void OccupiedCells::build(std::span<const SweepPoint> points, const ConstantMotion& motion, double edge) {
  inverse_edge_ = 1.0 / edge;
  index_.clear();
  for (const SweepPoint& p : points) {
    const auto cell = cell_of(motion.place(p), inverse_edge_);
    if (!cell) continue;
    const std::uint64_t key = pack(*cell);
    if (index_.find(key) == CellIndex::kNone) index_.insert(key, 0);
  }
}

bool OccupiedCells::occupied(const Vec3& x) const {
  const auto cell = cell_of(x, inverse_edge_);
  return cell && index_.find(pack(*cell)) != CellIndex::kNone;
}

}  // namespace aslio::pipeline
