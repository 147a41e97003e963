#pragma once

#include "aslio/config/binder.hpp"
#include "aslio/stages/build_context.hpp"
#include "aslio/stages/map.hpp"
#include "aslio/toolkit/trim_gate.hpp"
#include "maps/point_tree.hpp"

namespace aslio::plugins {

/// Points in an incremental k-d tree (Cai, Xu, Zhang 2021), thinned on insertion: of the points of one kind (lines; all
/// others) in a cell of edge `leaf` the one nearest to the cell's centre stays, the older at equal distance. A point
/// that takes the place of another counts as not inserted, since the map has not grown; it bears its own stamp. Exact
/// at any distance. Points that are not finite or beyond 1e8 m are refused, queries there find nothing. trim() deletes
/// exactly what is beyond the radius, at most once per metre of motion.
class IkdTree final : public Map {
 public:
  struct Params {
    double leaf = 0.1;
    double balance = 0.6;
    double deleted = 0.5;
    double radius = 150.0;
  };
  static void describe(config::Binder& b, Params& p);
  IkdTree(const Params& params, const BuildContext& context);

  void correspond(std::span<const Vec3> queries, const MapQuery& query, Neighbours& out) const override;
  InsertCount insert(std::span<const WorldPoint> points, std::uint32_t stamp) override;
  void trim(const Vec3& centre_W) override;
  /// Deletes the points with low_W <= p <= high_W [m] and returns their number.
  std::size_t erase_box(const Vec3& low_W, const Vec3& high_W);
  void clear() override;
  std::size_t size() const override { return tree_.size(); }
  std::size_t memory_bytes() const override { return sizeof(*this) + tree_.memory_bytes(); }
  double radius() const override { return params_.radius; }
  /// Ascending by x, then y, then z: the order says nothing of the order of insertion.
  void visit(const std::function<void(const Vec3&)>& visitor) const override;

 private:
  bool insert_one(const WorldPoint& point, std::uint32_t stamp);

  Params params_;
  exec::Executor& exec_;
  PointTree tree_;
  std::uint32_t next_order_ = 0;
  TrimGate trims_;
};

}  // namespace aslio::plugins
