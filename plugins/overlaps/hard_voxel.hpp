#pragma once

#include "aslio/config/binder.hpp"
#include "overlaps/voxel_overlap.hpp"

namespace aslio::plugins {

/// Share of the points whose voxel is occupied (AS-LIO (1)-(3)).
class HardVoxel final : public VoxelOverlap {
 public:
  struct Params {
    double voxel = 0.1;
    double delay = 0.1;
    std::int64_t max_points = 5000;
    std::int64_t min_points = 50;
    config::Nested<OccupancyStore> store{"flat_hash"};
  };
  static void describe(config::Binder& b, Params& p);
  HardVoxel(const Params& params, const BuildContext& context);
};

}  // namespace aslio::plugins
