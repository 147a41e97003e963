#include "aslio/plugin/registry.hpp"
#include "samplers/budget.hpp"
#include "samplers/controlled_voxel.hpp"
#include "samplers/curvature_features.hpp"
#include "samplers/range.hpp"
#include "samplers/rate.hpp"
#include "samplers/stride.hpp"
#include "samplers/voxel.hpp"

namespace aslio::plugins {

void register_samplers(plugin::Registry<Sampler>& registry);

void register_samplers(plugin::Registry<Sampler>& registry) {
  registry.add<BudgetSampler>("budget", "keeps at most so many points of a window");
  registry.add<ControlledVoxel>("controlled_voxel", "voxel whose leaf holds the number of points left (GenZ-LIO)");
  registry.add<CurvatureFeatures>("curvature_features", "keeps points on edges and planes, and marks which (LOAM)");
  registry.add<RangeSampler>("range", "drops points nearer or farther than two ranges");
  registry.add<RateSampler>("rate", "keeps at most so many points of a second of the stream");
  registry.add<StrideSampler>("stride", "keeps every k-th point of the stream, or a share of its firings");
  registry.add<VoxelSampler>("voxel", "keeps one point per cube of the de-skewed frame");
}

}  // namespace aslio::plugins
