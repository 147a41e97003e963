#pragma once

#include "overlaps/voxel_overlap.hpp"

namespace aslio::plugins {

/// Overlap with a soft margin: a point near an occupied voxel counts in part, the less the more layers it is away
/// (AS-LIO (4)-(6)). The reach of the margin is layers * voxel, or margin_m rounded to whole voxels.
class SoftVoxel final : public VoxelOverlap {
 public:
  enum class Beta : std::uint8_t { linear, geometric, list };
  struct Params : VoxelOverlap::Params {
    std::optional<double> layers;
    std::optional<double> margin_m;
    LayerMetric metric = LayerMetric::chebyshev;
    Beta beta = Beta::linear;
    double gamma = 0.5;
    std::vector<double> beta_list;
  };
  static constexpr int kDefaultLayers = 3;  ///< d of AS-LIO
  static void describe(config::Binder& b, Params& p);
  SoftVoxel(const Params& params, const BuildContext& context);

  /// Layers beyond the occupied one.
  static int depth(const Params& p);
  /// beta_0 .. beta_d.
  static std::vector<double> weights(const Params& p);
};

}  // namespace aslio::plugins
