#include "maps/recursive_planes.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <tuple>
#include <utility>

#include "maps/octant.hpp"

namespace aslio::plugins {

namespace {

constexpr std::size_t kSurfacesPerChunk = 256;
/// Distance from a plane within which a point is one of its own, in thicknesses.
constexpr float kOwn = 3;
/// Squared distance from the mean of a plane's points within it, in variances: a ray farther out passes beside it.
constexpr float kInside = 3;
/// Samples without a plane after which a voxel of the finest level is left alone.
constexpr std::uint8_t kAttempts = 8;
constexpr std::uint32_t kNone = CellIndex::kNone;

}  // namespace

void RecursivePlanes::describe(config::Binder& b, Params& p) {
  b.real("voxel", p.voxel, "m", {.min = 0.05, .max = 10.0}, "edge of the coarsest voxels");
  b.integer("levels", p.levels, "", {.min = 1, .max = 6}, "levels; each has half the edge of the one above");
  b.integer("sample", p.sample, "", {.min = 8, .max = 256}, "points that a voxel collects before it looks for a plane");
  b.real("share", p.share, "", {.min = 0.2, .max = 1.0}, "of the sample that must lie on the plane");
  b.integer("max_points", p.max_points, "", {.min = 8, .max = 10000}, "points after which a plane takes no more");
  b.real("thickness", p.thickness, "m", {.above = 0.0, .max = 1.0},
         "maximum standard deviation of the points across their plane; points within three of it are its own");
  b.real("doubt", p.doubt, "", {.min = 0.0, .max = 1e6},
         "matches of a plane that share its error: the more, the less a plane of few points counts, or one at its edge "
         "(0: all alike)");
  b.integer("reopen", p.reopen, "", {.min = 0, .max = 1000000},
            "points seen through a plane, and more than lie on it, after which it is forgotten (0: none is)");
  b.real("radius", p.radius, "m", {.above = 0.0}, "voxels farther than this from the sensor are forgotten");
  b.require(p.sample <= p.max_points, "sample", "must not exceed max_points");
}

RecursivePlanes::RecursivePlanes(const Params& params, const BuildContext& context)
    : params_(params),
      thickness_(static_cast<float>(params.thickness)),
      aspect_(least_aspect(1.0)),
      exec_(context.exec),
      inverse_edge_(1.0 / params.voxel),
      pool_(static_cast<std::size_t>(params.sample)),
      lies_on_(static_cast<std::size_t>(params.sample)) {}

/// eq. NOI-2. What was too thick before may be a plane now: voxels without one begin again. What is one stays one.
void RecursivePlanes::set_noise_scale(double scale) {
  const float before = std::exchange(thickness_, static_cast<float>(params_.thickness * scale));
  aspect_ = least_aspect(scale);
  if (thickness_ <= before) return;
  for (std::uint32_t number = 0; number < roots_.size(); ++number)
    if (roots_[number].in_use) judge_again(roots_[number].node);
}

void RecursivePlanes::judge_again(Node& node) {
  if (node.kind == Kind::mixed) open_again(node);
  node.attempts = 0;
  if (node.children == kNone) return;
  for (std::uint32_t i = 0; i < 8; ++i) judge_again(nodes_[node.children + i]);
}

Vec3 RecursivePlanes::corner(const VoxelCell& cell) const {
  return params_.voxel * (Vec3(cell.x, cell.y, cell.z) - kGridOffset);
}

void RecursivePlanes::correspond(std::span<const Vec3> queries, const MapQuery& query, Neighbours& out) const {
  find_no_neighbours(queries, query, out);
}

void RecursivePlanes::surfaces(std::span<const Vec3> queries, const MapQuery& query, std::span<Surface> out) const {
  exec_.for_ranges(queries.size(), kSurfacesPerChunk, [&](std::size_t begin, std::size_t end, std::size_t) {
    for (std::size_t i = begin; i < end; ++i) out[i] = surface(queries[i], query);
  });
}

/// Of the planes at the query that face it, the coarsest that it lies on; if it lies on none, the nearest. eq. MAP-9.
Surface RecursivePlanes::surface(const Vec3& query, const MapQuery& how) const {
  const auto cell = cell_of(query + params_.voxel * kGridOffset, inverse_edge_);
  const std::uint32_t number = cell ? index_.find(pack(*cell)) : kNone;
  if (number == kNone) return {};
  const Vec3 origin = corner(*cell);
  const Eigen::Vector3f p = (query - origin).cast<float>();
  Eigen::Vector3f view = Eigen::Vector3f::Zero(), low = Eigen::Vector3f::Zero();
  if (how.viewpoint) view = (query - *how.viewpoint).cast<float>().normalized();
  const Node* found = nullptr;
  float nearest = 0, edge = static_cast<float>(params_.voxel);
  for (const Node* node = &roots_[number].node;;) {
    if (node->kind == Kind::plane && node->stamp <= how.max_stamp && node->plane.from_behind(view) <= kGrazing) {
      const float distance = std::abs(node->plane.distance(p));
      if (found == nullptr || distance < nearest) std::tie(found, nearest) = std::tuple(node, distance);
      if (distance <= kOwn * thickness_) break;
    }
    if (node->children == kNone) break;
    edge *= 0.5F;
    node = &nodes_[node->children + descend(p, edge, low)];
  }
  if (found == nullptr) return {};
  Surface surface;
  surface.normal = found->plane.normal().cast<double>().normalized();
  surface.anchor = origin + found->plane.mean().cast<double>();
  surface.quality = found->plane.quality(p, params_.doubt);
  surface.valid = true;
  surface.owner = found;
  return surface;
}

std::uint32_t RecursivePlanes::root_at(const VoxelCell& cell) {
  std::uint32_t number = index_.find(pack(cell));
  if (number != kNone) return number;
  number = roots_.take();
  Root& root = roots_[number];
  root.cell = cell;
  root.in_use = true;
  index_.insert(pack(cell), number);
  return number;
}

InsertCount RecursivePlanes::insert(std::span<const WorldPoint> points, std::uint32_t stamp) {
  stamp_ = stamp;
  InsertCount count{points.size(), 0};
  for (const WorldPoint& point : points) {
    const auto cell = cell_of(point.p_W + params_.voxel * kGridOffset, inverse_edge_);
    if (!cell) continue;
    const Seen seen{(point.p_W - corner(*cell)).cast<float>(), point.view};
    Place place;
    place.edge = static_cast<float>(params_.voxel);
    count.inserted += add(roots_[root_at(*cell)].node, place, seen) ? 1U : 0U;
  }
  return count;
}

/// Whether the point changed something. eq. MAP-9.
bool RecursivePlanes::add(Node& node, const Place& place, const Seen& seen) {
  switch (node.kind) {
    case Kind::open:
      keep(node, seen);
      if (node.count == static_cast<std::uint16_t>(params_.sample)) judge(node, place);
      return true;
    case Kind::plane:
      if (belongs(node.plane, seen)) return add_to_plane(node, seen);
      if (params_.reopen > 0 && seen_through(node.plane, seen)) {
        ++node.through;
        if (falsified(node)) {
          ++reopened_;
          open_again(node);
          keep(node, seen);
          return true;
        }
      }
      return hand_on(node, place, seen);
    case Kind::mixed:
      return hand_on(node, place, seen);
  }
  return false;
}

bool RecursivePlanes::add_to_plane(Node& node, const Seen& seen) {
  ++node.on;
  if (node.plane.count() >= static_cast<std::uint32_t>(params_.max_points)) return false;
  node.plane.add(seen.p, seen.view.toward());
  if (node.plane.count() < node.plane.next_fit()) return true;
  if (!node.plane.fit(thickness_, aspect_, params_.voxel)) open_again(node);  // it was none
  return true;
}

bool RecursivePlanes::belongs(const SampledPlane& plane, const Seen& seen) const {
  return std::abs(plane.distance(seen.p)) <= kOwn * thickness_ && plane.from_behind(seen.view.vector()) <= kGrazing;
}

/// A point behind the plane whose ray meets the plane where its points are.
bool RecursivePlanes::seen_through(const SampledPlane& plane, const Seen& seen) const {
  if (!plane.sided() || seen.view.none()) return false;
  const Eigen::Vector3f view = seen.view.vector();
  const float into = -plane.from_behind(view), depth = -plane.distance(seen.p);
  if (into <= kGrazing || depth <= kOwn * thickness_) return false;
  return plane.reach(seen.p - view * (depth / into)) <= kInside;
}

/// Both counts are halved once they are many, so that what was true long ago does not outweigh what is.
bool RecursivePlanes::falsified(Node& node) const {
  const auto enough = static_cast<std::uint32_t>(params_.reopen);
  if (node.through >= enough && node.through > node.on) return true;
  if (node.through + node.on >= 8 * enough) {
    node.through /= 2;
    node.on /= 2;
  }
  return false;
}

void RecursivePlanes::open_again(Node& node) {
  node.kind = Kind::open;
  node.plane.clear();
  node.on = node.through = 0;
  node.count = 0;
}

void RecursivePlanes::keep(Node& node, const Seen& seen) {
  if (node.sample.capacity == 0) {
    node.sample = pool_.take(static_cast<std::size_t>(params_.sample));
    node.count = 0;
  }
  const std::size_t i = node.count++;
  node.sample.x[i] = seen.p.x();
  node.sample.y[i] = seen.p.y();
  node.sample.z[i] = seen.p.z();
  node.sample.order[i] = std::bit_cast<std::uint16_t>(seen.view);
}

/// Looks for the plane of a full sample, keeps it, and hands the others on.
void RecursivePlanes::judge(Node& node, const Place& place) {
  const Chunk sample = std::exchange(node.sample, {});
  const std::size_t count = std::exchange(node.count, 0);
  const auto seen = [&](std::size_t i) {
    return Seen{{sample.x[i], sample.y[i], sample.z[i]},
                std::bit_cast<PackedDirection>(static_cast<std::uint16_t>(sample.order[i]))};
  };
  // The same points in the same voxel have the same sample wherever they lie in memory.
  const auto seed = mixed(std::bit_cast<std::uint32_t>(sample.x[0])) ^ static_cast<std::uint64_t>(place.level);
  std::vector<std::uint8_t>& lies_on = lies_on_;
  const std::size_t near = most_common_plane(sample, count, kOwn * thickness_, seed, lies_on);
  bool found = static_cast<double>(near) >= params_.share * static_cast<double>(count);
  if (found) {
    for (std::size_t i = 0; i < count; ++i)
      if (lies_on[i] != 0) node.plane.add(seen(i).p, seen(i).view.toward());
    found = node.plane.fit(thickness_, aspect_, params_.voxel);
  }
  if (found) {
    node.kind = Kind::plane;
    node.stamp = stamp_;
    node.on = static_cast<std::uint32_t>(near);
  } else {
    node.plane.clear();
    if (place.level + 1 < params_.levels || ++node.attempts == kAttempts) node.kind = Kind::mixed;
  }
  // lies_on_ is used again by the voxels below: what is handed on is listed first.
  std::vector<Seen> others;
  for (std::size_t i = 0; i < count; ++i)
    if (!found || lies_on[i] == 0) others.push_back(seen(i));
  pool_.give_back(sample);
  for (const Seen& other : others) hand_on(node, place, other);
}

bool RecursivePlanes::hand_on(Node& node, const Place& place, const Seen& seen) {
  if (place.level + 1 >= params_.levels) return false;
  if (node.children == kNone) node.children = nodes_.take();
  Place below = place;
  below.edge *= 0.5F;
  ++below.level;
  const std::uint32_t octant = descend(seen.p, below.edge, below.low);
  return add(nodes_[node.children + octant], below, seen);
}

void RecursivePlanes::release(Node& node) {
  if (node.sample.capacity > 0) pool_.give_back(std::exchange(node.sample, {}));
  if (node.children == kNone) return;
  for (std::uint32_t i = 0; i < 8; ++i) release(nodes_[node.children + i]);
  nodes_.give_back(std::exchange(node.children, kNone));
}

void RecursivePlanes::drop(std::uint32_t number) {
  index_.erase(pack(roots_[number].cell));
  release(roots_[number].node);
  roots_[number].in_use = false;
  roots_.give_back(number);
}

void RecursivePlanes::trim(const Vec3& centre_W) {
  if (!trims_.due(centre_W, params_.voxel)) return;
  for (std::uint32_t number = 0; number < roots_.size(); ++number) {
    if (!roots_[number].in_use) continue;
    const Vec3 relative = centre_W - corner(roots_[number].cell);
    if (squared_distance_to_cube(relative, params_.voxel) > params_.radius * params_.radius) drop(number);
  }
}

void RecursivePlanes::clear() {
  index_.clear();
  pool_.clear();
  roots_.clear();
  nodes_.clear();
  reopened_ = 0;
  trims_.reset();
}

std::size_t RecursivePlanes::memory_bytes() const {
  return sizeof(*this) + index_.memory_bytes() + pool_.memory_bytes() + roots_.memory_bytes() + nodes_.memory_bytes();
}

void RecursivePlanes::visit_planes(const Node& node, const Vec3& low,
                                   const std::function<void(const Vec3&)>& visitor) const {
  if (node.kind == Kind::plane) visitor(low + node.plane.mean().cast<double>());
  if (node.children == kNone) return;
  for (std::uint32_t i = 0; i < 8; ++i) visit_planes(nodes_[node.children + i], low, visitor);
}

void RecursivePlanes::visit(const std::function<void(const Vec3&)>& visitor) const {
  std::vector<const Root*> order;
  for (std::size_t number = 0; number < roots_.size(); ++number)
    if (roots_[number].in_use) order.push_back(&roots_[number]);
  std::sort(order.begin(), order.end(), [](const Root* a, const Root* b) {
    return std::tie(a->cell.x, a->cell.y, a->cell.z) < std::tie(b->cell.x, b->cell.y, b->cell.z);
  });
  for (const Root* root : order) visit_planes(root->node, corner(root->cell), visitor);
}

}  // namespace aslio::plugins
