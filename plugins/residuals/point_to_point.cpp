#include "residuals/point_to_point.hpp"

#include <cmath>

namespace aslio::plugins {

namespace {
constexpr std::size_t kPairsPerChunk = 1024;
}

void PointToPoint::describe(config::Binder& b, Params& p) {
  b.real("max_distance", p.max_distance, "m", {.above = 0.0, .max = 1e4}, "a point farther than this is not looked at");
  b.real("gate", p.gate, "", {.min = 0.0}, "a match takes part while |r| < gate * sigma (0: always)");
  b.choice("kernel", p.kernel, {{"none", Kernel::none}, {"geman_mcclure", Kernel::geman_mcclure}},
           "robust weight: none, or (sigma / (sigma + r^2))^2 with both in metres (KISS-ICP)");
}

PointToPoint::PointToPoint(const Params& params, const BuildContext& context) : params_(params), exec_(context.exec) {}

void PointToPoint::fit(std::span<const Vec3> queries, const Neighbours& neighbours, std::span<Surface> out) {
  for (std::size_t i = 0; i < queries.size(); ++i) {
    out[i] = {};
    if (neighbours.count[i] == 0) continue;
    out[i].anchor = queries[i] + neighbours.offset(i, 0).cast<double>();
    out[i].valid = true;
  }
}

void PointToPoint::evaluate(std::span<const Vec3> world, std::span<const float>, std::span<const Surface> surfaces,
                            double sigma, std::span<ResidualRow> rows) {
  const double information = 1.0 / (sigma * sigma);
  const double farthest = params_.gate * sigma;
  exec_.for_ranges(world.size(), kPairsPerChunk, [&](std::size_t begin, std::size_t end, std::size_t) {
    for (std::size_t i = begin; i < end; ++i) {
      for (std::size_t axis = 0; axis < 3; ++axis) rows[3 * i + axis] = {};
      if (!surfaces[i].valid) continue;
      const Vec3 r = world[i] - surfaces[i].anchor;
      const double squared = r.squaredNorm();
      if (!std::isfinite(squared)) continue;
      const bool inside = params_.gate == 0 || squared < farthest * farthest;
      const double bell = params_.kernel == Kernel::none ? 1.0 : sigma / (sigma + squared);
      const double known = inside ? bell * bell * information : 0.0;
      for (int axis = 0; axis < 3; ++axis) {
        rows[3 * i + static_cast<std::size_t>(axis)] = {r[axis], Vec3::Unit(axis), known};
      }
    }
  });
}

}  // namespace aslio::plugins
