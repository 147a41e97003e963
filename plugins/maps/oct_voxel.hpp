#pragma once

#include <array>

#include "aslio/config/binder.hpp"
#include "aslio/core/cell_index.hpp"
#include "aslio/stages/build_context.hpp"
#include "aslio/stages/map.hpp"
#include "aslio/toolkit/block_pool.hpp"
#include "aslio/toolkit/nearest.hpp"
#include "aslio/toolkit/trim_gate.hpp"
#include "maps/chunked.hpp"

namespace aslio::plugins {

/// Voxels of eight representatives (OctVox of Super-LIO, Wang et al., arXiv 2509.05723; docs/equations.md MAP-6). Each
/// voxel of a hash has eight sub-voxels, each of which keeps one point: the running mean of what fell into it. After
/// `max_points` points it stays. So the density of the map is bounded, and its noise falls with what is fused.
///
/// Neighbours are the nearest of the representatives in the voxels up to `reach` away from that of the query, along
/// each axis: all that lie within `reach` edges, and some that lie farther. The voxels are visited in an order that the
/// octant of the query in its voxel decides. The search ends once no voxel left can hold a nearer one.
///
/// Counts: size() and InsertCount::inserted count representatives. A point that only moves one counts as refused.
///
/// Self-matches: a representative has the stamp of the last point that moved it, so that with max_stamp nothing is seen
/// that holds a later point. A representative that still moves is therefore hidden from a query about the past, with
/// the older points it holds; one that stays is not.
///
/// Points that are not finite or beyond +-(2^20 - 64) voxels are refused, queries there find nothing. Feature classes
/// are not separated.
class OctVoxel final : public Map {
 public:
  struct Params {
    double voxel = 0.5;
    std::int64_t max_points = 20;
    std::int64_t reach = 2;
    double radius = 150.0;
  };
  static void describe(config::Binder& b, Params& p);
  OctVoxel(const Params& params, const BuildContext& context);

  void correspond(std::span<const Vec3> queries, const MapQuery& query, Neighbours& out) const override;
  InsertCount insert(std::span<const WorldPoint> points, std::uint32_t stamp) override;
  void trim(const Vec3& centre_W) override;
  void clear() override;
  std::size_t size() const override { return size_; }
  std::size_t memory_bytes() const override;
  double radius() const override { return params_.radius; }
  /// By voxel, then by octant: the order says nothing of the order of insertion.
  void visit(const std::function<void(const Vec3&)>& visitor) const override;

 private:
  static constexpr std::uint32_t kNone = CellIndex::kNone;
  static constexpr std::size_t kOctants = 8;
  template <class T>
  using Row = std::array<T, kOctants>;

  static constexpr Row<float> nowhere() {
    Row<float> row{};
    row.fill(Chunk::kFarAway);
    return row;
  }
  /// One voxel; rows by octant: bit 0 for the upper half in x, 1 in y, 2 in z. Three cache lines, of which a search
  /// without max_stamp reads the first two.
  struct alignas(64) Voxel {
    Row<float> x = nowhere(), y = nowhere(), z = nowhere();  ///< representatives [m], from the corner
    Row<std::uint32_t> stamp{}, order{};                     ///< of the last point; of the first one
    Row<std::uint16_t> fused{};                              ///< points in it; 0: no representative
    VoxelCell cell;
    std::uint32_t count = 0;  ///< representatives; 0: not in use
  };
  /// A voxel around that of the query.
  struct Step {
    int x, y, z;
    int ring;      ///< the largest of them without sign
    float square;  ///< least squared distance from a query in the octant [m^2]
  };

  Vec3 corner(const VoxelCell& cell) const { return params_.voxel * Vec3(cell.x, cell.y, cell.z); }
  std::size_t octant(const Vec3& relative) const;
  std::vector<Step> steps_from(std::size_t octant) const;
  void load_ahead(const Vec3& query, int stage) const;
  void search(const Vec3& query, const VoxelCell& centre, std::uint32_t max_stamp, Nearest& nearest) const;
  bool insert_one(const Vec3& p, std::uint32_t stamp);
  std::uint32_t new_voxel(const VoxelCell& cell);
  void drop(std::uint32_t number);

  Params params_;
  exec::Executor& exec_;
  double inverse_edge_;
  std::array<std::vector<Step>, kOctants> steps_;  ///< by octant of the query, ascending in `square`
  CellIndex index_;
  Chunked<Voxel, 10> voxels_;
  std::vector<std::uint32_t> free_;
  std::size_t size_ = 0;  ///< representatives
  std::uint32_t next_order_ = 0;
  TrimGate trims_;
};

}  // namespace aslio::plugins
