#include "overlaps/hard_voxel.hpp"

namespace aslio::plugins {

void HardVoxel::describe(config::Binder& b, Params& p) {
  b.real("voxel", p.voxel, "m", {.min = 0.001, .max = 100.0}, "edge of a voxel");
  b.real("delay", p.delay, "s", {.min = 0.0, .max = 100.0},
         "points count as known this long after they were merged (0: at once, which makes the score rise by itself)");
  b.integer("max_points", p.max_points, "", {.min = 0}, "points of a frame that are scored, spread evenly (0: all)");
  b.integer("min_points", p.min_points, "", {.min = 1}, "below this many points the score is undefined");
  b.stage("store", p.store, "what holds the occupied voxels");
}

HardVoxel::HardVoxel(const Params& p, const BuildContext& context)
    : VoxelOverlap({.voxel = p.voxel,
                    .beta = {1.0},
                    .delay = to_ns(p.delay),
                    .max_points = static_cast<std::size_t>(p.max_points),
                    .min_points = static_cast<std::size_t>(p.min_points),
                    .order_seed = context.order_seed},
                   p.store.make(context), p.store.make(context)) {}

}  // namespace aslio::plugins
