#include "residuals/point_to_point.hpp"

#include <algorithm>
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

void PointToPoint::fit_one(const Vec3& query, const Neighbours& neighbours, std::size_t i, Surface& out) const {
  out = {};
  if (neighbours.count[i] == 0) return;
  out.anchor = query + neighbours.offset(i, 0).cast<double>();
  out.valid = true;
}

void PointToPoint::fit(std::span<const Vec3> queries, const Neighbours& neighbours, std::span<Surface> out) {
  for (std::size_t i = 0; i < queries.size(); ++i) fit_one(queries[i], neighbours, i, out[i]);
}

void PointToPoint::rows_of(const Vec3& world, const Surface& surface, double sigma, std::span<ResidualRow> rows) const {
  for (ResidualRow& row : rows) row = {};
  const Vec3 r = world - surface.anchor;
  const double squared = r.squaredNorm(), farthest = params_.gate * sigma;
  if (!std::isfinite(squared)) return;
  const bool inside = params_.gate == 0 || squared < farthest * farthest;
  const double bell = params_.kernel == Kernel::none ? 1.0 : sigma / (sigma + squared);
  const double information = 1.0 / (sigma * sigma);
  const double known = inside ? surface.quality * bell * bell * information : 0.0;
  for (int axis = 0; axis < 3; ++axis) rows[static_cast<std::size_t>(axis)] = {r[axis], Vec3::Unit(axis), known};
}

void PointToPoint::evaluate(std::span<const Vec3> world, std::span<const float>, std::span<const Surface> surfaces,
                            double sigma, std::span<ResidualRow> rows) {
  exec_.for_ranges(world.size(), kPairsPerChunk, [&](std::size_t begin, std::size_t end, std::size_t) {
    for (std::size_t i = begin; i < end; ++i) {
      const auto own = rows.subspan(3 * i, 3);
      if (surfaces[i].valid) {
        rows_of(world[i], surfaces[i], sigma, own);
      } else {
        std::fill(own.begin(), own.end(), ResidualRow{});
      }
    }
  });
}

}  // namespace aslio::plugins
