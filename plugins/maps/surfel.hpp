#pragma once

#include <array>

#include "aslio/config/binder.hpp"
#include "aslio/stages/build_context.hpp"
#include "aslio/stages/map.hpp"
#include "aslio/toolkit/cell_batch.hpp"
#include "aslio/toolkit/trim_gate.hpp"
#include "maps/chunked.hpp"
#include "maps/plane_shape.hpp"

namespace aslio::plugins {

/// Surfels on two levels (after hVox of Surfel-LIO, Choi et al., arXiv 2512.03397; docs/equations.md MAP-7). Each voxel
/// of a hash has `cells`^3 cells inside. A cell keeps the mean and the covariance of its points, summed up one by one.
/// The surfel of a voxel is fitted to the means of its cells, which count alike however many points they have; that of
/// a cell to its own points. Both are fitted when points come in, not when they are asked for, so that a query takes
/// what is there: no neighbours, no fit.
///
/// A query takes the surfel of its voxel or of its cell, whichever `first` names; the other one where that has none;
/// and where neither has one, that of a cell which shares a face with its own, the nearest first (`nearby`: 6).
///
/// Range: as voxel_plane. The two faces of a wall are not separated: a thin wall seen from both sides is a thick one.
///
/// Self-matches: with max_stamp a surfel counts from the update at which it became one, and goes on taking points until
/// its cells have `max_points`. See VoxelPlane for what that means of history points.
class Surfel final : public Map {
 public:
  enum class First : std::uint8_t { voxel, cell };
  struct Params {
    double cell = 0.5;
    std::int64_t cells = 3;
    First first = First::voxel;
    std::int64_t nearby = 0;
    std::int64_t min_cells = 5;
    std::int64_t cell_points = 3;
    std::int64_t min_points = 10;
    std::int64_t max_points = 100;
    double thickness = 0.04;
    double planarity = 0.1;
    double doubt = 10.0;
    double radius = 150.0;
  };
  static void describe(config::Binder& b, Params& p);
  Surfel(const Params& params, const BuildContext& context);

  MapContent content() const override { return MapContent::surfaces; }
  void correspond(std::span<const Vec3> queries, const MapQuery& query, Neighbours& out) const override;
  void surfaces(std::span<const Vec3> queries, const MapQuery& query, std::span<Surface> out) const override;
  InsertCount insert(std::span<const WorldPoint> points, std::uint32_t stamp) override;
  void set_noise_scale(double scale) override;
  void trim(const Vec3& centre_W) override;
  void clear() override;
  /// Cells.
  std::size_t size() const override { return cells_in_use_; }
  std::size_t memory_bytes() const override;
  double radius() const override { return params_.radius; }
  /// The mean of the points of every cell, by voxel.
  void visit(const std::function<void(const Vec3&)>& visitor) const override;

 private:
  static constexpr std::uint32_t kNone = CellIndex::kNone;

  /// A plane as it was fitted last. Coordinates, here and below, are relative to the corner of the voxel [m].
  struct Patch {
    Eigen::Vector3f mean = Eigen::Vector3f::Zero(), normal = Eigen::Vector3f::Zero(), along = Eigen::Vector3f::Zero();
    float longest = 1, shortest = 1;  ///< variances within the plane [m^2]
    std::uint32_t count = 0;          ///< points
    std::uint32_t stamp = 0;          ///< update that made it a surfel
    std::uint32_t next_fit = 0;       ///< count from which it is fitted again
    bool planar = false;
  };
  struct Cell {
    std::uint32_t count = 0;  ///< 0: not in use
    bool touched = false;
    Eigen::Vector3f mean = Eigen::Vector3f::Zero();
    std::array<float, 6> scatter{};  ///< sum of products of offsets from the mean: xx, xy, xz, yy, yz, zz [m^2]
    Patch patch;
  };
  struct Voxel {
    VoxelCell cell;
    std::uint32_t first_slot = 0;        ///< of its cells in slots_
    std::uint32_t count = 0;             ///< points; 0: not in use
    std::uint32_t used = 0, fitted = 0;  ///< cells with cell_points: now, and at the last fit
    bool touched = false;
    Patch patch;
  };
  struct Touched {
    std::uint32_t voxel, cell;
  };
  /// Where a point lies in its voxel: along each axis, in cells.
  using Place = std::array<int, 3>;

  Vec3 corner(const VoxelCell& cell) const { return edge_ * (Vec3(cell.x, cell.y, cell.z) - kGridOffset); }
  Place place_of(const Eigen::Vector3f& p) const;
  std::uint32_t cell_at(const Voxel& voxel, const Place& place) const;
  std::uint32_t& slot(const Voxel& voxel, const Place& place);
  std::uint32_t find_ahead(const CellBatch& batch, std::size_t i) const;
  Surface surface(const Vec3& query, const Eigen::Vector3f& p, std::uint32_t number, std::uint32_t max_stamp) const;
  Surface beside(const Vec3& query, const Eigen::Vector3f& p, const VoxelCell& home, std::uint32_t max_stamp) const;
  Surface found(const Vec3& query, const Voxel& voxel, const Patch& patch) const;

  bool insert_one(std::uint32_t voxel, const Eigen::Vector3f& p);
  std::uint32_t voxel_at(std::uint64_t key, const VoxelCell& cell);
  std::uint32_t new_cell();
  static void sum_up(Cell& cell, const Eigen::Vector3f& p);
  void fit_cell(Cell& cell, std::uint32_t stamp);
  void fit_voxel(Voxel& voxel, std::uint32_t stamp);
  void keep(Patch& patch, const PlaneShape& shape, const Vec3& mean, std::uint32_t count, std::uint32_t stamp) const;
  PlaneLimits limits(double edge) const;
  void drop(std::uint32_t number);

  Params params_;
  exec::Executor& exec_;
  double edge_;         ///< of a voxel [m]
  float inverse_cell_;  ///< [1/m]
  std::size_t block_;   ///< slots per voxel: cells^3, rounded up to a power of two
  double thickness_;    ///< for the noise there is [m]
  double aspect_;       ///< least variance in a plane over that across it
  std::uint32_t last_stamp_ = 0;
  CellIndex index_;
  Chunked<Voxel, 10> voxels_;
  Chunked<std::uint32_t, 12> slots_;  ///< per voxel a block: 1 + the number of a cell, or 0
  Chunked<Cell, 12> cells_;
  std::vector<std::uint32_t> free_voxels_, free_cells_;
  std::size_t cells_in_use_ = 0;
  std::vector<Touched> touched_;
  TrimGate trims_;
};

}  // namespace aslio::plugins
