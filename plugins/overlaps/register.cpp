#include "aslio/plugin/registry.hpp"
#include "overlaps/hard_voxel.hpp"
#include "overlaps/soft_voxel.hpp"

namespace aslio::plugins {

void register_overlaps(plugin::Registry<OverlapMetric>& registry);

void register_overlaps(plugin::Registry<OverlapMetric>& registry) {
  registry.add<HardVoxel>("hard_voxel", "Share of the points whose voxel is occupied.");
  registry.add<SoftVoxel>("soft_voxel", "Overlap with a soft margin of voxel layers (AS-LIO).");
}

}  // namespace aslio::plugins
