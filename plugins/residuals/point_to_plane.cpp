#include "residuals/point_to_plane.hpp"

#include <algorithm>
#include <cmath>

#include "residuals/coincident.hpp"
#include "residuals/plane_fit.hpp"

namespace aslio::plugins {

namespace {
constexpr std::size_t kMatchesPerChunk = 16 * PlaneBatch::kWidth;
}  // namespace

void PointToPlane::describe(config::Binder& b, Params& p) {
  b.choice("planes", p.planes, {{"neighbours", Planes::neighbours}, {"map", Planes::map}},
           "where planes come from: fitted to the nearest points of the map, or kept by the map (then k, max_distance, "
           "plane_threshold and min_spread are ignored)");
  b.integer("k", p.k, "", {.min = 3, .max = Neighbours::kMax}, "neighbours of a plane, all of which must be found");
  b.integer("k_min", p.k_min, "", {.min = 0, .max = Neighbours::kMax},
            "with so many found, a plane is fitted to those (Faster-LIO: 3; 0: all k must be found)");
  b.require(p.k_min == 0 || (p.k_min >= 3 && p.k_min <= p.k), "k_min", "must be 0, or from 3 to k");
  b.real("max_distance", p.max_distance, "m", {.above = 0.0, .max = 1e4},
         "neighbours farther than this are not looked at");
  b.real("plane_threshold", p.plane_threshold, "m", {.above = 0.0},
         "a neighbour farther than this from the plane refuses the plane");
  b.optional_real("planarity", p.planarity, "", {.above = 0.0, .max = 1.0 / 3.0}, "any",
                  "a smallest eigenvalue of the neighbours' scatter above this share of their sum refuses the plane "
                  "(GenZ-ICP)");
  b.real("min_spread", p.min_spread, "", {.min = 0.0, .below = 1.0},
         "least ratio of the second to the first standard deviation of the neighbours (collinear ones span no plane)");
  b.real("gate", p.gate, "1/m", {.min = 0.0}, "a row takes part while range > gate * r^2 (0: always)");
  b.optional_real("max_residual", p.max_residual, "m", {.above = 0.0, .max = 100.0}, "any",
                  "a row takes part while |r| is at most this, whatever the range");
  b.choice("weighting", p.weighting, {{"none", Weighting::none}, {"planarity", Weighting::planarity}},
           "planes: neighbours: weight of a plane: 1, or how flat its neighbours lie and how near the nearest is "
           "(CT-ICP)");
  b.choice("kernel", p.kernel, {{"none", Kernel::none}, {"huber", Kernel::huber}, {"cauchy", Kernel::cauchy}},
           "robust weight of large residuals");
  b.real("kernel_width", p.kernel_width, "m", {.above = 0.0}, "residual at which the kernel sets in");
  b.real("plane_sigma", p.plane_sigma, "m", {.min = 0.0, .max = 1.0},
         "planes: map: standard deviation of the error that all matches of one plane share: each of N matches has the "
         "variance sigma^2 + N plane_sigma^2");
}

PointToPlane::PointToPlane(const Params& params, const BuildContext& context)
    : params_(params), kernel_width_(params.kernel_width), exec_(context.exec) {}

/// eq. NOI-2.
void PointToPlane::set_noise_scale(double scale) { kernel_width_ = params_.kernel_width * scale; }

MapQuery PointToPlane::query() const {
  MapQuery query;
  query.k = static_cast<int>(params_.k);
  query.max_distance = params_.max_distance;
  return query;
}

void PointToPlane::fit(std::span<const Vec3> queries, const Neighbours& neighbours, std::span<Surface> out) {
  const auto k = static_cast<std::size_t>(params_.k);
  const std::size_t fewest = params_.k_min == 0 ? k : static_cast<std::size_t>(params_.k_min);
  exec_.for_ranges(queries.size(), kMatchesPerChunk, [&](std::size_t begin, std::size_t end, std::size_t) {
    for (std::size_t i = begin; i < end; i += PlaneBatch::kWidth) {
      const std::size_t last = std::min(i + PlaneBatch::kWidth, end);
      std::fill(out.begin() + static_cast<std::ptrdiff_t>(i), out.begin() + static_cast<std::ptrdiff_t>(last),
                Surface{});
      for (std::size_t count = fewest; count <= k; ++count) fit_batch(queries, neighbours, i, last, count, out);
    }
  });
}

/// Whether the plane of a query is fitted to exactly `count` neighbours: as many as were found, at most k.
bool PointToPlane::fits(const Neighbours& neighbours, std::size_t query, std::size_t count) const {
  const auto k = static_cast<std::size_t>(params_.k);
  if (neighbours.k() < k) return false;
  return std::min<std::size_t>(neighbours.count[query], k) == count;
}

void PointToPlane::fit_batch(std::span<const Vec3> queries, const Neighbours& neighbours, std::size_t begin,
                             std::size_t end, std::size_t count, std::span<Surface> out) const {
  PlaneBatch batch;
  bool any = false;
  for (std::size_t lane = 0; lane < PlaneBatch::kWidth; ++lane) {
    const std::size_t i = begin + lane;
    const bool complete = i < end && fits(neighbours, i, count);
    any = any || complete;
    for (std::size_t j = 0; j < count; ++j) {
      const Eigen::Vector3f offset = complete ? neighbours.offset(i, j) : Eigen::Vector3f::Zero();
      batch.x[j][lane] = static_cast<double>(offset.x());
      batch.y[j][lane] = static_cast<double>(offset.y());
      batch.z[j][lane] = static_cast<double>(offset.z());
    }
  }
  if (!any) return;
  batch.fit(count);
  for (std::size_t i = begin; i < end; ++i) {
    const std::size_t lane = i - begin;
    if (!fits(neighbours, i, count)) continue;
    Surface& surface = out[i];
    const bool spread = batch.largest[lane] > kCoincident * kCoincident &&
                        batch.middle[lane] > params_.min_spread * params_.min_spread * batch.largest[lane];
    const Vec3 normal(batch.normal_x[lane], batch.normal_y[lane], batch.normal_z[lane]);
    const double sum = batch.smallest[lane] + batch.middle[lane] + batch.largest[lane];
    if (params_.planarity && !(batch.smallest[lane] <= *params_.planarity * sum)) continue;
    if (!spread || !(batch.farthest[lane] <= params_.plane_threshold) || !normal.allFinite()) continue;
    surface.normal = normal;
    surface.anchor = queries[i] + Vec3(batch.mean_x[lane], batch.mean_y[lane], batch.mean_z[lane]);
    if (params_.weighting == Weighting::planarity) {  // eq. RES-3
      const double largest = std::sqrt(batch.largest[lane]), middle = std::sqrt(std::max(0.0, batch.middle[lane])),
                   smallest = std::sqrt(std::max(0.0, batch.smallest[lane]));
      const double flat = (middle - smallest) / largest;
      const double nearest = std::sqrt(static_cast<double>(neighbours.squared[i * neighbours.k()]));
      surface.quality = 0.9 * flat * flat + 0.1 * std::exp(-nearest / (0.3 * static_cast<double>(params_.k)));
    }
    surface.valid = true;
  }
}

double PointToPlane::weight(double r) const {
  const double scaled = std::abs(r) / kernel_width_;
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

// `inline` for speed: asked for every point at every iteration.
inline ResidualRow PointToPlane::row(const Vec3& world, float range, const Surface& surface, double variance) const {
  const double r = surface.normal.dot(world - surface.anchor);
  if (!std::isfinite(r)) return {};
  ResidualRow out{r, surface.normal, 0.0};
  const bool inside = params_.gate == 0 || static_cast<double>(range) > params_.gate * r * r;
  const bool near = !params_.max_residual || std::abs(r) <= *params_.max_residual;
  if (!inside || !near) return out;
  // eq. RES-5
  if (counts_shared_matches()) variance += surface.shared_matches * (params_.plane_sigma * params_.plane_sigma);
  out.information = surface.quality * weight(r) * (1.0 / variance);
  return out;
}

ResidualRow PointToPlane::row_of(const Vec3& world, float range, const Surface& surface, double sigma) const {
  return row(world, range, surface, sigma * sigma);
}

void PointToPlane::evaluate(std::span<const Vec3> world, std::span<const float> range,
                            std::span<const Surface> surfaces, double sigma, std::span<ResidualRow> rows) {
  const double variance = sigma * sigma;
  exec_.for_ranges(world.size(), 4 * kMatchesPerChunk, [&](std::size_t begin, std::size_t end, std::size_t) {
    for (std::size_t i = begin; i < end; ++i) {
      rows[i] = surfaces[i].valid ? row(world[i], range[i], surfaces[i], variance) : ResidualRow{};
    }
  });
}

}  // namespace aslio::plugins
