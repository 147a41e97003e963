#pragma once

#include "aslio/config/binder.hpp"
#include "aslio/core/cell_index.hpp"
#include "aslio/stages/build_context.hpp"
#include "aslio/stages/map.hpp"
#include "aslio/toolkit/block_pool.hpp"
#include "aslio/toolkit/nearest.hpp"
#include "aslio/toolkit/trim_gate.hpp"

namespace aslio::plugins {

/// Incremental voxels (Bai et al., Faster-LIO, RA-L 2022): points in a hash of voxels centred on the multiples of their
/// edge, of which those that were longest without a new point are forgotten once there are more than `capacity`. A
/// query sees the points of its own voxel and of `nearby` ones around it, and nothing else, so that it is exact within
/// one edge for 26 and an approximation for 6 and 18 (docs/equations.md MAP-3). Points that are not finite or beyond
/// +-(2^20 - 64) voxels are refused, queries there find nothing. Feature classes are not separated.
class Ivox final : public Map {
 public:
  struct Params {
    double voxel = 1.0;
    std::int64_t nearby = 26;
    double min_spacing = 0.0;
    std::int64_t max_points = 4096;
    std::int64_t capacity = 1000000;
    double radius = 150.0;
  };
  static void describe(config::Binder& b, Params& p);
  Ivox(const Params& params, const BuildContext& context);

  void correspond(std::span<const Vec3> queries, const MapQuery& query, Neighbours& out) const override;
  InsertCount insert(std::span<const WorldPoint> points, std::uint32_t stamp) override;
  void trim(const Vec3& centre_W) override;
  void clear() override;
  std::size_t size() const override { return size_; }
  std::size_t memory_bytes() const override;
  double radius() const override { return params_.radius; }
  /// By cell, then by coordinates within the cell: the order says nothing of the order of insertion.
  void visit(const std::function<void(const Vec3&)>& visitor) const override;

 private:
  static constexpr std::uint32_t kNone = CellIndex::kNone;

  /// One voxel; those in use form a list from the one that got a point last to the one that waited longest.
  struct Voxel {
    VoxelCell cell;
    std::uint32_t count = 0;  ///< 0: not in use
    std::uint32_t newer = kNone, older = kNone;
    Chunk points;
  };
  struct Offset {
    int x, y, z;
  };

  std::optional<VoxelCell> cell_at(const Vec3& p) const;
  Vec3 corner(const VoxelCell& cell) const;
  void search(const Vec3& query, const VoxelCell& centre, std::uint32_t max_stamp, Nearest& nearest) const;
  bool crowded(const Voxel& voxel, const Vec3& relative) const;
  bool insert_one(const Vec3& p, std::uint32_t stamp);
  std::uint32_t new_voxel(const VoxelCell& cell);
  void drop(std::uint32_t number);
  void unlink(std::uint32_t number);
  void link_newest(std::uint32_t number);

  Params params_;
  exec::Executor& exec_;
  double inverse_edge_;
  std::vector<Offset> around_;  ///< own voxel first
  CellIndex index_;
  BlockPool pool_;
  std::vector<Voxel> voxels_;
  std::vector<std::uint32_t> free_;
  std::uint32_t newest_ = kNone, oldest_ = kNone;
  std::size_t used_ = 0;  ///< voxels
  std::size_t size_ = 0;  ///< points
  std::uint32_t next_order_ = 0;
  TrimGate trims_;
};

}  // namespace aslio::plugins
