#include "maps/ivox.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "aslio/toolkit/cell_points.hpp"
#include "aslio/toolkit/nearest.hpp"

namespace aslio::plugins {

namespace {

constexpr std::size_t kSlotsAhead = 4;  // queries between loading a slot of the index and using it
constexpr std::array kSteps{0, -1, 1};  // own voxel first

}  // namespace

void Ivox::describe(config::Binder& b, Params& p) {
  b.real("voxel", p.voxel, "m", {.min = 0.01, .max = 100.0}, "edge of a voxel");
  b.integer(
      "nearby", p.nearby, "", {.min = 0, .max = 26},
      "voxels around its own that a query sees: 0, 6 (those that share a face), 18 (an edge, too), 26 (a corner, too)");
  b.real("min_spacing", p.min_spacing, "m", {.min = 0.0, .max = 100.0},
         "a point nearer than this to one of its own voxel is refused (0: none is)");
  b.integer("max_points", p.max_points, "", {.min = 1, .max = 4096}, "points per voxel at most");
  b.integer("capacity", p.capacity, "", {.min = 1, .max = 1e8},
            "voxels at most: beyond, the one that was longest without a new point is forgotten");
  b.real("radius", p.radius, "m", {.above = 0.0}, "points farther than this from the sensor are forgotten");
  b.require(p.nearby == 0 || p.nearby == 6 || p.nearby == 18 || p.nearby == 26, "nearby", "must be 0, 6, 18 or 26");
}

Ivox::Ivox(const Params& params, const BuildContext& context)
    : params_(params),
      exec_(context.exec),
      inverse_edge_(1.0 / params.voxel),
      pool_(static_cast<std::size_t>(params.max_points)) {
  const int axes = params.nearby == 0 ? 0 : params.nearby == 6 ? 1 : params.nearby == 18 ? 2 : 3;
  for (int moved = 0; moved <= axes; ++moved) {  // nearer ones first: they give the bound that excludes others
    for (const int x : kSteps) {
      for (const int y : kSteps) {
        for (const int z : kSteps) {
          if (std::abs(x) + std::abs(y) + std::abs(z) == moved) around_.push_back({x, y, z});
        }
      }
    }
  }
}

std::optional<VoxelCell> Ivox::cell_at(const Vec3& p) const {
  return cell_of(p + Vec3::Constant(0.5 * params_.voxel), inverse_edge_);
}

Vec3 Ivox::corner(const VoxelCell& cell) const {
  return params_.voxel * (Vec3(cell.x, cell.y, cell.z) - Vec3::Constant(0.5));
}

void Ivox::correspond(std::span<const Vec3> queries, const MapQuery& query, Neighbours& out) const {
  const int k = std::clamp(query.k, 1, Neighbours::kMax);
  out.resize(queries.size(), k);
  const auto max_squared = static_cast<float>(query.max_distance * query.max_distance);
  exec_.for_ranges(queries.size(), kQueriesPerChunk, [&](std::size_t begin, std::size_t end, std::size_t) {
    for (std::size_t i = begin; i < end; ++i) {
      if (i + kSlotsAhead < end) {
        if (const auto ahead = cell_at(queries[i + kSlotsAhead])) index_.prefetch(pack(*ahead));
      }
      Nearest nearest(k, max_squared);
      if (const auto centre = cell_at(queries[i])) search(queries[i], *centre, query.max_stamp, nearest);
      nearest.write(out, i);
    }
  });
}

// eq. MAP-3.
void Ivox::search(const Vec3& query, const VoxelCell& centre, std::uint32_t max_stamp, Nearest& nearest) const {
  const double edge = params_.voxel;
  const Vec3 relative = query - corner(centre);
  // Squared distance to the voxels one step away, by axis; index 0: own, 1: below, 2: above.
  std::array<std::array<float, 3>, 3> squared;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double r = relative[static_cast<Eigen::Index>(axis)];
    const double below = std::max(0.0, r - kSlack * edge), above = std::max(0.0, edge - r - kSlack * edge);
    squared[axis] = {0.0F, static_cast<float>(below * below), static_cast<float>(above * above)};
  }
  const auto at = [](int step) { return static_cast<std::size_t>(step < 0 ? 1 : step > 0 ? 2 : 0); };
  for (const Offset& d : around_) {
    if (squared[0][at(d.x)] + squared[1][at(d.y)] + squared[2][at(d.z)] > nearest.bound()) continue;
    const std::uint32_t number = index_.find(pack({centre.x + d.x, centre.y + d.y, centre.z + d.z}));
    if (number == kNone) continue;
    const Voxel& voxel = voxels_[number];
    const Eigen::Vector3f q = (relative - edge * Vec3(d.x, d.y, d.z)).cast<float>();
    nearest.scan(voxel.points, voxel.count, q.x(), q.y(), q.z(), max_stamp);
  }
}

bool Ivox::crowded(const Voxel& voxel, const Vec3& relative) const {
  if (params_.min_spacing <= 0) return false;
  const auto squared_spacing = static_cast<float>(params_.min_spacing * params_.min_spacing);
  const Eigen::Vector3f q = relative.cast<float>();
  for (std::uint32_t i = 0; i < voxel.count; ++i) {
    const Eigen::Vector3f d(voxel.points.x[i] - q.x(), voxel.points.y[i] - q.y(), voxel.points.z[i] - q.z());
    if (d.squaredNorm() < squared_spacing) return true;
  }
  return false;
}

void Ivox::unlink(std::uint32_t number) {
  const Voxel& voxel = voxels_[number];
  (voxel.newer == kNone ? newest_ : voxels_[voxel.newer].older) = voxel.older;
  (voxel.older == kNone ? oldest_ : voxels_[voxel.older].newer) = voxel.newer;
}

void Ivox::link_newest(std::uint32_t number) {
  voxels_[number].newer = kNone;
  voxels_[number].older = newest_;
  (newest_ == kNone ? oldest_ : voxels_[newest_].newer) = number;
  newest_ = number;
}

std::uint32_t Ivox::new_voxel(const VoxelCell& cell) {
  if (used_ == static_cast<std::size_t>(params_.capacity)) drop(oldest_);
  auto number = static_cast<std::uint32_t>(voxels_.size());
  if (free_.empty()) {
    voxels_.emplace_back();
  } else {
    number = free_.back();
    free_.pop_back();
  }
  voxels_[number] = {cell, 0, kNone, kNone, pool_.take(1)};
  index_.insert(pack(cell), number);
  link_newest(number);
  ++used_;
  return number;
}

void Ivox::drop(std::uint32_t number) {
  unlink(number);
  Voxel& voxel = voxels_[number];
  index_.erase(pack(voxel.cell));
  pool_.give_back(voxel.points);
  size_ -= voxel.count;
  voxel = {};
  free_.push_back(number);
  --used_;
}

bool Ivox::insert_one(const Vec3& p, std::uint32_t stamp) {
  const auto cell = cell_at(p);
  if (!cell) return false;
  std::uint32_t number = index_.find(pack(*cell));
  const Vec3 relative = p - corner(*cell);
  if (number == kNone) {
    number = new_voxel(*cell);
  } else {
    if (voxels_[number].count >= params_.max_points || crowded(voxels_[number], relative)) return false;
    unlink(number);
    link_newest(number);
  }
  Voxel& voxel = voxels_[number];
  if (voxel.count == voxel.points.capacity) {
    const Chunk larger = pool_.take(voxel.count + 1);
    std::copy_n(voxel.points.x, voxel.count, larger.x);
    std::copy_n(voxel.points.y, voxel.count, larger.y);
    std::copy_n(voxel.points.z, voxel.count, larger.z);
    std::copy_n(voxel.points.stamp, voxel.count, larger.stamp);
    std::copy_n(voxel.points.order, voxel.count, larger.order);
    pool_.give_back(std::exchange(voxel.points, larger));
  }
  voxel.points.x[voxel.count] = static_cast<float>(relative.x());
  voxel.points.y[voxel.count] = static_cast<float>(relative.y());
  voxel.points.z[voxel.count] = static_cast<float>(relative.z());
  voxel.points.stamp[voxel.count] = stamp;
  voxel.points.order[voxel.count] = next_order_++;
  ++voxel.count;
  ++size_;
  return true;
}

InsertCount Ivox::insert(std::span<const WorldPoint> points, std::uint32_t stamp) {
  InsertCount count{points.size(), 0};
  for (const WorldPoint& point : points) count.inserted += insert_one(point.p_W, stamp) ? 1 : 0;
  return count;
}

void Ivox::trim(const Vec3& centre_W) {
  if (!trims_.due(centre_W, params_.voxel)) return;
  for (std::uint32_t number = 0; number < voxels_.size(); ++number) {
    if (voxels_[number].count == 0) continue;
    const Vec3 relative = centre_W - corner(voxels_[number].cell);
    if (squared_distance_to_cube(relative, params_.voxel) > params_.radius * params_.radius) drop(number);
  }
}

void Ivox::clear() {
  index_.clear();
  pool_.clear();
  voxels_.clear();
  free_.clear();
  newest_ = oldest_ = kNone;
  used_ = size_ = 0;
  next_order_ = 0;
  trims_.reset();
}

std::size_t Ivox::memory_bytes() const {
  return sizeof(*this) + index_.memory_bytes() + pool_.memory_bytes() + voxels_.capacity() * sizeof(Voxel) +
         free_.capacity() * sizeof(std::uint32_t);
}

void Ivox::visit(const std::function<void(const Vec3&)>& visitor) const {
  const auto corner_of = [this](const VoxelCell& cell) { return corner(cell); };
  visit_by_cell(std::span<const Voxel>(voxels_), corner_of, visitor);
}

}  // namespace aslio::plugins
