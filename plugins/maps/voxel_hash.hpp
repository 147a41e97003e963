#pragma once

#include "aslio/config/binder.hpp"
#include "aslio/core/cell_index.hpp"
#include "aslio/stages/build_context.hpp"
#include "aslio/stages/map.hpp"
#include "aslio/toolkit/block_pool.hpp"
#include "aslio/toolkit/trim_gate.hpp"

namespace aslio::plugins {

/// Points in a hash of voxels, as structures of arrays with coordinates relative to the voxel, so that a map of any
/// extent keeps the accuracy of float within one voxel. Exact: a query visits every voxel its ball touches (up to 32
/// voxels away), nearest first, and leaves out only those farther than its k-th neighbour. Points that are not finite
/// or beyond +-(2^20 - 64) voxels are refused, queries there find nothing. Feature classes are not separated.
class VoxelHash final : public Map {
 public:
  struct Params {
    double voxel = 1.0;
    double min_spacing = 0.1;
    std::int64_t max_points = 240;
    double radius = 150.0;
  };
  static void describe(config::Binder& b, Params& p);
  VoxelHash(const Params& params, const BuildContext& context);

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
  struct Block {
    VoxelCell cell;
    std::uint32_t count = 0;  // 0: not in use
    Chunk points;
  };

  Vec3 corner(const VoxelCell& cell) const { return params_.voxel * Vec3(cell.x, cell.y, cell.z); }
  struct Search;
  void search(const Vec3& query, Search& search) const;
  /// Starts to load what the query will need: 0 the slot of its voxel, then 1 the voxel, then 2 the points.
  void load_ahead(const Vec3& query, int stage) const;
  void scan(Search& search, int dx, int dy, int dz) const;
  bool crowded(const VoxelCell& cell, const Vec3& relative) const;
  bool insert_one(const Vec3& p, std::uint32_t stamp);
  std::uint32_t new_block(const VoxelCell& cell);
  void drop_block(std::uint32_t number);

  Params params_;
  exec::Executor& exec_;
  double inverse_voxel_;
  CellIndex index_;
  BlockPool pool_;
  std::vector<Block> blocks_;
  std::vector<std::uint32_t> free_blocks_;
  std::size_t size_ = 0;
  std::uint32_t next_order_ = 0;
  TrimGate trims_;
};

}  // namespace aslio::plugins
