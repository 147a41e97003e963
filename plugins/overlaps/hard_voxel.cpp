#include "overlaps/hard_voxel.hpp"

namespace aslio::plugins {

HardVoxel::HardVoxel(const Params& params, const BuildContext& context)
    : VoxelOverlap(params, LayerMetric::chebyshev, {1.0}, context) {}

}  // namespace aslio::plugins
