#include "maps/staggered_planes.hpp"

#include <algorithm>
#include <numeric>

namespace aslio::plugins {

void StaggeredPlanes::describe(config::Binder& b, Params& p) {
  VoxelPlane::describe(b, p.planes);
  b.integer("grids", p.grids, "", {.min = 1, .max = 8},
            "grids of voxels, each moved by an equal part of a voxel. Time and memory of the map grow with their "
            "number, queries cost the same");
}

StaggeredPlanes::StaggeredPlanes(const Params& params, const BuildContext& context) {
  // An odd number of parts: the finer voxels of two grids coincide on no level, either. eq. MAP-5
  const std::int64_t parts = params.grids | 1;
  for (std::int64_t i = 0; i < params.grids; ++i) {
    const double phase = static_cast<double>(i) / static_cast<double>(parts);
    grids_.push_back(std::make_unique<VoxelPlane>(params.planes, context, phase));
  }
}

void StaggeredPlanes::correspond(std::span<const Vec3> queries, const MapQuery& query, Neighbours& out) const {
  grids_.front()->correspond(queries, query, out);
}

void StaggeredPlanes::surfaces(std::span<const Vec3> queries, const MapQuery& query, std::span<Surface> out) const {
  for (std::size_t i = 0; i < grids_.size(); ++i) grids_[i]->surfaces(queries, query, out, {i, grids_.size()});
}

InsertCount StaggeredPlanes::insert(std::span<const WorldPoint> points, std::uint32_t stamp) {
  InsertCount most{points.size(), 0};
  for (const auto& grid : grids_) most.inserted = std::max(most.inserted, grid->insert(points, stamp).inserted);
  return most;
}

void StaggeredPlanes::set_noise_scale(double scale) {
  for (const auto& grid : grids_) grid->set_noise_scale(scale);
}

void StaggeredPlanes::trim(const Vec3& centre_W) {
  for (const auto& grid : grids_) grid->trim(centre_W);
}

void StaggeredPlanes::clear() {
  for (const auto& grid : grids_) grid->clear();
}

std::size_t StaggeredPlanes::memory_bytes() const {
  return std::accumulate(grids_.begin(), grids_.end(), std::size_t{0},
                         [](std::size_t sum, const auto& grid) { return sum + grid->memory_bytes(); });
}

}  // namespace aslio::plugins
