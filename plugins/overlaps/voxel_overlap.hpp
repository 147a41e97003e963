#pragma once

#include <deque>
#include <memory>

#include "aslio/stages/build_context.hpp"
#include "aslio/stages/overlap.hpp"
#include "overlaps/cell_histogram.hpp"

namespace aslio::plugins {

/// What hard_voxel and soft_voxel share: O = sum_i beta_i |Q_i| / |f|, where Q_i are the points of the frame whose
/// cell is i cells from the nearest occupied one (docs/equations.md SOD-1 to SOD-3; AS-LIO (1)-(6)).
///
/// Delay: a frame that became known at t counts from t + delay on. Frames wait in a queue; extend() moves into the
/// store those that are due at its own time, since no later evaluation can be earlier. evaluate() never moves any: it
/// may be a look-ahead whose time the next window does not reach. Frames due only at its time are scored through a
/// second, small store.
class VoxelOverlap : public OverlapMetric {
 public:
  struct Settings {
    double voxel = 0.1;  ///< [m]
    LayerMetric metric = LayerMetric::chebyshev;
    std::vector<double> beta{1.0};  ///< weight of layer 0, 1, .. ; beta[0] = 1
    TimeNs delay = 0;
    std::size_t max_points = 0;  ///< 0: all
    std::size_t min_points = 0;
    std::uint64_t order_seed = 0;
  };

  OverlapScore evaluate(std::span<const WorldPoint> points, TimeNs t) override;
  void extend(std::span<const WorldPoint> points, TimeNs t) override;
  void trim(const Vec3& centre_W, double radius) override;
  std::size_t memory_bytes() const override;

 protected:
  /// Two stores of the same type: the occupancy, and the frames due at an evaluation only.
  VoxelOverlap(Settings settings, std::unique_ptr<OccupancyStore> occupied, std::unique_ptr<OccupancyStore> due);

 private:
  struct Frame {
    TimeNs due = 0;
    std::vector<Cell> cells;
  };
  int depth() const { return static_cast<int>(settings_.beta.size()) - 1; }
  void count_cells(std::span<const WorldPoint> points);
  std::size_t frames_due(TimeNs t) const;
  void gather_due(std::size_t frames);
  void find_layers();

  Settings settings_;
  double inverse_voxel_;
  std::unique_ptr<OccupancyStore> occupied_;
  std::unique_ptr<OccupancyStore> due_;
  std::deque<Frame> waiting_;                  // in order of time
  std::vector<std::vector<Cell>> spare_;       // memory of frames that have been merged
  std::uint64_t merged_ = 0;                   // frames moved into `occupied_` so far
  std::uint64_t due_begin_ = 0, due_end_ = 0;  // frames that `due_` holds, by count
  CellHistogram histogram_;
  std::vector<std::uint8_t> layers_, due_layers_;
  std::vector<Cell> unseen_;
  std::vector<std::size_t> unseen_index_;
  Vec3 trimmed_at_ = Vec3::Zero();
  double trimmed_radius_ = -1;
};

}  // namespace aslio::plugins
