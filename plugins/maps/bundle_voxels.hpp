#pragma once
/// The voxels of `bundle_planes`: planes of points that have settled and of points whose keyframes may still move.

#include <array>
#include <functional>
#include <span>
#include <vector>

#include "aslio/stages/build_context.hpp"
#include "aslio/stages/map.hpp"
#include "aslio/toolkit/cell_batch.hpp"
#include "aslio/toolkit/trim_gate.hpp"
#include "maps/cluster_pool.hpp"
#include "maps/plane_sides.hpp"
#include "maps/slots.hpp"
#include "maps/staggered.hpp"

namespace aslio::plugins {

/// Voxels in two levels, after `voxel_plane` (docs/equations.md MAP-1, MAP-2, MAP-4), whose points are kept as moments:
/// those of each keyframe of the window by itself, so that they can move with it, and those of all keyframes before it
/// together (MAP-13). A point stays with the voxel it was first placed in.
class BundleVoxels {
 public:
  struct Params {
    double voxel = 0.5;
    std::int64_t min_points = 10;
    std::int64_t max_points = 1000;
    std::int64_t keyframe_points = 200;
    double thickness = 0.023;
    double doubt = 10.0;
    double radius = 150.0;
    bool faces = true;
  };
  /// A plane that keyframes of the window see. Moments are about `corner`.
  struct Seen {
    Vec3 corner;        ///< W [m]
    Vec3 normal, mean;  ///< of the plane; the mean about `corner`
    const PointMoments* settled;
    double settled_keyframes;  ///< how many of them
    std::span<const ClusterPool::Cluster* const> clusters;
  };

  /// `phase`: how far the grid is moved along its diagonal, in voxels. eq. MAP-5
  BundleVoxels(const Params& params, const BuildContext& context, double phase);

  /// Points of the newest keyframe, `keyframe`.
  InsertCount insert(std::span<const WorldPoint> points, std::uint32_t stamp, std::uint32_t keyframe);
  /// Those of a share of the queries; the rest of `out` stays as it is.
  void surfaces(std::span<const Vec3> queries, const MapQuery& query, std::span<Surface> out, QueryShare share) const;
  /// Calls take(Seen) for every plane of the window, in the order in which their voxels came into it.
  void each_plane(const std::function<void(const Seen&)>& take) const;
  /// Points of keyframe `first` + i go to moves[i] p; their planes follow.
  void move(std::uint32_t first, std::span<const Pose> moves, std::uint32_t stamp);
  /// Points of keyframes before `until` stay where they are from here on.
  void settle(std::uint32_t until, std::uint32_t stamp);
  void set_noise_scale(double scale);
  void trim(const Vec3& centre_W);
  void clear();
  std::size_t size() const { return roots_.in_use(); }
  std::size_t memory_bytes() const;
  void visit(const std::function<void(const Vec3&)>& visitor) const;

 private:
  struct Node {
    PointMoments settled;  ///< about the corner of the coarsest voxel
    std::uint32_t count = 0;
    std::uint32_t stamp = 0;     ///< update that made it a plane
    std::uint32_t next_fit = 0;  ///< count from which it is fitted again
    std::uint32_t children = CellIndex::kNone;
    std::uint32_t clusters = ClusterPool::kNone;  ///< of the keyframes of the window
    std::uint32_t settled_keyframes = 0;
    bool planar : 1 = false, touched : 1 = false, closed : 1 = false;
    bool sided : 1 = false;  ///< seen from the side its normal points to; otherwise it is not known from where
    ViewSteps view{};
    Eigen::Vector3f normal = Eigen::Vector3f::Zero(), mean = Eigen::Vector3f::Zero();
    Eigen::Vector3f along = Eigen::Vector3f::Zero();
    float longest = 1, shortest = 1;  ///< variances within the plane [m^2]
  };
  /// One part of a coarsest voxel.
  struct Root {
    VoxelCell cell;
    Node node;
    bool in_use = false, second = false, active = false;  ///< active: in active_
    std::uint32_t other = CellIndex::kNone;
  };
  struct Touched {
    std::uint32_t root, node;  ///< node: kNone for that of the root itself
  };

  Vec3 corner(const VoxelCell& cell) const;
  std::uint32_t take_root(const VoxelCell& cell);
  std::uint32_t part_for(std::uint32_t first, const Eigen::Vector3f& p, const Eigen::Vector3f& view);
  void give_back(Node& node);
  void release(std::uint32_t root);
  bool add(std::uint32_t root, const Eigen::Vector3f& p, const ViewSteps& view, std::uint32_t keyframe);
  bool take(Node& node, const Eigen::Vector3f& p, const ViewSteps& view, std::uint32_t keyframe);
  void fit(Node& node, std::uint32_t stamp);
  void settle(Node& node, std::uint32_t until, std::uint32_t stamp);
  Surface surface(const Vec3& query, const Eigen::Vector3f& p, std::uint32_t first, const MapQuery& how) const;
  const Node* plane_at(const Root& root, const Eigen::Vector3f& p, std::uint32_t max_stamp) const;
  /// Calls with(node) for a root and what is below it.
  template <class With>
  void each_node(Root& root, With with);

  Params params_;
  double thickness_;
  std::uint32_t last_stamp_ = 0;  ///< of an insertion
  double aspect_;
  Vec3 offset_;  ///< of the grid against the origin, in voxels
  exec::Executor& exec_;
  CellIndex index_;
  Slots<Root, 10> roots_;
  Slots<Node, 12, 8> nodes_;  ///< below the roots
  std::vector<Touched> touched_;
  std::vector<std::uint32_t> active_;  ///< roots with points of the window
  ClusterPool pool_;
  TrimGate trims_;
};

}  // namespace aslio::plugins
