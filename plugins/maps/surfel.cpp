#include "maps/surfel.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

namespace aslio::plugins {

namespace {

constexpr std::size_t kSurfacesPerChunk = 256;
/// Points whose voxels are fetched at once: looking for one after the other is waiting for memory.
constexpr std::size_t kBatch = CellBatch::kSize;
/// Of so many points in a cell the mean errs by less than what a LiDAR's noise leaves.
constexpr double kMaxPoints = 10000;
/// Along each axis; 5^3 cells fit into a block of 128.
constexpr int kMaxCells = 5;

Mat3 symmetric(const std::array<float, 6>& s) {
  Eigen::Matrix3f m;
  m << s[0], s[1], s[2], s[1], s[3], s[4], s[2], s[4], s[5];
  return m.cast<double>();
}

}  // namespace

void Surfel::describe(config::Binder& b, Params& p) {
  b.real("cell", p.cell, "m", {.min = 0.02, .max = 10.0}, "edge of a cell");
  b.integer("cells", p.cells, "", {.min = 1, .max = kMaxCells}, "cells along the edge of a voxel");
  b.choice("first", p.first, {{"voxel", First::voxel}, {"cell", First::cell}},
           "whose surfel a query takes if both have one: its voxel's (as published), or its cell's");
  b.integer("nearby", p.nearby, "", {.min = 0, .max = 6},
            "cells around its own that a query without surfel asks: 0, or 6 (those that share a face)");
  b.integer("min_cells", p.min_cells, "", {.min = 3, .max = kMaxCells * kMaxCells * kMaxCells},
            "cells that the surfel of a voxel needs");
  b.integer("cell_points", p.cell_points, "", {.min = 1, .max = kMaxPoints},
            "points from which on a cell counts for the surfel of its voxel");
  b.integer("min_points", p.min_points, "", {.min = 4, .max = kMaxPoints}, "points that the surfel of a cell needs");
  b.integer("max_points", p.max_points, "", {.min = 4, .max = kMaxPoints},
            "points after which a cell is closed, so that later errors of the pose do not drag it along");
  b.real("thickness", p.thickness, "m", {.above = 0.0, .max = 1.0},
         "maximum standard deviation of the points across their surfel");
  b.real("planarity", p.planarity, "", {.above = 0.0, .max = 1.0},
         "maximum ratio of the least to the largest variance of the means of a voxel's cells");
  b.real("doubt", p.doubt, "", {.min = 0.0, .max = 1e6},
         "matches of a surfel that share its error: the more, the less one of few points counts, or one at its edge "
         "(0: all alike)");
  b.real("radius", p.radius, "m", {.above = 0.0}, "voxels farther than this from the sensor are forgotten");
  b.require(p.min_points <= p.max_points, "min_points", "must not exceed max_points");
  b.require(p.min_cells <= p.cells * p.cells * p.cells, "min_cells", "must not exceed cells^3, the cells of a voxel");
  b.require(p.cell_points <= p.max_points, "cell_points", "must not exceed max_points");
  b.require(p.nearby == 0 || p.nearby == 6, "nearby", "must be 0 or 6");
}

Surfel::Surfel(const Params& params, const BuildContext& context)
    : params_(params),
      exec_(context.exec),
      edge_(params.cell * static_cast<double>(params.cells)),
      inverse_cell_(static_cast<float>(1.0 / params.cell)),
      block_(std::bit_ceil(static_cast<std::size_t>(params.cells * params.cells * params.cells))),
      thickness_(params.thickness),
      aspect_(least_aspect(1.0)) {}

Surfel::Place Surfel::place_of(const Eigen::Vector3f& p) const {
  Place place{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const float at = p[static_cast<Eigen::Index>(axis)] * inverse_cell_;
    place[axis] = std::clamp(static_cast<int>(at), 0, static_cast<int>(params_.cells) - 1);
  }
  return place;
}

std::uint32_t& Surfel::slot(const Voxel& voxel, const Place& place) {
  const int n = static_cast<int>(params_.cells);
  return slots_[voxel.first_slot + static_cast<std::uint32_t>((place[0] * n + place[1]) * n + place[2])];
}

/// The number of the cell there, or kNone.
std::uint32_t Surfel::cell_at(const Voxel& voxel, const Place& place) const {
  const int n = static_cast<int>(params_.cells);
  return slots_[voxel.first_slot + static_cast<std::uint32_t>((place[0] * n + place[1]) * n + place[2])] - 1;
}

/// The number of the voxel of a point, or kNone; starts to load it.
std::uint32_t Surfel::find_ahead(const CellBatch& batch, std::size_t i) const {
  const std::uint32_t number = batch.key(i) != CellBatch::kNoCell ? index_.find(batch.key(i)) : kNone;
  if (number == kNone) return number;
  const Voxel& voxel = voxels_[number];
  __builtin_prefetch(&voxel);
  __builtin_prefetch(&voxel.patch.longest);
  return number;
}

void Surfel::correspond(std::span<const Vec3> queries, const MapQuery& query, Neighbours& out) const {
  find_no_neighbours(queries, query, out);
}

void Surfel::surfaces(std::span<const Vec3> queries, const MapQuery& query, std::span<Surface> out) const {
  exec_.for_ranges(queries.size(), kSurfacesPerChunk, [&](std::size_t begin, std::size_t end, std::size_t) {
    CellBatch batch;
    std::array<std::uint32_t, kBatch> numbers{};
    for (std::size_t first = begin; first < end; first += kBatch) {
      const std::size_t count = std::min(kBatch, end - first);
      const auto point = [&](std::size_t i) -> const Vec3& { return queries[first + i]; };
      batch.find(count, point, edge_, kGridOffset);
      for (std::size_t i = 0; i < count; ++i) index_.prefetch(batch.key(i));
      for (std::size_t i = 0; i < count; ++i) numbers[i] = find_ahead(batch, i);
      for (std::size_t i = 0; i < count; ++i) {
        Surface& surface = out[first + i];
        surface = {};
        if (batch.key(i) == CellBatch::kNoCell) continue;
        surface = this->surface(point(i), batch.inside(i), numbers[i], query.max_stamp);
        if (surface.valid || params_.nearby == 0) continue;
        surface = beside(point(i), batch.inside(i), batch.cell(i), query.max_stamp);
      }
    }
  });
}

/// What a query at p in its voxel meets there. eq. MAP-7.
Surface Surfel::surface(const Vec3& query, const Eigen::Vector3f& p, std::uint32_t number,
                        std::uint32_t max_stamp) const {
  if (number == kNone) return {};
  const Voxel& voxel = voxels_[number];
  const auto seen = [&](const Patch& patch) { return patch.planar && patch.stamp <= max_stamp; };
  if (params_.first == First::voxel && seen(voxel.patch)) return found(query, voxel, voxel.patch);
  const std::uint32_t cell = cell_at(voxel, place_of(p));
  if (cell != kNone && seen(cells_[cell].patch)) return found(query, voxel, cells_[cell].patch);
  if (params_.first == First::cell && seen(voxel.patch)) return found(query, voxel, voxel.patch);
  return {};
}

/// The surfel of the nearest cell that has one, of those that share a face with the query's own. eq. MAP-7.
Surface Surfel::beside(const Vec3& query, const Eigen::Vector3f& p, const VoxelCell& home,
                       std::uint32_t max_stamp) const {
  struct Side {
    float distance;
    int axis, step;
  };
  std::array<Side, 6> sides;
  const Place place = place_of(p);
  for (int axis = 0; axis < 3; ++axis) {
    const float inside =
        p[axis] - static_cast<float>(params_.cell) * static_cast<float>(place[static_cast<std::size_t>(axis)]);
    sides[static_cast<std::size_t>(2 * axis)] = {inside, axis, -1};
    sides[static_cast<std::size_t>(2 * axis + 1)] = {static_cast<float>(params_.cell) - inside, axis, 1};
  }
  std::stable_sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) { return a.distance < b.distance; });
  for (const Side& side : sides) {
    Place there = place;
    VoxelCell in = home;
    int& along = there[static_cast<std::size_t>(side.axis)];
    along += side.step;
    if (along < 0 || along >= params_.cells) {
      along -= side.step * static_cast<int>(params_.cells);
      (side.axis == 0 ? in.x : side.axis == 1 ? in.y : in.z) += side.step;
    }
    const std::uint32_t number = index_.find(pack(in));
    if (number == kNone) continue;
    const std::uint32_t cell = cell_at(voxels_[number], there);
    if (cell == kNone || !cells_[cell].patch.planar || cells_[cell].patch.stamp > max_stamp) continue;
    return found(query, voxels_[number], cells_[cell].patch);
  }
  return {};
}

Surface Surfel::found(const Vec3& query, const Voxel& voxel, const Patch& patch) const {
  const Vec3 low = corner(voxel.cell);
  const Eigen::Vector3f from_mean = (query - low).cast<float>() - patch.mean;
  Surface surface;
  surface.normal = patch.normal.cast<double>().normalized();
  surface.anchor = low + patch.mean.cast<double>();
  surface.quality =
      plane_quality(patch.count, params_.doubt, from_mean, patch.normal, patch.along, patch.longest, patch.shortest);
  surface.valid = true;
  surface.owner = &patch;
  return surface;
}

InsertCount Surfel::insert(std::span<const WorldPoint> points, std::uint32_t stamp) {
  last_stamp_ = stamp;
  InsertCount count{points.size(), 0};
  CellBatch batch;
  std::array<std::uint32_t, kBatch> numbers{};
  for (std::size_t first = 0; first < points.size(); first += kBatch) {
    const std::size_t size = std::min(kBatch, points.size() - first);
    batch.find(
        size, [&](std::size_t i) -> const Vec3& { return points[first + i].p_W; }, edge_, kGridOffset);
    for (std::size_t i = 0; i < size; ++i) index_.prefetch(batch.key(i));
    for (std::size_t i = 0; i < size; ++i) numbers[i] = find_ahead(batch, i);
    for (std::size_t i = 0; i < size; ++i) {
      if (batch.key(i) == CellBatch::kNoCell) continue;
      const std::uint32_t voxel = numbers[i] != kNone ? numbers[i] : voxel_at(batch.key(i), batch.cell(i));
      count.inserted += insert_one(voxel, batch.inside(i)) ? 1U : 0U;
    }
  }
  for (const Touched& touched : touched_) fit_cell(cells_[touched.cell], stamp);
  for (const Touched& touched : touched_) {
    if (std::exchange(voxels_[touched.voxel].touched, false)) fit_voxel(voxels_[touched.voxel], stamp);
  }
  touched_.clear();
  return count;
}

std::uint32_t Surfel::voxel_at(std::uint64_t key, const VoxelCell& cell) {
  std::uint32_t number = index_.find(key);  // of an earlier point of the batch, perhaps
  if (number != kNone) return number;
  if (free_voxels_.empty()) {
    number = static_cast<std::uint32_t>(voxels_.grow(1));
    voxels_[number].first_slot = static_cast<std::uint32_t>(slots_.grow(block_));
  } else {
    number = free_voxels_.back();
    free_voxels_.pop_back();
  }
  const std::uint32_t first_slot = voxels_[number].first_slot;
  for (std::uint32_t i = 0; i < block_; ++i) slots_[first_slot + i] = 0;
  voxels_[number] = {};
  voxels_[number].cell = cell;
  voxels_[number].first_slot = first_slot;
  index_.insert(key, number);
  return number;
}

std::uint32_t Surfel::new_cell() {
  std::uint32_t number = kNone;
  if (free_cells_.empty()) {
    number = static_cast<std::uint32_t>(cells_.grow(1));
  } else {
    number = free_cells_.back();
    free_cells_.pop_back();
    cells_[number] = {};
  }
  ++cells_in_use_;
  return number;
}

/// Adds a point to its cell; false when that is closed.
bool Surfel::insert_one(std::uint32_t number, const Eigen::Vector3f& p) {
  Voxel& voxel = voxels_[number];
  std::uint32_t& at = slot(voxel, place_of(p));
  if (at == 0) at = new_cell() + 1;
  Cell& cell = cells_[at - 1];
  if (cell.count >= params_.max_points) return false;
  sum_up(cell, p);
  ++voxel.count;
  if (cell.count == params_.cell_points) ++voxel.used;
  if (!std::exchange(cell.touched, true)) touched_.push_back({number, at - 1});
  voxel.touched = true;
  return true;
}

/// One point more in mean and scatter (Welford): no sums of squares, so nothing large cancels.
void Surfel::sum_up(Cell& cell, const Eigen::Vector3f& p) {
  const Eigen::Vector3f before = p - cell.mean;
  cell.mean += before / static_cast<float>(++cell.count);
  const Eigen::Vector3f after = p - cell.mean;
  std::size_t k = 0;
  for (int i = 0; i < 3; ++i)
    for (int j = i; j < 3; ++j) cell.scatter[k++] += before[i] * after[j];
}

PlaneLimits Surfel::limits(double edge) const { return {thickness_, aspect_, kRounding * edge * edge}; }

void Surfel::keep(Patch& patch, const PlaneShape& shape, const Vec3& mean, std::uint32_t count,
                  std::uint32_t stamp) const {
  if (shape.planar && !patch.planar) patch.stamp = stamp;
  patch.planar = shape.planar;
  patch.mean = mean.cast<float>();
  patch.normal = shape.normal.cast<float>();
  patch.along = shape.along.cast<float>();
  patch.longest = static_cast<float>(shape.variance[2]);
  patch.shortest = static_cast<float>(shape.variance[1]);
  patch.count = count;
  patch.next_fit = static_cast<std::uint32_t>(kRefit * count) + 1;
}

/// eq. MAP-1.
void Surfel::fit_cell(Cell& cell, std::uint32_t stamp) {
  cell.touched = false;
  if (cell.count < params_.min_points) return;
  if (cell.count < cell.patch.next_fit && cell.count < params_.max_points) return;
  const PlaneShape shape = plane_shape(symmetric(cell.scatter) / cell.count, limits(params_.cell));
  keep(cell.patch, shape, cell.mean.cast<double>(), cell.count, stamp);
}

/// eq. MAP-7.
void Surfel::fit_voxel(Voxel& voxel, std::uint32_t stamp) {
  if (voxel.used < params_.min_cells) return;
  if (voxel.used == voxel.fitted && voxel.count < voxel.patch.next_fit) return;
  voxel.fitted = voxel.used;
  Vec3 sum = Vec3::Zero();
  Mat3 squares = Mat3::Zero(), within = Mat3::Zero();
  const auto all = static_cast<std::uint32_t>(params_.cells * params_.cells * params_.cells);
  for (std::uint32_t i = 0; i < all; ++i) {
    const std::uint32_t at = slots_[voxel.first_slot + i];
    if (at == 0 || cells_[at - 1].count < params_.cell_points) continue;
    const Cell& cell = cells_[at - 1];
    const Vec3 mean = cell.mean.cast<double>();
    sum += mean;
    squares += mean * mean.transpose();
    within += symmetric(cell.scatter) / cell.count;
  }
  const double n = voxel.used;
  const Vec3 mean = sum / n;
  PlaneShape shape = plane_shape(squares / n - mean * mean.transpose(), limits(edge_));
  // Means alone would make a plane of one layer of cells full of clutter.
  const double across = std::max(0.0, shape.variance[0]) + shape.normal.dot(within * shape.normal) / n;
  shape.planar =
      shape.planar && across < thickness_ * thickness_ && shape.variance[0] < params_.planarity * shape.variance[2];
  keep(voxel.patch, shape, mean, voxel.count, stamp);
}

/// eq. NOI-2. What was too thick before may be a surfel now.
void Surfel::set_noise_scale(double scale) {
  const double before = std::exchange(thickness_, params_.thickness * scale);
  aspect_ = least_aspect(scale);
  if (thickness_ <= before) return;
  for (std::uint32_t number = 0; number < cells_.size(); ++number) {
    Cell& cell = cells_[number];
    if (cell.count == 0 || cell.patch.planar) continue;
    cell.patch.next_fit = 0;
    fit_cell(cell, last_stamp_);
  }
  for (std::uint32_t number = 0; number < voxels_.size(); ++number) {
    Voxel& voxel = voxels_[number];
    if (voxel.count == 0 || voxel.patch.planar) continue;
    voxel.fitted = 0;
    fit_voxel(voxel, last_stamp_);
  }
}

void Surfel::drop(std::uint32_t number) {
  Voxel& voxel = voxels_[number];
  index_.erase(pack(voxel.cell));
  for (std::uint32_t i = 0; i < block_; ++i) {
    const std::uint32_t at = slots_[voxel.first_slot + i];
    if (at == 0) continue;
    cells_[at - 1].count = 0;
    free_cells_.push_back(at - 1);
    --cells_in_use_;
  }
  voxel.count = 0;
  free_voxels_.push_back(number);
}

void Surfel::trim(const Vec3& centre_W) {
  if (!trims_.due(centre_W, edge_)) return;
  for (std::uint32_t number = 0; number < voxels_.size(); ++number) {
    if (voxels_[number].count == 0) continue;
    const Vec3 relative = centre_W - corner(voxels_[number].cell);
    if (squared_distance_to_cube(relative, edge_) > params_.radius * params_.radius) drop(number);
  }
}

void Surfel::clear() {
  index_.clear();
  voxels_.clear();
  slots_.clear();
  cells_.clear();
  free_voxels_.clear();
  free_cells_.clear();
  cells_in_use_ = 0;
  last_stamp_ = 0;
  trims_.reset();
}

std::size_t Surfel::memory_bytes() const {
  return sizeof(*this) + index_.memory_bytes() + voxels_.memory_bytes() + slots_.memory_bytes() +
         cells_.memory_bytes() + (free_voxels_.capacity() + free_cells_.capacity()) * sizeof(std::uint32_t) +
         touched_.capacity() * sizeof(Touched);
}

void Surfel::visit(const std::function<void(const Vec3&)>& visitor) const {
  std::vector<const Voxel*> order;
  for (std::uint32_t number = 0; number < voxels_.size(); ++number) {
    if (voxels_[number].count > 0) order.push_back(&voxels_[number]);
  }
  std::sort(order.begin(), order.end(), [](auto* a, auto* b) { return pack(a->cell) < pack(b->cell); });
  for (const Voxel* voxel : order) {
    for (std::uint32_t i = 0; i < block_; ++i) {
      const std::uint32_t at = slots_[voxel->first_slot + i];
      if (at > 0) visitor(corner(voxel->cell) + cells_[at - 1].mean.cast<double>());
    }
  }
}

}  // namespace aslio::plugins
