#include "residuals/point_to_line.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <cmath>

#include "residuals/coincident.hpp"

namespace aslio::plugins {

namespace {
constexpr std::size_t kLinesPerChunk = 128;
}  // namespace

void PointToLine::describe(config::Binder& b, Params& p) {
  b.integer("k", p.k, "", {.min = 2, .max = Neighbours::kMax}, "neighbours of a line, all of which must be found");
  b.real("max_distance", p.max_distance, "m", {.above = 0.0, .max = 1e4},
         "neighbours farther than this are not looked at");
  b.real("elongation", p.elongation, "", {.min = 1.0},
         "least ratio of the largest to the middle eigenvalue of the neighbours' scatter");
  b.real("gate", p.gate, "1/m", {.min = 0.0}, "a match takes part while range > gate * r^2 (0: always)");
  b.choice("kernel", p.kernel, {{"none", Kernel::none}, {"huber", Kernel::huber}, {"cauchy", Kernel::cauchy}},
           "robust weight of large distances");
  b.real("kernel_width", p.kernel_width, "m", {.above = 0.0}, "distance at which the kernel sets in");
}

PointToLine::PointToLine(const Params& params, const BuildContext& context) : params_(params), exec_(context.exec) {}

MapQuery PointToLine::query() const { return {.k = static_cast<int>(params_.k), .max_distance = params_.max_distance}; }

/// eq. RES-4
Surface PointToLine::line_through(const Vec3& query, const Neighbours& neighbours, std::size_t i) const {
  const auto k = static_cast<std::size_t>(params_.k);
  if (neighbours.k() < k || neighbours.count[i] < k) return {};
  Vec3 mean = Vec3::Zero();
  for (std::size_t j = 0; j < k; ++j) mean += neighbours.offset(i, j).cast<double>();
  mean /= static_cast<double>(k);
  Mat3 scatter = Mat3::Zero();
  for (std::size_t j = 0; j < k; ++j) {
    const Vec3 d = neighbours.offset(i, j).cast<double>() - mean;
    scatter += d * d.transpose();
  }
  scatter /= static_cast<double>(k);
  if (!scatter.allFinite()) return {};
  Eigen::SelfAdjointEigenSolver<Mat3> solver;
  solver.computeDirect(scatter);
  const Vec3& values = solver.eigenvalues();
  if (values[2] <= kCoincident * kCoincident || !(values[2] > params_.elongation * values[1])) return {};
  return {.normal = solver.eigenvectors().col(2), .anchor = query + mean, .valid = true};
}

void PointToLine::fit(std::span<const Vec3> queries, const Neighbours& neighbours, std::span<Surface> out) {
  exec_.for_ranges(queries.size(), kLinesPerChunk, [&](std::size_t begin, std::size_t end, std::size_t) {
    for (std::size_t i = begin; i < end; ++i) out[i] = line_through(queries[i], neighbours, i);
  });
}

double PointToLine::weight(double distance) const {
  const double scaled = distance / params_.kernel_width;
  switch (params_.kernel) {
    case Kernel::none:
      return 1.0;
    case Kernel::huber:
      return scaled <= 1.0 ? 1.0 : 1.0 / scaled;
    case Kernel::cauchy:
      return 1.0 / (1.0 + scaled * scaled);
  }
  return 1.0;
}

void PointToLine::evaluate(std::span<const Vec3> world, std::span<const float> range, std::span<const Surface> surfaces,
                           double sigma, std::span<ResidualRow> rows) {
  const double information = 1.0 / (sigma * sigma);
  exec_.for_ranges(world.size(), kLinesPerChunk, [&](std::size_t begin, std::size_t end, std::size_t) {
    for (std::size_t i = begin; i < end; ++i) {
      rows[2 * i] = rows[2 * i + 1] = {};
      const Surface& line = surfaces[i];
      if (!line.valid) continue;
      const Vec3 off = world[i] - line.anchor;
      const Vec3 u = line.normal.unitOrthogonal(), v = line.normal.cross(u);
      const double a = u.dot(off), b = v.dot(off), squared = a * a + b * b;
      const bool inside = params_.gate == 0 || static_cast<double>(range[i]) > params_.gate * squared;
      if (!std::isfinite(squared)) continue;
      const double known = inside ? line.quality * weight(std::sqrt(squared)) * information : 0.0;
      rows[2 * i] = {a, u, known};
      rows[2 * i + 1] = {b, v, known};
    }
  });
}

}  // namespace aslio::plugins
