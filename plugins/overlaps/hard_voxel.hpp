#pragma once

#include "overlaps/voxel_overlap.hpp"

namespace aslio::plugins {

/// Share of the points whose voxel is occupied (AS-LIO (1)-(3)).
class HardVoxel final : public VoxelOverlap {
 public:
  HardVoxel(const Params& params, const BuildContext& context);
};

}  // namespace aslio::plugins
