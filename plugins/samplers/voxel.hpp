#pragma once
/// `voxel`: one point per cube of the de-skewed frame, so that near surfaces do not outvote far ones.

#include <cstdint>
#include <vector>

#include "aslio/stages/build_context.hpp"
#include "aslio/stages/sampler.hpp"
#include "aslio/toolkit/point_uses.hpp"

namespace aslio::plugins {

class VoxelSampler final : public Sampler {
 public:
  /// Which point of a cube stays.
  enum class Keep : std::uint8_t {
    centre,  ///< the one nearest to the centre of the cube; of equal ones the first
    first,   ///< the first in time
    mean     ///< the one nearest to the centre, moved to the mean of all points of the cube
  };

  /// Which points are thinned.
  enum class Of : std::uint8_t { all, line, plane };

  struct Params {
    double leaf = 0.3;
    Keep keep = Keep::centre;
    Of of = Of::all;
    UseNames uses{"map", "match"};
  };
  static void describe(config::Binder& b, Params& p);

  VoxelSampler(const Params& params, const BuildContext& context);

  /// Edge of the cubes from the next batch on [m]; > 0.
  void set_leaf(double leaf) { leaves_per_metre_ = static_cast<float>(1.0 / leaf); }

  ActsOn acts_on() const override { return ActsOn::body; }
  bool moves_points() const override { return keep_ == Keep::mean; }
  bool takes_features() const override { return of_ != Of::all; }
  /// Points compete within a cube, for each use among those that still have it. Cubes are aligned to the body frame
  /// at the end of the window. With `mean`, one that stays for uses whose points differ lies at the mean of the last
  /// of overlap, map and match. One of the clearest of its class yields to none but such. Points that are not finite,
  /// or 2^20 cubes away, lose the uses.
  void sample(SampleBatch& batch) override;

 private:
  /// A cube that has a holder in the pass `pass`.
  struct Slot {
    std::uint64_t key = 0;
    std::uint32_t pass = 0;
    std::uint32_t holder = 0;
    float squared = 0;  ///< distance of the holder from the centre of the cube, in leaves^2
  };

  /// A point on its way to its cube.
  struct Candidate {
    std::uint64_t key = 0;
    std::size_t at = 0;  ///< slot to look at first
    std::uint32_t point = 0;
    float squared = 0;
    Eigen::Vector3f from_centre;  ///< of the cube, in leaves
  };

  /// Of all points of a cube, for its mean; beside the slots, which are many, where it is asked for.
  struct Sum {
    float points = 0;
    Eigen::Vector3f distances = Eigen::Vector3f::Zero();  ///< from the centre of the cube, in leaves
  };

  /// Where a point goes once all competitions are over, which take points where they are.
  struct Move {
    std::uint32_t point = 0;
    Eigen::Vector3f to;
  };

  void compete(SampleBatch& batch, PointUses uses);
  /// Nothing where the point takes no part, or loses its uses for being nowhere.
  inline bool enlist(SampleBatch& batch, PointUses uses, std::size_t i, Candidate& candidate) const;
  inline void challenge(SampleBatch& batch, PointUses uses, const Candidate& candidate);
  void find_means(const SampleBatch& batch);
  void start_pass(std::size_t points);
  inline bool concerns(const SampleBatch& batch, std::size_t i) const;

  float leaves_per_metre_;
  Keep keep_;
  Of of_;
  PointUses uses_;
  std::vector<Slot> slots_;  ///< open addressing; a slot of an older pass is free, so that nothing needs clearing
  std::vector<Sum> sums_;    ///< of the slots, with `mean`
  std::vector<Move> moves_;
  std::uint32_t pass_ = 0;
  int shift_ = 0;  ///< of a 64-bit hash to a slot in use
};

}  // namespace aslio::plugins
