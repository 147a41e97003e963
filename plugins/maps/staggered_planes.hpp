#pragma once

#include "maps/voxel_plane.hpp"

namespace aslio::plugins {

/// Planes in several grids of voxels (docs/equations.md MAP-1) that are staggered: each is moved against the one before
/// by an equal part of a voxel along the diagonal (MAP-5). What a voxel takes for one plane where surfaces meet, and so
/// its error, depends on where its faces lie; the next grid has them elsewhere, on every level. Every grid takes all
/// points; the queries of a batch are dealt out in turn, so that a window meets the planes of all grids at the cost of
/// one. (Batches of one or two queries meet those of the first grids alone.)
///
/// Exactness: that of VoxelPlane in each grid. A query finds nothing where its own grid has no plane.
class StaggeredPlanes final : public Map {
 public:
  struct Params {
    VoxelPlane::Params planes;
    std::int64_t grids = 2;
  };
  static void describe(config::Binder& b, Params& p);
  StaggeredPlanes(const Params& params, const BuildContext& context);

  MapContent content() const override { return MapContent::surfaces; }
  void correspond(std::span<const Vec3> queries, const MapQuery& query, Neighbours& out) const override {
    grids_.front().correspond(queries, query, out);
  }
  void surfaces(std::span<const Vec3> queries, const MapQuery& query, std::span<Surface> out) const override {
    grids_.surfaces(queries, query, out);
  }
  /// Inserted: as many as the grid that took most.
  InsertCount insert(std::span<const WorldPoint> points, std::uint32_t stamp) override {
    return grids_.insert(points, stamp);
  }
  void set_noise_scale(double scale) override { grids_.set_noise_scale(scale); }
  void trim(const Vec3& centre_W) override { grids_.trim(centre_W); }
  void clear() override { grids_.clear(); }
  /// Of the first grid, as what visit() tells: all have the same points.
  std::size_t size() const override { return grids_.front().size(); }
  std::size_t memory_bytes() const override { return grids_.memory_bytes(); }
  double radius() const override { return grids_.front().radius(); }
  void visit(const std::function<void(const Vec3&)>& visitor) const override { grids_.front().visit(visitor); }

 private:
  Staggered<VoxelPlane> grids_;
};

}  // namespace aslio::plugins
