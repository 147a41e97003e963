#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "aslio/config/binder.hpp"
#include "aslio/core/cell_index.hpp"
#include "aslio/core/packed_direction.hpp"
#include "aslio/stages/build_context.hpp"
#include "aslio/stages/map.hpp"
#include "aslio/toolkit/block_pool.hpp"
#include "aslio/toolkit/trim_gate.hpp"
#include "maps/sampled_plane.hpp"
#include "maps/slots.hpp"

namespace aslio::plugins {

/// Planes found among the points of a voxel, whose outliers are handed on to its eighths (docs/equations.md MAP-9;
/// after R-VoxelMap, arXiv 2601.12377): every voxel collects a sample of points, looks for the plane that most of them
/// lie on, and keeps that; what does not lie on it goes to the eighth of the voxel that it lies in, which does the
/// same, down to the finest level. So two surfaces in one voxel are two planes, where `voxel_plane` has one that is
/// thick, or none.
///
/// Faces: a point seen from behind a plane lies on another one, however near, and a query meets planes that face it.
///
/// Falsified planes: a point behind a plane, seen through it, is evidence that the plane is not there. A plane that
/// more points are seen through than lie on it is forgotten, and its voxel begins again. `voxel_plane` keeps a closed
/// plane.
///
/// Range, and the meaning of max_stamp, are those of `voxel_plane`: with max_stamp a plane counts from the update that
/// found it. Feature classes are not separated. Insertion is one loop, the same for any number of threads.
class RecursivePlanes final : public Map {
 public:
  struct Params {
    double voxel = 0.5;
    std::int64_t levels = 3;
    std::int64_t sample = 30;
    double share = 0.5;
    std::int64_t max_points = 500;
    double thickness = 0.023;
    double doubt = 10.0;
    std::int64_t reopen = 30;
    double radius = 150.0;
  };
  static void describe(config::Binder& b, Params& p);
  RecursivePlanes(const Params& params, const BuildContext& context);

  MapContent content() const override { return MapContent::surfaces; }
  void correspond(std::span<const Vec3> queries, const MapQuery& query, Neighbours& out) const override;
  void surfaces(std::span<const Vec3> queries, const MapQuery& query, std::span<Surface> out) const override;
  InsertCount insert(std::span<const WorldPoint> points, std::uint32_t stamp) override;
  void set_noise_scale(double scale) override;
  void trim(const Vec3& centre_W) override;
  void clear() override;
  /// Voxels of the coarsest level.
  std::size_t size() const override { return roots_.in_use(); }
  std::size_t memory_bytes() const override;
  double radius() const override { return params_.radius; }
  /// The mean of the plane of every voxel, of all levels, that has one, by voxel of the coarsest level.
  void visit(const std::function<void(const Vec3&)>& visitor) const override;
  /// Planes that were forgotten since they were seen through, for tests and reports.
  std::uint64_t reopened() const { return reopened_; }

 private:
  enum class Kind : std::uint8_t { open, plane, mixed };
  struct Node {
    Kind kind = Kind::open;
    std::uint8_t attempts = 0;                  ///< samples without a plane, of a voxel of the finest level
    std::uint16_t count = 0;                    ///< points of the sample
    std::uint32_t children = CellIndex::kNone;  ///< number of the first of eight
    std::uint32_t stamp = 0;                    ///< update that found the plane
    std::uint32_t on = 0, through = 0;          ///< points on the plane and seen through it, since they were halved
    Chunk sample;                               ///< of an open voxel; `order` holds the views
    SampledPlane plane;
  };
  struct Root {
    VoxelCell cell;
    Node node;
    bool in_use = false;
  };
  /// A point inside its coarsest voxel, from the corner of that [m], and the direction it is seen in (zero: not known).
  struct Seen {
    Eigen::Vector3f p;
    PackedDirection view;
  };
  /// Where a voxel is, inside its coarsest one.
  struct Place {
    Eigen::Vector3f low = Eigen::Vector3f::Zero();
    float edge = 0;
    std::int64_t level = 0;
  };

  Vec3 corner(const VoxelCell& cell) const;
  std::uint32_t root_at(const VoxelCell& cell);
  bool add(Node& node, const Place& place, const Seen& seen);
  bool add_to_plane(Node& node, const Seen& seen);
  bool belongs(const SampledPlane& plane, const Seen& seen) const;
  bool seen_through(const SampledPlane& plane, const Seen& seen) const;
  bool falsified(Node& node) const;
  void open_again(Node& node);
  void judge_again(Node& node);
  void keep(Node& node, const Seen& seen);
  void judge(Node& node, const Place& place);
  bool hand_on(Node& node, const Place& place, const Seen& seen);
  void release(Node& node);
  void drop(std::uint32_t number);
  Surface surface(const Vec3& query, const MapQuery& how) const;
  void visit_planes(const Node& node, const Vec3& low, const std::function<void(const Vec3&)>& visitor) const;

  Params params_;
  float thickness_;  ///< for the noise there is [m]
  double aspect_;    ///< least variance in a plane over that across it
  exec::Executor& exec_;
  double inverse_edge_;
  std::uint32_t stamp_ = 0;  ///< of the insertion that runs
  std::uint64_t reopened_ = 0;
  CellIndex index_;
  BlockPool pool_;
  Slots<Root, 10> roots_;
  Slots<Node, 12, 8> nodes_;           ///< below the roots
  std::vector<std::uint8_t> lies_on_;  ///< of a sample, reused
  TrimGate trims_;
};

}  // namespace aslio::plugins
