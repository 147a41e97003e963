#pragma once

#include "aslio/config/binder.hpp"
#include "aslio/stages/build_context.hpp"
#include "aslio/stages/map.hpp"
#include "maps/bundle_voxels.hpp"
#include "maps/bundle_window.hpp"

namespace aslio::plugins {

/// Planes that revise themselves (docs/equations.md MAP-10 to MAP-13; bundle adjustment after BALM2 over a window as in
/// Voxel-SLAM, a map repaired behind the sensor as in FORM; the form is ours). The points of the last `lag` seconds are
/// kept as moments per plane and keyframe. Whenever a keyframe ends, the poses of all keyframes are adjusted so that
/// each plane is thin, and points and planes move with them. What leaves the window settles, and holds what comes.
///
/// The map alone is revised: the filter meets the revised planes at its next update. States of the IMU's calibration
/// are the filter's. A keyframe moves as a whole, and points stay with the voxel that they were first placed in.
///
/// Grids are staggered as those of `staggered_planes` (MAP-5). Range and faces are those of `voxel_plane`. With
/// max_stamp a plane counts from the update that found it, however its points have moved since. Feature classes are not
/// separated. Insertion and adjustment are one loop, the same for any number of threads. Memory: what the radius holds,
/// and lag / keyframe moments per voxel of the window at most.
class BundlePlanes final : public Map {
 public:
  struct Params {
    BundleVoxels::Params voxels;
    BundleWindow::Params window;
    std::int64_t grids = 1;
  };
  static void describe(config::Binder& b, Params& p);
  BundlePlanes(const Params& params, const BuildContext& context);

  MapContent content() const override { return MapContent::surfaces; }
  void correspond(std::span<const Vec3> queries, const MapQuery& query, Neighbours& out) const override;
  void surfaces(std::span<const Vec3> queries, const MapQuery& query, std::span<Surface> out) const override {
    grids_.surfaces(queries, query, out);
  }
  InsertCount insert(std::span<const WorldPoint> points, std::uint32_t stamp) override;
  void set_noise_scale(double scale) override;
  void trim(const Vec3& centre_W) override { grids_.trim(centre_W); }
  void clear() override;
  /// Voxels of the coarser level of the first grid, those of two parts twice.
  std::size_t size() const override { return grids_.front().size(); }
  std::size_t memory_bytes() const override { return grids_.memory_bytes(); }
  double radius() const override { return radius_; }
  /// The mean of the points of every part of a voxel of the coarser level of the first grid, by voxel.
  void visit(const std::function<void(const Vec3&)>& visitor) const override { grids_.front().visit(visitor); }

 private:
  Staggered<BundleVoxels> grids_;
  BundleWindow window_;
  double radius_;
};

}  // namespace aslio::plugins
