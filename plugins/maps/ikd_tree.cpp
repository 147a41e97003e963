#include "maps/ikd_tree.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <vector>

namespace aslio::plugins {

namespace {

constexpr double kFarthest = 1e8;  // [m]; doubles are still fine to 15 nm there
constexpr double kTrimStep = 1.0;  // [m]

/// False for NaN as well.
bool in_reach(const Vec3& p) { return p.cwiseAbs().maxCoeff() <= kFarthest && p.allFinite(); }

class Box final : public Region {
 public:
  Box(const Vec3& low, const Vec3& high) : low_(low), high_(high) {}
  bool contains(const Vec3& p) const override {
    return (p.array() >= low_.array()).all() && (p.array() <= high_.array()).all();
  }
  Cover cover(const Vec3& low, const Vec3& high) const override {
    if ((low.array() > high_.array()).any() || (high.array() < low_.array()).any()) return Cover::none;
    return contains(low) && contains(high) ? Cover::all : Cover::part;
  }

 private:
  Vec3 low_, high_;
};

/// What lies farther than the radius from the centre.
class Beyond final : public Region {
 public:
  Beyond(const Vec3& centre, double radius) : centre_(centre), squared_(radius * radius) {}
  bool contains(const Vec3& p) const override { return (p - centre_).squaredNorm() > squared_; }
  Cover cover(const Vec3& low, const Vec3& high) const override {
    const Vec3 nearest = centre_.cwiseMax(low).cwiseMin(high) - centre_;
    if (nearest.squaredNorm() > squared_) return Cover::all;
    const Vec3 farthest = (low - centre_).cwiseAbs().cwiseMax((high - centre_).cwiseAbs());
    return farthest.squaredNorm() > squared_ ? Cover::part : Cover::none;
  }

 private:
  Vec3 centre_;
  double squared_;
};

}  // namespace

void IkdTree::describe(config::Binder& b, Params& p) {
  b.real("leaf", p.leaf, "m", {.min = 0.0, .max = 100.0},
         "edge of the cells of which only the point nearest to the centre stays (0: all stay)");
  b.real("balance", p.balance, "", {.min = 0.55, .max = PointTree::kMaxBalance},
         "a subtree is rebuilt when a child holds a larger share of it");
  b.real("deleted", p.deleted, "", {.min = 0.05, .max = 0.95},
         "a subtree is rebuilt when a larger share of it is deleted");
  b.real("radius", p.radius, "m", {.above = 0.0}, "points farther than this from the sensor are forgotten");
}

IkdTree::IkdTree(const Params& params, const BuildContext& context)
    : params_(params), exec_(context.exec), tree_(params.balance, params.deleted) {}

void IkdTree::correspond(std::span<const Vec3> queries, const MapQuery& query, Neighbours& out) const {
  const int k = std::clamp(query.k, 1, Neighbours::kMax);
  out.resize(queries.size(), k);
  const auto max_squared = static_cast<float>(query.max_distance * query.max_distance);
  exec_.for_ranges(queries.size(), kQueriesPerChunk, [&](std::size_t begin, std::size_t end, std::size_t) {
    for (std::size_t i = begin; i < end; ++i) {
      Nearest nearest(k, max_squared);
      if (in_reach(queries[i])) tree_.search(queries[i], query.max_stamp, feature_class::kind(query.feature), nearest);
      nearest.write(out, i);
    }
  });
}

bool IkdTree::insert_one(const WorldPoint& point, std::uint32_t stamp) {
  const Vec3& p = point.p_W;
  if (!in_reach(p)) return false;
  bool replaces = false;
  if (params_.leaf > 0) {
    const Vec3 cell = (p * (1.0 / params_.leaf)).array().floor();
    const std::uint32_t other = tree_.find_in_cell(cell, params_.leaf, feature_class::kind(point.feature));
    if (other != PointTree::kNone) {
      const Vec3 centre = (cell + Vec3::Constant(0.5)) * params_.leaf;
      if ((tree_.point(other) - centre).squaredNorm() <= (p - centre).squaredNorm()) return false;
      tree_.erase(other);
      replaces = true;
    }
  }
  tree_.insert({p, stamp, next_order_++, feature_class::kind(point.feature)});
  return !replaces;
}

InsertCount IkdTree::insert(std::span<const WorldPoint> points, std::uint32_t stamp) {
  InsertCount count{points.size(), 0};
  for (const WorldPoint& point : points) count.inserted += insert_one(point, stamp) ? 1 : 0;
  tree_.settle();
  return count;
}

void IkdTree::trim(const Vec3& centre_W) {
  if (!trims_.due(centre_W, kTrimStep)) return;
  tree_.erase(Beyond(centre_W, params_.radius));
  tree_.settle();
}

std::size_t IkdTree::erase_box(const Vec3& low_W, const Vec3& high_W) {
  const std::size_t erased = tree_.erase(Box(low_W, high_W));
  tree_.settle();
  return erased;
}

void IkdTree::clear() {
  tree_.clear();
  next_order_ = 0;
  trims_.reset();
}

void IkdTree::visit(const std::function<void(const Vec3&)>& visitor) const {
  std::vector<Vec3> points;
  points.reserve(tree_.size());
  tree_.for_each([&](const TreePoint& point) { points.push_back(point.p); });
  std::sort(points.begin(), points.end(), [](const Vec3& a, const Vec3& b) {
    return std::tuple(a.x(), a.y(), a.z()) < std::tuple(b.x(), b.y(), b.z());
  });
  for (const Vec3& p : points) visitor(p);
}

}  // namespace aslio::plugins
