#include "maps/oct_voxel.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace aslio::plugins {

namespace {

constexpr std::size_t kStepsAhead = 4;  // queries between the steps of loading a voxel before it is needed
constexpr int kMaxReach = 4;            // voxels; below kCellMargin, so that neighbours of a valid cell have keys

/// Squared distance [m^2] along one axis from the interval [low, high] to the voxels `d` cells away; 0 for its own.
float squared_gap(double low, double high, int d, double edge) {
  if (d == 0) return 0.0F;
  const double gap = std::max(0.0, (d > 0 ? d * edge - high : low - (d + 1) * edge) - kSlack * edge);
  return static_cast<float>(gap * gap);
}

/// Squared distances along each axis from one query to the voxels around it.
class AxisGaps {
 public:
  AxisGaps(const Vec3& relative, double edge) : relative_(relative), edge_(edge) {}
  /// Pre: called for every ring from 1 on before its voxels are asked for.
  void reach(int ring) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double r = relative_[static_cast<Eigen::Index>(axis)];
      squared_[axis][place(ring)] = squared_gap(r, r, ring, edge_);
      squared_[axis][place(-ring)] = squared_gap(r, r, -ring, edge_);
    }
  }
  float squared(int dx, int dy, int dz) const {
    return squared_[0][place(dx)] + squared_[1][place(dy)] + squared_[2][place(dz)];
  }

 private:
  static std::size_t place(int d) { return static_cast<std::size_t>(kMaxReach + d); }

  Vec3 relative_;
  double edge_;
  std::array<std::array<float, 2 * kMaxReach + 1>, 3> squared_{};
};

}  // namespace

void OctVoxel::describe(config::Binder& b, Params& p) {
  b.real("voxel", p.voxel, "m", {.min = 0.02, .max = 100.0}, "edge of a voxel; its eight sub-voxels have half of it");
  b.integer("max_points", p.max_points, "", {.min = 1, .max = 65535},
            "points after which the representative of a sub-voxel stays where it is");
  b.integer("reach", p.reach, "", {.min = 1, .max = kMaxReach},
            "voxels that a query sees on each side of its own: exact within so many edges");
  b.real("radius", p.radius, "m", {.above = 0.0}, "voxels farther than this from the sensor are forgotten");
}

OctVoxel::OctVoxel(const Params& params, const BuildContext& context)
    : params_(params), exec_(context.exec), inverse_edge_(1.0 / params.voxel) {
  for (std::size_t octant = 0; octant < kOctants; ++octant) steps_[octant] = steps_from(octant);
}

std::size_t OctVoxel::octant(const Vec3& relative) const {
  const double half = 0.5 * params_.voxel;
  return (relative.x() >= half ? 1U : 0U) | (relative.y() >= half ? 2U : 0U) | (relative.z() >= half ? 4U : 0U);
}

/// The voxels around that of a query in this octant, nearest first. eq. MAP-6.
std::vector<OctVoxel::Step> OctVoxel::steps_from(std::size_t octant) const {
  const double edge = params_.voxel, half = 0.5 * edge;
  const int reach = static_cast<int>(params_.reach);
  std::vector<Step> steps;
  std::vector<double> to_centre;  // squared, of each: what the octant touches comes by how much of it is near
  const auto low = [&](int axis) { return (octant >> axis & 1U) != 0 ? half : 0.0; };
  for (int x = -reach; x <= reach; ++x) {
    for (int y = -reach; y <= reach; ++y) {
      for (int z = -reach; z <= reach; ++z) {
        const std::array<int, 3> d{x, y, z};
        Step step{x, y, z, std::max({std::abs(x), std::abs(y), std::abs(z)}), 0.0F};
        double centre = 0;
        for (int axis = 0; axis < 3; ++axis) {
          const int cells = d[static_cast<std::size_t>(axis)];
          step.square += squared_gap(low(axis), low(axis) + half, cells, edge);
          centre += std::pow((cells + 0.5) * edge - low(axis) - 0.5 * half, 2);
        }
        steps.push_back(step);
        to_centre.push_back(centre);
      }
    }
  }
  std::vector<std::size_t> order(steps.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return std::tuple(steps[a].square, to_centre[a], a) < std::tuple(steps[b].square, to_centre[b], b);
  });
  std::vector<Step> sorted;
  for (const std::size_t i : order) sorted.push_back(steps[i]);
  return sorted;
}

void OctVoxel::correspond(std::span<const Vec3> queries, const MapQuery& query, Neighbours& out) const {
  const int k = std::clamp(query.k, 1, Neighbours::kMax);
  out.resize(queries.size(), k);
  const auto max_squared = static_cast<float>(query.max_distance * query.max_distance);
  exec_.for_ranges(queries.size(), kQueriesPerChunk, [&](std::size_t begin, std::size_t end, std::size_t) {
    for (std::size_t i = begin; i < end; ++i) {
      if (i + 2 * kStepsAhead < end) load_ahead(queries[i + 2 * kStepsAhead], 0);
      if (i + kStepsAhead < end) load_ahead(queries[i + kStepsAhead], 1);
      Nearest nearest(k, max_squared);
      if (const auto centre = cell_of(queries[i], inverse_edge_)) {
        search(queries[i], *centre, query.max_stamp, nearest);
      }
      nearest.write(out, i);
    }
  });
}

/// Starts to load what the query will need: 0 the slot of its voxel, then 1 the voxel.
void OctVoxel::load_ahead(const Vec3& query, int stage) const {
  const auto cell = cell_of(query, inverse_edge_);
  if (!cell) return;
  if (stage == 0) return index_.prefetch(pack(*cell));
  const std::uint32_t number = index_.find(pack(*cell));
  if (number == kNone) return;
  const Voxel& voxel = voxels_[number];
  __builtin_prefetch(voxel.x.data());
  __builtin_prefetch(voxel.z.data());
}

// eq. MAP-6.
void OctVoxel::search(const Vec3& query, const VoxelCell& centre, std::uint32_t max_stamp, Nearest& nearest) const {
  const double edge = params_.voxel;
  const Vec3 relative = query - corner(centre);
  AxisGaps gaps(relative, edge);
  int reached = 0;
  for (const Step& step : steps_[octant(relative)]) {
    if (step.square > nearest.bound()) return;  // and so are all that follow
    for (; reached < step.ring; ++reached) gaps.reach(reached + 1);
    if (gaps.squared(step.x, step.y, step.z) > nearest.bound()) continue;
    const std::uint32_t number = index_.find(pack({centre.x + step.x, centre.y + step.y, centre.z + step.z}));
    if (number == kNone) continue;
    const Voxel& voxel = voxels_[number];
    const Eigen::Vector3f q = (relative - edge * Vec3(step.x, step.y, step.z)).cast<float>();
    const PointRows points{voxel.x.data(), voxel.y.data(), voxel.z.data(), voxel.stamp.data(), voxel.order.data()};
    nearest.scan(points, kOctants, q.x(), q.y(), q.z(), max_stamp);
  }
}

/// Whether the point is the first of its sub-voxel. eq. MAP-6.
bool OctVoxel::insert_one(const Vec3& p, std::uint32_t stamp) {
  const auto cell = cell_of(p, inverse_edge_);
  if (!cell) return false;
  std::uint32_t number = index_.find(pack(*cell));
  if (number == kNone) number = new_voxel(*cell);
  Voxel& voxel = voxels_[number];
  const Vec3 relative = p - corner(*cell);
  const std::size_t i = octant(relative);
  if (voxel.fused[i] >= params_.max_points) return false;
  const Eigen::Vector3f q = relative.cast<float>();
  voxel.stamp[i] = stamp;
  if (++voxel.fused[i] == 1) {
    voxel.x[i] = q.x();
    voxel.y[i] = q.y();
    voxel.z[i] = q.z();
    voxel.order[i] = next_order_++;
    ++voxel.count;
    ++size_;
    return true;
  }
  const float share = 1.0F / static_cast<float>(voxel.fused[i]);
  voxel.x[i] += share * (q.x() - voxel.x[i]);
  voxel.y[i] += share * (q.y() - voxel.y[i]);
  voxel.z[i] += share * (q.z() - voxel.z[i]);
  return false;
}

std::uint32_t OctVoxel::new_voxel(const VoxelCell& cell) {
  std::uint32_t number = kNone;
  if (free_.empty()) {
    number = static_cast<std::uint32_t>(voxels_.grow(1));
  } else {
    number = free_.back();
    free_.pop_back();
  }
  voxels_[number] = {};
  voxels_[number].cell = cell;
  index_.insert(pack(cell), number);
  return number;
}

InsertCount OctVoxel::insert(std::span<const WorldPoint> points, std::uint32_t stamp) {
  InsertCount count{points.size(), 0};
  for (const WorldPoint& point : points) count.inserted += insert_one(point.p_W, stamp) ? 1 : 0;
  return count;
}

void OctVoxel::drop(std::uint32_t number) {
  index_.erase(pack(voxels_[number].cell));
  size_ -= voxels_[number].count;
  voxels_[number].count = 0;
  free_.push_back(number);
}

void OctVoxel::trim(const Vec3& centre_W) {
  if (!trims_.due(centre_W, params_.voxel)) return;
  for (std::uint32_t number = 0; number < voxels_.size(); ++number) {
    if (voxels_[number].count == 0) continue;
    const Vec3 relative = centre_W - corner(voxels_[number].cell);
    if (squared_distance_to_cube(relative, params_.voxel) > params_.radius * params_.radius) drop(number);
  }
}

void OctVoxel::clear() {
  index_.clear();
  voxels_.clear();
  free_.clear();
  size_ = 0;
  next_order_ = 0;
  trims_.reset();
}

std::size_t OctVoxel::memory_bytes() const {
  std::size_t steps = 0;
  for (const auto& of_octant : steps_) steps += of_octant.capacity() * sizeof(Step);
  return sizeof(*this) + steps + index_.memory_bytes() + voxels_.memory_bytes() +
         free_.capacity() * sizeof(std::uint32_t);
}

void OctVoxel::visit(const std::function<void(const Vec3&)>& visitor) const {
  std::vector<const Voxel*> order;
  for (std::uint32_t number = 0; number < voxels_.size(); ++number) {
    if (voxels_[number].count > 0) order.push_back(&voxels_[number]);
  }
  std::sort(order.begin(), order.end(), [](auto* a, auto* b) { return pack(a->cell) < pack(b->cell); });
  for (const Voxel* voxel : order) {
    for (std::size_t i = 0; i < kOctants; ++i) {
      if (voxel->fused[i] == 0) continue;
      visitor(corner(voxel->cell) + Eigen::Vector3f(voxel->x[i], voxel->y[i], voxel->z[i]).cast<double>());
    }
  }
}

}  // namespace aslio::plugins
