#include "maps/staggered_planes.hpp"

namespace aslio::plugins {

void StaggeredPlanes::describe(config::Binder& b, Params& p) {
  VoxelPlane::describe(b, p.planes);
  b.integer("grids", p.grids, "", {.min = 1, .max = 8},
            "grids of voxels, each moved by an equal part of a voxel. Time and memory of the map grow with their "
            "number, queries cost the same");
}

StaggeredPlanes::StaggeredPlanes(const Params& params, const BuildContext& context)
    : grids_(params.grids, params.planes, context) {}

}  // namespace aslio::plugins
