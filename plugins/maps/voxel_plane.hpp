#pragma once

#include <array>

#include "aslio/config/binder.hpp"
#include "aslio/stages/build_context.hpp"
#include "aslio/stages/map.hpp"
#include "aslio/toolkit/cell_batch.hpp"
#include "aslio/toolkit/trim_gate.hpp"
#include "maps/plane_sides.hpp"
#include "maps/slots.hpp"
#include "maps/staggered.hpp"

namespace aslio::plugins {

/// Planes in voxels that are halved down to a finest level (docs/equations.md MAP-1; after VoxelMap, Yuan et al. 2022):
/// every voxel sums its points up, and is a plane while they are thin and spread in two directions. A query takes the
/// plane of the coarsest level that has one: many points, little noise; where surfaces meet, a finer level may still
/// tell them apart. A voxel is closed once it has max_points: later points, placed with later errors, must not drag it
/// along.
///
/// Range: voxels are numbered in 21 bits per axis, so that 2^20 edges from the origin (520 km at 0.5 m) points are
/// refused and queries find nothing; nearer than that, a plane is as exact as at the origin, since floats count from
/// the corner of its voxel.
///
/// Faces: a thin wall seen from both sides would be a thick one, or none. So the points of a coarsest voxel are kept in
/// two parts, by the side they are seen from (docs/equations.md MAP-4), and a query meets planes that face it, in
/// whichever part. Points without a view all belong to the first part; a query without viewpoint takes the first that
/// has a plane.
///
/// Self-matches: a query with max_stamp takes planes of that update or before, but a plane goes on taking points until
/// it is closed. So a history point (docs/equations.md HIS-1) meets no plane made of its own window; one that is older
/// holds that window's points too if they have been inserted. Only with `insertion: on_exit`, which inserts nothing of
/// the window, is such a match free of them.
class VoxelPlane final : public Map {
 public:
  struct Params {
    double voxel = 0.5;
    std::int64_t levels = 2;
    std::int64_t min_points = 10;
    std::int64_t max_points = 500;
    double thickness = 0.025;
    double doubt = 10.0;
    double radius = 150.0;
    bool faces = true;
  };
  static void describe(config::Binder& b, Params& p);
  /// `phase`: how far the grid is moved along its diagonal, in voxels.
  VoxelPlane(const Params& params, const BuildContext& context, double phase = 0);

  MapContent content() const override { return MapContent::surfaces; }
  void correspond(std::span<const Vec3> queries, const MapQuery& query, Neighbours& out) const override;
  /// With max_stamp: a plane counts from the update at which its voxel became one.
  void surfaces(std::span<const Vec3> queries, const MapQuery& query, std::span<Surface> out) const override {
    surfaces(queries, query, out, QueryShare{});
  }
  /// Those of a share of the queries; the rest of `out` stays as it is.
  void surfaces(std::span<const Vec3> queries, const MapQuery& query, std::span<Surface> out, QueryShare share) const;
  InsertCount insert(std::span<const WorldPoint> points, std::uint32_t stamp) override;
  void set_noise_scale(double scale) override;
  void trim(const Vec3& centre_W) override;
  void clear() override;
  /// Voxels of the coarsest level, those of two parts twice.
  std::size_t size() const override { return roots_.in_use(); }
  std::size_t memory_bytes() const override;
  double radius() const override { return params_.radius; }
  /// The mean of the points of every part of a voxel of the coarsest level, by voxel.
  void visit(const std::function<void(const Vec3&)>& visitor) const override;

 private:
  /// Coordinates are relative to the corner of the root voxel [m]: floats, for there are many and all are small.
  struct Node {
    std::uint32_t count = 0;
    std::uint32_t stamp = 0;                    ///< update that made it a plane
    std::uint32_t next_fit = 0;                 ///< count from which it is fitted again
    std::uint32_t children = CellIndex::kNone;  ///< number of the first of eight
    bool planar : 1 = false, touched : 1 = false;
    bool sided : 1 = false;  ///< seen from the side its normal points to; otherwise it is not known from where
    ViewSteps view{};        ///< sum of the directions its first points are seen in
    Eigen::Vector3f sum = Eigen::Vector3f::Zero();
    std::array<float, 6> squares{};  ///< xx, xy, xz, yy, yz, zz
    Eigen::Vector3f normal = Eigen::Vector3f::Zero(), mean = Eigen::Vector3f::Zero();
    Eigen::Vector3f along = Eigen::Vector3f::Zero();  ///< direction of the largest variance
    float longest = 1, shortest = 1;                  ///< variances within the plane [m^2]
  };
  /// One part of a coarsest voxel.
  struct Root {
    VoxelCell cell;
    Node node;
    bool in_use = false, second = false;
    std::uint32_t other = CellIndex::kNone;  ///< of a first part: number of the second
  };
  struct Touched {
    std::uint32_t root, node;  ///< node: kNone for that of the root itself
  };

  Vec3 corner(const VoxelCell& cell) const;
  template <class PointOf>
  void fetch(std::size_t count, const PointOf& point, CellBatch& cells,
             std::array<std::uint32_t, CellBatch::kSize>& roots) const;
  inline std::uint32_t fetch_root(std::uint64_t key) const;
  inline void fetch_below(std::uint32_t root, const Eigen::Vector3f& p) const;
  std::uint32_t root_at(std::uint64_t key, const VoxelCell& cell);
  inline bool settled(const Root& first, const Eigen::Vector3f& p, const Eigen::Vector3f& toward) const;
  std::uint32_t take_root(const VoxelCell& cell);
  inline std::uint32_t part_for(std::uint32_t first, const Eigen::Vector3f& p, const Eigen::Vector3f& view);
  void unite(std::uint32_t first);
  void release(std::uint32_t root);
  void give_back(Node& node);
  inline bool add(std::uint32_t root, const Eigen::Vector3f& p, const ViewSteps& view);
  static inline void sum_up(Node& node, const Eigen::Vector3f& p, const ViewSteps& view);
  void fit(Node& node, std::uint32_t stamp);
  void judge_again(Node& node);
  bool closed(const Node& node) const { return node.count >= static_cast<std::uint32_t>(params_.max_points); }
  void drop(std::uint32_t first);
  inline Surface surface(const Vec3& query, const Eigen::Vector3f& p, std::uint32_t first, const MapQuery& how) const;
  inline const Node* plane_at(const Root& root, const Eigen::Vector3f& p, std::uint32_t max_stamp) const;

  Params params_;
  double thickness_;  ///< for the noise there is [m]
  double aspect_;     ///< least variance in a plane over that across it
  std::uint32_t last_stamp_ = 0;
  Vec3 offset_;  ///< of the grid against the origin, in voxels
  exec::Executor& exec_;
  CellIndex index_;
  Slots<Root, 10> roots_;
  Slots<Node, 12, 8> nodes_;  ///< below the roots
  std::vector<Touched> touched_;
  TrimGate trims_;
};

}  // namespace aslio::plugins
