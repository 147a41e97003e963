#include "residuals/hybrid.hpp"

#include <algorithm>

namespace aslio::plugins {

namespace {

constexpr std::size_t kRows = 3, kMatchesPerChunk = 256;

/// A point has no normal.
bool is_plane(const Surface& surface) { return !surface.normal.isZero(0.0); }

}  // namespace

void Hybrid::describe(config::Binder& b, Params& p) {
  b.integer("k", p.k, "", {.min = 3, .max = Neighbours::kMax}, "neighbours of a plane, all of which must be found");
  b.real("max_distance", p.max_distance, "m", {.above = 0.0, .max = 1e4},
         "neighbours farther than this are not looked at");
  b.real("plane_threshold", p.plane_threshold, "m", {.above = 0.0},
         "with a neighbour farther than this from the plane there is none, and the nearest point is matched");
  b.optional_real("planarity", p.planarity, "", {.above = 0.0, .max = 1.0 / 3.0}, "any",
                  "the same with a smallest eigenvalue of the neighbours' scatter above this share of their sum "
                  "(GenZ-ICP: 0.1)");
  b.real("min_spread", p.min_spread, "", {.min = 0.0, .below = 1.0},
         "the same with a ratio of the second to the first standard deviation of the neighbours below this");
  b.real("gate", p.gate, "1/m", {.min = 0.0}, "a plane takes part while range > gate * r^2 (0: always)");
  b.real("point_sigma", p.point_sigma, "m", {.above = 0.0, .max = 10.0},
         "standard deviation of a component of the vector from the nearest point: about the spacing of the map over "
         "root 12");
  b.real("point_gate", p.point_gate, "", {.min = 0.0},
         "a point takes part while |r| < point_gate * point_sigma (0: always)");
  b.choice("point_kernel", p.point_kernel,
           {{"none", PointToPoint::Kernel::none}, {"geman_mcclure", PointToPoint::Kernel::geman_mcclure}},
           "robust weight of points: none, or (point_sigma / (point_sigma + r^2))^2 with both in metres (GenZ-ICP)");
  b.choice("weighting", p.weighting, {{"none", Weighting::none}, {"share", Weighting::share}},
           "weight of a match: 1, or the share of planes for a plane and the rest for a point (GenZ-ICP)");
}

Hybrid::Hybrid(const Params& params, const BuildContext& context)
    : point_sigma_(params.point_sigma),
      weighting_(params.weighting),
      planes_({.k = params.k,
               .max_distance = params.max_distance,
               .plane_threshold = params.plane_threshold,
               .planarity = params.planarity,
               .min_spread = params.min_spread,
               .gate = params.gate},
              context),
      points_({.max_distance = params.max_distance, .gate = params.point_gate, .kernel = params.point_kernel}, context),
      exec_(context.exec) {}

/// eq. RES-6.
void Hybrid::fit(std::span<const Vec3> queries, const Neighbours& neighbours, std::span<Surface> out) {
  planes_.fit(queries, neighbours, out);
  std::size_t planes = 0, points = 0;
  for (std::size_t i = 0; i < queries.size(); ++i) {
    if (out[i].valid) {
      ++planes;
    } else {
      points_.fit_one(queries[i], neighbours, i, out[i]);
      points += out[i].valid ? 1 : 0;
    }
  }
  if (weighting_ == Weighting::none || planes + points == 0) return;
  const double alpha = static_cast<double>(planes) / static_cast<double>(planes + points);
  for (Surface& surface : out) surface.quality = is_plane(surface) ? alpha : 1.0 - alpha;
}

void Hybrid::evaluate(std::span<const Vec3> world, std::span<const float> range, std::span<const Surface> surfaces,
                      double sigma, std::span<ResidualRow> rows) {
  exec_.for_ranges(world.size(), kMatchesPerChunk, [&](std::size_t begin, std::size_t end, std::size_t) {
    for (std::size_t i = begin; i < end; ++i) {
      const auto own = rows.subspan(kRows * i, kRows);
      std::fill(own.begin(), own.end(), ResidualRow{});
      if (!surfaces[i].valid) continue;
      if (is_plane(surfaces[i])) {
        own[0] = planes_.row_of(world[i], range[i], surfaces[i], sigma);
      } else {
        points_.rows_of(world[i], surfaces[i], point_sigma_, own);
      }
    }
  });
}

}  // namespace aslio::plugins
