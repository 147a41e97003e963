#pragma once
/// `controlled_voxel`: a voxel filter whose leaf follows the number of points that it leaves (GenZ-LIO, arXiv
/// 2603.16273; docs/equations.md SMP-2).

#include <array>
#include <optional>
#include <vector>

#include "aslio/stages/build_context.hpp"
#include "aslio/stages/sampler.hpp"
#include "aslio/toolkit/point_uses.hpp"
#include "samplers/voxel.hpp"

namespace aslio::plugins {

/// What a batch left, in units that do not depend on how long its window was.
struct VoxelCount {
  double periods = 0;     ///< length of the window in periods of the controller
  double per_period = 0;  ///< points left, for one period
  double range = 0;       ///< median range of the points left [m]
};

/// The leaf that the counts of past windows ask for (SMP-2). Deterministic; no allocation.
class LeafController {
 public:
  struct Params {
    double leaf = 0.25, min_leaf = 0.05, max_leaf = 2.0;  ///< [m]
    double min_points = 1000, max_points = 4000;          ///< for one period
    double full_scale = 30.0;                             ///< [m]
    double exponent = 2.0;
    double scale_periods = 5.0;
    double p_gain_min = 5e-6, p_gain_max = 5e-5;  ///< [m]
    double d_gain_min = 5e-8, d_gain_max = 5e-7;  ///< [m]
    double error_sensitivity = 0.1, error_rate_sensitivity = 0.2;
  };

  explicit LeafController(const Params& params) : params_(params), leaf_(params.leaf) {}

  /// Edge of the cubes of the next window [m], within [min_leaf, max_leaf].
  double leaf() const { return leaf_; }
  /// Points for one period that the last windows ask for, within [min_points, max_points].
  double set_point() const;
  /// After a window. Pre: all of `count` are finite, periods > 0.
  void observe(const VoxelCount& count);

 private:
  static constexpr std::size_t kSlots = 64;  // that the scale remembers: of scale_periods / 32 each, or of one window

  void remember(const VoxelCount& count);
  double scale() const;

  Params params_;
  double leaf_;
  std::optional<double> error_;            ///< of the last window
  std::array<VoxelCount, kSlots> seen_{};  ///< a ring
  std::size_t slots_ = 0;                  ///< filled so far
};

/// `voxel` with the leaf of a LeafController. The leaf of a window is set by the counts of those before it, so that one
/// pass over the points is enough. A window that is shorter than 1 ms, or leaves no point, changes nothing.
class ControlledVoxel final : public Sampler {
 public:
  struct Params {
    LeafController::Params control;
    double period = 0.1;  ///< [s]
    VoxelSampler::Keep keep = VoxelSampler::Keep::centre;
    UseNames uses{"map", "match"};
  };
  static void describe(config::Binder& b, Params& p);

  ControlledVoxel(const Params& params, const BuildContext& context);

  ActsOn acts_on() const override { return ActsOn::body; }
  bool moves_points() const override { return filter_.moves_points(); }
  void sample(SampleBatch& batch) override;
  /// Edge of the cubes of the next batch [m].
  double leaf() const { return controller_.leaf(); }

 private:
  std::optional<VoxelCount> count(const SampleBatch& batch, double seconds);

  LeafController controller_;
  double period_;
  PointUses uses_;
  VoxelSampler filter_;
  std::vector<float> ranges_;  ///< of the points left [m]
};

}  // namespace aslio::plugins
