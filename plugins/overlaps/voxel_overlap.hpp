#pragma once

#include <limits>
#include <memory>

#include "aslio/config/binder.hpp"
#include "aslio/stages/build_context.hpp"
#include "aslio/stages/overlap.hpp"
#include "overlaps/slice_queue.hpp"

namespace aslio::plugins {

/// What hard_voxel and soft_voxel share: O = sum_i beta_i |Q_i| / |f|, where Q_i are the points of the frame whose
/// cell is i cells from the nearest occupied one (docs/equations.md SOD-1 to SOD-3; AS-LIO (1)-(6)).
///
/// Delay: a point of time s counts in the score of a frame, if that is no longer than `delay`, whose middle is
/// s + delay or later. Whole frames would make the age of the occupancy jump with the length of frames, and with it the
/// score. Points wait in slices of 5 ms; advance() and extend() move into the store those that are due at their time,
/// since no later evaluation is earlier.
/// evaluate() never moves any: it may be a look-ahead whose time the next window does not reach. Slices due only at its
/// time are scored through a second, small store. What an evaluation found occupied, extend() need not learn again.
class VoxelOverlap : public OverlapMetric {
 public:
  /// Which points a frame is made of.
  enum class Points : std::uint8_t { latest, window };
  struct Params {
    double voxel = 0.1;
    Points points = Points::latest;
    double frame_length = 0.1;
    double delay = 0.1;
    std::int64_t max_points = 5000;
    std::int64_t min_points = 50;
    config::Nested<OccupancyStore> store{"block_hash"};
  };
  static void describe(config::Binder& b, Params& p);

  OverlapScore evaluate(std::span<const WorldPoint> points, TimeNs t) override;
  void advance(TimeNs t) override;
  void extend(std::span<const WorldPoint> points, TimeNs t) override;
  void trim(const Vec3& centre_W, double radius) override;
  void clear() override;
  std::size_t memory_bytes() const override;
  bool frames_reach_back() const override { return frame_length_ > 0; }

 protected:
  /// beta: weight of layer 0, 1, .. ; beta[0] = 1.
  VoxelOverlap(const Params& params, LayerMetric metric, std::vector<double> beta, const BuildContext& context);

 private:
  struct KnownPoint {
    TimeNs t = 0;
    Cell cell;
  };
  int depth() const { return static_cast<int>(beta_.size()) - 1; }
  bool counts(const WorldPoint& point, Cell& cell) const;
  void choose(std::span<const WorldPoint> points, TimeNs t);
  /// Did the last evaluation score the point, and find its cell occupied or due? Then it counts from earlier on. To be
  /// asked in order of points, once per evaluation.
  bool found_occupied(std::size_t point, const Cell& cell) {
    while (next_scored_ < layers_.size() && point_of_[next_scored_] < point) ++next_scored_;
    return next_scored_ < layers_.size() && point_of_[next_scored_] == point && layers_[next_scored_] == 0 &&
           scored_[next_scored_] == cell;
  }
  void remember(std::span<const WorldPoint> points, TimeNs t);
  TimeNs horizon(TimeNs t) const;
  void gather_due(std::size_t slices);
  void forget_due();
  void find_layers();

  double inverse_voxel_;
  LayerMetric metric_;
  std::vector<double> beta_;
  TimeNs delay_;
  TimeNs extended_ = 0;  // time of the last extend()
  TimeNs frame_length_;  // 0: a frame is its latest points
  std::size_t max_points_, min_points_;
  std::uint64_t order_seed_;
  std::unique_ptr<OccupancyStore> occupied_;
  std::unique_ptr<OccupancyStore> due_;  // of the same type; what is due at an evaluation only
  SliceQueue waiting_;
  std::uint64_t merged_ = 0;                   // slices moved into `occupied_` so far
  std::uint64_t due_begin_ = 0, due_end_ = 0;  // slices that `due_` holds, by count
  std::vector<KnownPoint> known_;              // of the last frame_length_
  std::vector<Cell> older_;                    // those of an evaluation
  // What the last evaluation scored, in order: cells, their layers (none once they may not be relied on any more), and
  // the number of each point; those of `older_` come first, and have none.
  std::vector<Cell> scored_;
  std::vector<std::uint8_t> layers_;
  std::vector<std::size_t> point_of_;
  std::size_t next_scored_ = 0;  // where extend() goes on to look, at first that behind `older_`
  std::vector<std::uint8_t> due_layers_;
  std::vector<Cell> unseen_;
  std::vector<std::size_t> unseen_index_;
  Vec3 trimmed_at_ = Vec3::Zero();
  double trimmed_radius_ = -1;
  double far_ = std::numeric_limits<double>::infinity();  // range of points that trim() would forget again
};

}  // namespace aslio::plugins
