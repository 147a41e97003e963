#include "maps/voxel_hash.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "aslio/toolkit/cell_points.hpp"
#include "aslio/toolkit/nearest.hpp"

namespace aslio::plugins {

namespace {

constexpr std::size_t kStepsAhead = 3;  // queries between the steps of loading a voxel before it is needed
constexpr int kMaxReach = 32;           // voxels; below kCellMargin, so that neighbours of a valid cell have keys

/// Squared distance [m^2] along one axis from a query at `relative` to the voxels `d` cells away; 0 for its own.
float axis_squared(double relative, int d, double edge) {
  if (d == 0) return 0.0F;
  const double distance = std::max(0.0, (d > 0 ? d * edge - relative : relative - (d + 1) * edge) - kSlack * edge);
  return static_cast<float>(distance * distance);
}

}  // namespace

void VoxelHash::describe(config::Binder& b, Params& p) {
  b.real("voxel", p.voxel, "m", {.min = 0.01, .max = 100.0},
         "edge of a voxel; queries are fastest when it is about the search distance");
  b.real("min_spacing", p.min_spacing, "m", {.min = 0.0, .max = 100.0},
         "a point nearer than this to one already there is refused (0: none is)");
  b.integer("max_points", p.max_points, "", {.min = 1, .max = 4096}, "points per voxel at most");
  b.real("radius", p.radius, "m", {.above = 0.0}, "points farther than this from the sensor are forgotten");
  b.require(p.min_spacing <= p.voxel, "min_spacing", "must not exceed voxel: only adjacent voxels are looked at");
}

VoxelHash::VoxelHash(const Params& params, const BuildContext& context)
    : params_(params),
      exec_(context.exec),
      inverse_voxel_(1.0 / params.voxel),
      pool_(static_cast<std::size_t>(params.max_points)) {}

/// One query on its way through the voxels.
struct VoxelHash::Search {
  Search(int k, float max_squared, std::uint32_t newest) : nearest(k, max_squared), max_stamp(newest) {}

  Nearest nearest;
  std::uint32_t max_stamp;
  VoxelCell centre;
  Vec3 relative;  ///< query minus corner of its voxel
  /// Squared distances to the voxels reached so far, by axis and d + kMaxReach.
  std::array<std::array<float, 2 * kMaxReach + 1>, 3> squared;

  void reach(int d, double edge) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double r = relative[static_cast<Eigen::Index>(axis)];
      squared[axis][static_cast<std::size_t>(kMaxReach + d)] = axis_squared(r, d, edge);
      squared[axis][static_cast<std::size_t>(kMaxReach - d)] = axis_squared(r, -d, edge);
    }
  }
  float distance(int dx, int dy, int dz) const {
    const auto at = [](int d) { return static_cast<std::size_t>(kMaxReach + d); };
    return squared[0][at(dx)] + squared[1][at(dy)] + squared[2][at(dz)];
  }
};

void VoxelHash::correspond(std::span<const Vec3> queries, const MapQuery& query, Neighbours& out) const {
  const int k = std::clamp(query.k, 1, Neighbours::kMax);
  out.resize(queries.size(), k);
  const auto max_squared = static_cast<float>(query.max_distance * query.max_distance);
  exec_.for_ranges(queries.size(), kQueriesPerChunk, [&](std::size_t begin, std::size_t end, std::size_t) {
    for (std::size_t i = begin; i < end; ++i) {
      if (i + 3 * kStepsAhead < end) load_ahead(queries[i + 3 * kStepsAhead], 0);
      if (i + 2 * kStepsAhead < end) load_ahead(queries[i + 2 * kStepsAhead], 1);
      if (i + kStepsAhead < end) load_ahead(queries[i + kStepsAhead], 2);
      Search one(k, max_squared, query.max_stamp);
      search(queries[i], one);
      one.nearest.write(out, i);
    }
  });
}

void VoxelHash::load_ahead(const Vec3& query, int stage) const {
  const auto cell = cell_of(query, inverse_voxel_);
  if (!cell) return;
  const std::uint64_t key = pack(*cell);
  if (stage == 0) return index_.prefetch(key);
  const std::uint32_t number = index_.find(key);
  if (number == CellIndex::kNone) return;
  const Block& block = blocks_[number];
  if (stage == 1) return __builtin_prefetch(&block);
  const std::size_t n = std::min<std::size_t>(block.count, 32);
  for (std::size_t i = 0; i < n; i += 16) {
    __builtin_prefetch(block.points.x + i);
    __builtin_prefetch(block.points.y + i);
    __builtin_prefetch(block.points.z + i);
  }
}

void VoxelHash::search(const Vec3& query, Search& s) const {
  const auto centre = cell_of(query, inverse_voxel_);
  if (!centre) return;
  s.centre = *centre;
  s.relative = query - corner(*centre);
  s.reach(0, params_.voxel);
  s.reach(1, params_.voxel);
  scan(s, 0, 0, 0);

  // The seven voxels on the near sides first: once they have given the bound, the other nineteen are usually out.
  const double half = 0.5 * params_.voxel;
  const int sx = s.relative.x() < half ? -1 : 1, sy = s.relative.y() < half ? -1 : 1,
            sz = s.relative.z() < half ? -1 : 1;
  scan(s, sx, 0, 0);
  scan(s, 0, sy, 0);
  scan(s, 0, 0, sz);
  scan(s, sx, sy, 0);
  scan(s, sx, 0, sz);
  scan(s, 0, sy, sz);
  scan(s, sx, sy, sz);
  double beyond = half * (1.0 - 4.0 * kSlack);
  if (beyond * beyond > static_cast<double>(s.nearest.bound())) return;
  for (int dx = -1; dx <= 1; ++dx) {
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dz = -1; dz <= 1; ++dz) {
        if (dx == -sx || dy == -sy || dz == -sz) scan(s, dx, dy, dz);
      }
    }
  }
  for (int shell = 2; shell <= kMaxReach; ++shell) {
    beyond = (shell - 1) * params_.voxel * (1.0 - 4.0 * kSlack);
    if (beyond * beyond > static_cast<double>(s.nearest.bound())) return;
    s.reach(shell, params_.voxel);
    for (int dx = -shell; dx <= shell; ++dx) {
      for (int dy = -shell; dy <= shell; ++dy) {
        const bool side = std::abs(dx) == shell || std::abs(dy) == shell;
        for (int dz = -shell; dz <= shell; dz += side ? 1 : 2 * shell) scan(s, dx, dy, dz);
      }
    }
  }
}

void VoxelHash::scan(Search& s, int dx, int dy, int dz) const {
  if (s.distance(dx, dy, dz) > s.nearest.bound()) return;
  const std::uint32_t number = index_.find(pack({s.centre.x + dx, s.centre.y + dy, s.centre.z + dz}));
  if (number == CellIndex::kNone) return;
  const Block& block = blocks_[number];
  const Vec3 q = s.relative - params_.voxel * Vec3(dx, dy, dz);
  s.nearest.scan(block.points, block.count, static_cast<float>(q.x()), static_cast<float>(q.y()),
                 static_cast<float>(q.z()), s.max_stamp);
}

bool VoxelHash::crowded(const VoxelCell& cell, const Vec3& relative) const {
  const double edge = params_.voxel, spacing = params_.min_spacing;
  if (spacing <= 0) return false;
  const auto squared_spacing = static_cast<float>(spacing * spacing);
  const auto low = [&](double r) { return r - kSlack * edge < spacing ? -1 : 0; };
  const auto high = [&](double r) { return edge - r - kSlack * edge < spacing ? 1 : 0; };
  for (int dx = low(relative.x()); dx <= high(relative.x()); ++dx) {
    for (int dy = low(relative.y()); dy <= high(relative.y()); ++dy) {
      for (int dz = low(relative.z()); dz <= high(relative.z()); ++dz) {
        const std::uint32_t number = index_.find(pack({cell.x + dx, cell.y + dy, cell.z + dz}));
        if (number == CellIndex::kNone) continue;
        const Chunk& points = blocks_[number].points;
        const auto qx = static_cast<float>(relative.x() - dx * edge), qy = static_cast<float>(relative.y() - dy * edge),
                   qz = static_cast<float>(relative.z() - dz * edge);
        const std::size_t padded = (blocks_[number].count + 7U) / 8U * 8U;
        int near = 0;
        for (std::size_t i = 0; i < padded; ++i) {
          const float x = points.x[i] - qx, y = points.y[i] - qy, z = points.z[i] - qz;
          near |= x * x + y * y + z * z < squared_spacing ? 1 : 0;
        }
        if (near != 0) return true;
      }
    }
  }
  return false;
}

std::uint32_t VoxelHash::new_block(const VoxelCell& cell) {
  std::uint32_t number = static_cast<std::uint32_t>(blocks_.size());
  if (free_blocks_.empty()) {
    blocks_.emplace_back();
  } else {
    number = free_blocks_.back();
    free_blocks_.pop_back();
  }
  blocks_[number] = {cell, 0, pool_.take(1)};
  index_.insert(pack(cell), number);
  return number;
}

bool VoxelHash::insert_one(const Vec3& p, std::uint32_t stamp) {
  const auto cell = cell_of(p, inverse_voxel_);
  if (!cell) return false;
  std::uint32_t number = index_.find(pack(*cell));
  if (number != CellIndex::kNone && blocks_[number].count >= params_.max_points) return false;
  const Vec3 relative = p - corner(*cell);
  if (crowded(*cell, relative)) return false;
  if (number == CellIndex::kNone) number = new_block(*cell);
  Block& block = blocks_[number];
  if (block.count == block.points.capacity) {
    const Chunk larger = pool_.take(block.count + 1);
    std::copy_n(block.points.x, block.count, larger.x);
    std::copy_n(block.points.y, block.count, larger.y);
    std::copy_n(block.points.z, block.count, larger.z);
    std::copy_n(block.points.stamp, block.count, larger.stamp);
    std::copy_n(block.points.order, block.count, larger.order);
    pool_.give_back(std::exchange(block.points, larger));
  }
  block.points.x[block.count] = static_cast<float>(relative.x());
  block.points.y[block.count] = static_cast<float>(relative.y());
  block.points.z[block.count] = static_cast<float>(relative.z());
  block.points.stamp[block.count] = stamp;
  block.points.order[block.count] = next_order_++;
  ++block.count;
  ++size_;
  return true;
}

InsertCount VoxelHash::insert(std::span<const WorldPoint> points, std::uint32_t stamp) {
  InsertCount count{points.size(), 0};
  for (const WorldPoint& point : points) count.inserted += insert_one(point.p_W, stamp) ? 1 : 0;
  return count;
}

void VoxelHash::drop_block(std::uint32_t number) {
  Block& block = blocks_[number];
  index_.erase(pack(block.cell));
  pool_.give_back(block.points);
  size_ -= block.count;
  block = {};
  free_blocks_.push_back(number);
}

void VoxelHash::trim(const Vec3& centre_W) {
  if (!trims_.due(centre_W, params_.voxel)) return;
  for (std::uint32_t number = 0; number < blocks_.size(); ++number) {
    if (blocks_[number].count == 0) continue;
    const Vec3 relative = centre_W - corner(blocks_[number].cell);
    if (squared_distance_to_cube(relative, params_.voxel) > params_.radius * params_.radius) drop_block(number);
  }
}

void VoxelHash::clear() {
  index_.clear();
  pool_.clear();
  blocks_.clear();
  free_blocks_.clear();
  size_ = 0;
  next_order_ = 0;
  trims_.reset();
}

std::size_t VoxelHash::memory_bytes() const {
  return sizeof(*this) + index_.memory_bytes() + pool_.memory_bytes() + blocks_.capacity() * sizeof(Block) +
         free_blocks_.capacity() * sizeof(std::uint32_t);
}

void VoxelHash::visit(const std::function<void(const Vec3&)>& visitor) const {
  const auto corner_of = [this](const VoxelCell& cell) { return corner(cell); };
  visit_by_cell(std::span<const Block>(blocks_), corner_of, visitor);
}

}  // namespace aslio::plugins
