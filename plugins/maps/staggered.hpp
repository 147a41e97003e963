#pragma once
/// Several grids of voxels as one (docs/equations.md MAP-5).

#include <algorithm>
#include <cstdint>
#include <deque>
#include <numeric>
#include <span>

#include "aslio/stages/map.hpp"

namespace aslio::plugins {

/// Every `step`-th of some queries, from the one at `first` on.
struct QueryShare {
  std::size_t first = 0, step = 1;
  /// How many of `all` queries are in it, and the place of the i-th of those among all.
  std::size_t size(std::size_t all) const { return all > first ? (all - first - 1) / step + 1 : 0; }
  std::size_t place(std::size_t i) const { return first + i * step; }
};

/// Grids that are staggered: each is moved against the one before by an equal part of a voxel along the diagonal. Every
/// grid takes all points; the queries of a batch are dealt out in turn. (Batches of one or two queries meet those of
/// the first grids alone.)
template <class Grid>
class Staggered {
 public:
  /// `from`: what a grid is made from, before its phase.
  template <class... From>
  explicit Staggered(std::int64_t count, const From&... from) {
    // An odd number of parts: the finer voxels of two grids coincide on no level, either.
    const std::int64_t parts = count | 1;
    for (std::int64_t i = 0; i < count; ++i)
      grids_.emplace_back(from..., static_cast<double>(i) / static_cast<double>(parts));
  }

  const Grid& front() const { return grids_.front(); }
  std::size_t count() const { return grids_.size(); }
  auto begin() { return grids_.begin(); }
  auto end() { return grids_.end(); }
  auto begin() const { return grids_.begin(); }
  auto end() const { return grids_.end(); }

  void surfaces(std::span<const Vec3> queries, const MapQuery& query, std::span<Surface> out) const {
    for (std::size_t i = 0; i < grids_.size(); ++i)
      grids_[i].surfaces(queries, query, out, QueryShare{i, grids_.size()});
  }
  /// Inserted: as many as the grid that took most.
  template <class... More>
  InsertCount insert(std::span<const WorldPoint> points, std::uint32_t stamp, More... more) {
    InsertCount most{points.size(), 0};
    for (Grid& grid : grids_) most.inserted = std::max(most.inserted, grid.insert(points, stamp, more...).inserted);
    return most;
  }
  void set_noise_scale(double scale) {
    for (Grid& grid : grids_) grid.set_noise_scale(scale);
  }
  void trim(const Vec3& centre_W) {
    for (Grid& grid : grids_) grid.trim(centre_W);
  }
  void clear() {
    for (Grid& grid : grids_) grid.clear();
  }
  std::size_t memory_bytes() const {
    return std::accumulate(grids_.begin(), grids_.end(), std::size_t{0},
                           [](std::size_t sum, const Grid& grid) { return sum + grid.memory_bytes(); });
  }

 private:
  std::deque<Grid> grids_;  ///< a grid does not move
};

}  // namespace aslio::plugins
