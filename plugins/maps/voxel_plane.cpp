#include "maps/voxel_plane.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

#include "maps/octant.hpp"

namespace aslio::plugins {

namespace {

constexpr std::size_t kSurfacesPerChunk = 256;
/// Points whose voxels are fetched at once: looking for one after the other is waiting for memory.
constexpr std::size_t kBatch = CellBatch::kSize;
constexpr std::uint32_t kNone = CellIndex::kNone;
/// Points up to which sums of floats err by kRounding, where they may be negative; of more, the error grows as fast as
/// the square of their number at most.
constexpr double kRoundingPoints = 500;
/// Of so many points the sums err by less than what a LiDAR's noise leaves; of a million, they lose whole points.
constexpr double kMaxPoints = 10000;
}  // namespace

void VoxelPlane::describe(config::Binder& b, Params& p) {
  b.real("voxel", p.voxel, "m", {.min = 0.05, .max = 10.0}, "edge of the coarsest voxels");
  b.integer("levels", p.levels, "", {.min = 1, .max = 6}, "levels; each has half the edge of the one above");
  b.integer("min_points", p.min_points, "", {.min = 4, .max = kMaxPoints}, "points a plane needs");
  b.integer("max_points", p.max_points, "", {.min = 4, .max = kMaxPoints}, "points after which a voxel is closed");
  b.real("thickness", p.thickness, "m", {.above = 0.0, .max = 1.0},
         "maximum standard deviation of the points across their plane");
  b.real("doubt", p.doubt, "", {.min = 0.0, .max = 1e6},
         "matches of a plane that share its error: the more, the less a plane of few points counts, or one at its edge "
         "(0: all alike)");
  b.real("radius", p.radius, "m", {.above = 0.0}, "voxels farther than this from the sensor are forgotten");
  b.flag("faces", p.faces, "separate the points by the side of a wall they are seen from");
  b.require(p.min_points <= p.max_points, "min_points", "must not exceed max_points");
}

VoxelPlane::VoxelPlane(const Params& params, const BuildContext& context, double phase)
    : params_(params),
      thickness_(params.thickness),
      aspect_(least_aspect(1.0)),
      offset_(kGridOffset + Vec3::Constant(phase)),
      exec_(context.exec) {}

// `inline` here is for speed: these are asked for every point, and gcc makes calls of them where the linker might need
// them elsewhere (with those of the voxel sampler 0.93 of the time of a run, the same bits).

/// The number of a coarsest voxel, or kNone; starts to load it.
inline std::uint32_t VoxelPlane::fetch_root(std::uint64_t key) const {
  const std::uint32_t root = key != CellBatch::kNoCell ? index_.find(key) : kNone;
  if (root == kNone) return root;
  const Root& found = roots_[root];
  __builtin_prefetch(&found);
  __builtin_prefetch(&found.node.longest);
  return root;
}

/// Starts to load what is below a coarsest voxel at p, where that is no plane.
inline void VoxelPlane::fetch_below(std::uint32_t root, const Eigen::Vector3f& p) const {
  if (root == kNone) return;
  const Node& node = roots_[root].node;
  if (node.planar || node.children == kNone) return;
  Eigen::Vector3f low = Eigen::Vector3f::Zero();
  const Node& below = nodes_[node.children + descend(p, 0.5F * static_cast<float>(params_.voxel), low)];
  __builtin_prefetch(&below);
  __builtin_prefetch(&below.longest);
}

/// Finds and starts to load the voxels of some points.
template <class PointOf>
inline void VoxelPlane::fetch(std::size_t count, const PointOf& point, CellBatch& cells,
                              std::array<std::uint32_t, CellBatch::kSize>& roots) const {
  cells.find(count, point, params_.voxel, offset_);
  for (std::size_t i = 0; i < count; ++i) index_.prefetch(cells.key(i));
  for (std::size_t i = 0; i < count; ++i) roots[i] = fetch_root(cells.key(i));
  for (std::size_t i = 0; i < count; ++i) fetch_below(roots[i], cells.inside(i));
}

Vec3 VoxelPlane::corner(const VoxelCell& cell) const {
  return params_.voxel * (Vec3(cell.x, cell.y, cell.z) - offset_);
}

void VoxelPlane::correspond(std::span<const Vec3> queries, const MapQuery& query, Neighbours& out) const {
  find_no_neighbours(queries, query, out);
}

void VoxelPlane::surfaces(std::span<const Vec3> queries, const MapQuery& query, std::span<Surface> out,
                          QueryShare share) const {
  const std::size_t own = share.size(queries.size());
  exec_.for_ranges(own, kSurfacesPerChunk, [&](std::size_t begin, std::size_t end, std::size_t) {
    CellBatch cells;
    std::array<std::uint32_t, kBatch> roots{};
    for (std::size_t first = begin; first < end; first += kBatch) {
      const std::size_t count = std::min(kBatch, end - first);
      const auto place = [&](std::size_t i) { return share.place(first + i); };
      const auto point = [&](std::size_t i) -> const Vec3& { return queries[place(i)]; };
      fetch(count, point, cells, roots);
      for (std::size_t i = 0; i < count; ++i) out[place(i)] = surface(point(i), cells.inside(i), roots[i], query);
    }
  });
}

/// What `query`, at p in its voxel, meets there.
inline Surface VoxelPlane::surface(const Vec3& query, const Eigen::Vector3f& p, std::uint32_t first,
                                   const MapQuery& how) const {
  if (first == kNone) return {};
  const Root& root = roots_[first];
  const Root* second = root.other == kNone ? nullptr : &roots_[root.other];
  const auto plane = [&](const Root& part) { return plane_at(part, p, how.max_stamp); };
  const Node* node = met(query, how, params_.faces, root, second, plane);
  return node == nullptr ? Surface{} : surface_of(*node, corner(root.cell), p, params_.doubt);
}

/// The plane of the coarsest level at p in this part of its voxel; nullptr if there is none.
inline const VoxelPlane::Node* VoxelPlane::plane_at(const Root& root, const Eigen::Vector3f& p,
                                                    std::uint32_t max_stamp) const {
  Eigen::Vector3f low = Eigen::Vector3f::Zero();
  auto edge = static_cast<float>(params_.voxel);
  for (const Node* node = &root.node;; node = &nodes_[node->children + descend(p, edge, low)]) {
    if (node->planar && node->stamp <= max_stamp) return node;
    if (node->children == kNone) return nullptr;
    edge *= 0.5F;
  }
}

InsertCount VoxelPlane::insert(std::span<const WorldPoint> points, std::uint32_t stamp) {
  last_stamp_ = stamp;
  InsertCount count{points.size(), 0};
  CellBatch cells;
  std::array<std::uint32_t, kBatch> roots{};
  for (std::size_t first = 0; first < points.size(); first += kBatch) {
    const auto batch = points.subspan(first, std::min(kBatch, points.size() - first));
    fetch(
        batch.size(), [&](std::size_t i) -> const Vec3& { return batch[i].p_W; }, cells, roots);
    for (std::size_t i = 0; i < batch.size(); ++i) {
      if (cells.key(i) == CellBatch::kNoCell) continue;
      const std::uint32_t root = roots[i] != kNone ? roots[i] : root_at(cells.key(i), cells.cell(i));
      const Eigen::Vector3f toward = params_.faces ? batch[i].view.toward() : Eigen::Vector3f::Zero();
      const Eigen::Vector3f p = cells.inside(i);
      if (settled(roots_[root], p, toward)) continue;
      ViewSteps view{};
      std::uint32_t part = root;
      if (params_.faces) {
        const Eigen::Vector3f direction = toward.normalized();
        part = part_for(root, p, direction);
        view = steps_of(direction);
      }
      count.inserted += add(part, p, view) ? 1U : 0U;
    }
  }
  for (const Touched& touched : touched_) {
    fit(touched.node == kNone ? roots_[touched.root].node : nodes_[touched.node], stamp);
  }
  for (const Touched& touched : touched_)
    if (touched.node == kNone && roots_[touched.root].other != kNone) unite(touched.root);
  touched_.clear();
  return count;
}

/// Whether p, seen `toward` somewhere (of any length), changes nothing of a voxel whose first part is `first`: it
/// belongs to that, and all that it would be added to is closed.
inline bool VoxelPlane::settled(const Root& first, const Eigen::Vector3f& p, const Eigen::Vector3f& toward) const {
  const Node* node = &first.node;
  Eigen::Vector3f low = Eigen::Vector3f::Zero();
  auto half = static_cast<float>(params_.voxel);
  for (std::int64_t level = 1; closed(*node); ++level) {
    // A margin for rounding: what part_for() asks a unit vector must have the same answer.
    if (node->planar) return !params_.faces || !node->sided || toward.dot(node->normal) < -1e-3F;
    if (level == params_.levels) return !params_.faces || toward.dot(sum_of(first.node.view)) > 16;
    if (node->children == kNone) return false;
    half *= 0.5F;
    node = &nodes_[node->children + descend(p, half, low)];
  }
  return false;
}

std::uint32_t VoxelPlane::root_at(std::uint64_t key, const VoxelCell& cell) {
  std::uint32_t number = index_.find(key);
  if (number != kNone) return number;
  number = take_root(cell);
  index_.insert(key, number);
  return number;
}

std::uint32_t VoxelPlane::take_root(const VoxelCell& cell) {
  const std::uint32_t number = roots_.take();
  Root& root = roots_[number];
  root.cell = cell;
  root.in_use = true;
  return number;
}

/// The part of the voxel that takes a point seen in the direction `view` (unit, or zero). eq. MAP-4.
inline std::uint32_t VoxelPlane::part_for(std::uint32_t first, const Eigen::Vector3f& p, const Eigen::Vector3f& view) {
  const Root& root = roots_[first];
  const Node* plane = plane_at(root, p, std::numeric_limits<std::uint32_t>::max());
  if (is_of_first(plane, root.node, p, view, thickness_)) return first;
  if (root.other == kNone) {
    const std::uint32_t second = take_root(root.cell);
    roots_[second].second = true;
    roots_[first].other = second;
  }
  return roots_[first].other;
}

/// Makes one of the two parts of a voxel if they are of one face: one that was seen under angles too far apart before
/// its plane was known. eq. MAP-4.
void VoxelPlane::unite(std::uint32_t first) {
  Node& node = roots_[first].node;
  const std::uint32_t second = roots_[first].other;
  const Node& rest = roots_[second].node;
  if (!node.planar || !node.sided || rest.count == 0 || sum_of(rest.view).dot(node.normal) > 0) return;
  const Vec3 normal = node.normal.cast<double>(), mean = rest.sum.cast<double>() / rest.count;
  Mat3 squares;
  const auto& s = rest.squares;
  squares << s[0], s[1], s[2], s[1], s[3], s[4], s[2], s[4], s[5];
  const double off = normal.dot(mean - node.mean.cast<double>());
  const double across = normal.dot(squares * normal) / rest.count - std::pow(normal.dot(mean), 2);
  if (off * off + across > thickness_ * thickness_) return;
  Node both = node;
  both.count += rest.count;
  both.sum += rest.sum;
  for (std::size_t i = 0; i < s.size(); ++i) both.squares[i] += s[i];
  both.next_fit = 0;
  fit(both, node.stamp);
  if (!both.planar) return;
  node = both;
  release(second);
  roots_[first].other = kNone;
}

/// Adds a point to its voxels of all levels; false when those are closed.
inline bool VoxelPlane::add(std::uint32_t root, const Eigen::Vector3f& p, const ViewSteps& view) {
  std::uint32_t number = kNone;
  Eigen::Vector3f low = Eigen::Vector3f::Zero();
  auto half = static_cast<float>(params_.voxel);
  bool added = false;
  for (std::int64_t level = 0;; ++level) {
    Node& node = number == kNone ? roots_[root].node : nodes_[number];
    const bool open = !closed(node);
    if (open) {
      if (!node.touched) touched_.push_back({root, number});
      node.touched = true;
      sum_up(node, p, view);
      added = true;
    }
    // Parts of a plane are not asked for, and those of a voxel with few points tell nothing.
    if (node.planar || level + 1 == params_.levels) return added;
    if (node.children == kNone) {
      if (node.next_fit == 0) return added;
      const std::uint32_t children = nodes_.take();
      (number == kNone ? roots_[root].node : nodes_[number]).children = children;
    }
    half *= 0.5F;
    number = (number == kNone ? roots_[root].node : nodes_[number]).children + descend(p, half, low);
  }
}

inline void VoxelPlane::sum_up(Node& node, const Eigen::Vector3f& p, const ViewSteps& view) {
  count_point(node, view);
  node.sum += p;
  std::size_t k = 0;
  for (int i = 0; i < 3; ++i)
    for (int j = i; j < 3; ++j) node.squares[k++] += p[i] * p[j];
}

/// eq. MAP-1.
void VoxelPlane::fit(Node& node, std::uint32_t stamp) {
  node.touched = false;
  if (node.count < static_cast<std::uint32_t>(params_.min_points)) return;
  if (node.count < node.next_fit && !closed(node)) return;
  const double n = node.count;
  node.next_fit = static_cast<std::uint32_t>(kRefit * n) + 1;
  const Vec3 mean = node.sum.cast<double>() / n;
  const auto& s = node.squares;
  Eigen::Matrix3f sums;
  sums << s[0], s[1], s[2], s[1], s[3], s[4], s[2], s[4], s[5];
  const Mat3 covariance = sums.cast<double>() / n - mean * mean.transpose();
  const double rounding = kRounding * std::max(1.0, std::pow(n / kRoundingPoints, 2));
  const PlaneShape shape = plane_shape(covariance, {thickness_, aspect_, rounding * params_.voxel * params_.voxel});
  set_plane(node, shape, mean, stamp);
  if (shape.planar && closed(node)) give_back(node);  // its parts will never be asked for
}

/// eq. NOI-2. What was too thick before may be a plane now. What is one stays one: of a plane that was closed, the
/// parts are gone.
void VoxelPlane::set_noise_scale(double scale) {
  const double before = std::exchange(thickness_, params_.thickness * scale);
  aspect_ = least_aspect(scale);
  if (thickness_ <= before) return;
  for (std::uint32_t number = 0; number < roots_.size(); ++number)
    if (roots_[number].in_use) judge_again(roots_[number].node);
}

void VoxelPlane::judge_again(Node& node) {
  if (node.planar) return;
  if (node.next_fit > 0) {
    node.next_fit = 0;
    fit(node, last_stamp_);
  }
  if (node.planar || node.children == kNone) return;
  for (std::uint32_t i = 0; i < 8; ++i) judge_again(nodes_[node.children + i]);
}

/// The blocks below a node. One that is yet to be fitted, being below, must not give its own back again.
void VoxelPlane::give_back(Node& node) {
  if (node.children == kNone) return;
  for (std::uint32_t i = 0; i < 8; ++i) give_back(nodes_[node.children + i]);
  nodes_.give_back(node.children);
  node.children = kNone;
}

/// Both parts of a voxel, by the number of the first.
void VoxelPlane::drop(std::uint32_t first) {
  index_.erase(pack(roots_[first].cell));
  for (const std::uint32_t number : {first, roots_[first].other})
    if (number != kNone) release(number);
}

void VoxelPlane::release(std::uint32_t root) {
  give_back(roots_[root].node);
  roots_[root].in_use = false;
  roots_.give_back(root);
}

void VoxelPlane::trim(const Vec3& centre_W) {
  if (!trims_.due(centre_W, params_.voxel)) return;
  for (std::uint32_t number = 0; number < roots_.size(); ++number) {
    if (!roots_[number].in_use || roots_[number].second) continue;
    const Vec3 relative = centre_W - corner(roots_[number].cell);
    if (squared_distance_to_cube(relative, params_.voxel) > params_.radius * params_.radius) drop(number);
  }
}

void VoxelPlane::clear() {
  index_.clear();
  roots_.clear();
  nodes_.clear();
  last_stamp_ = 0;
  trims_.reset();
}

std::size_t VoxelPlane::memory_bytes() const {
  return index_.memory_bytes() + roots_.memory_bytes() + nodes_.memory_bytes() + touched_.capacity() * sizeof(Touched);
}

void VoxelPlane::visit(const std::function<void(const Vec3&)>& visitor) const {
  std::vector<const Root*> order;
  for (std::size_t number = 0; number < roots_.size(); ++number)
    if (roots_[number].in_use) order.push_back(&roots_[number]);
  std::sort(order.begin(), order.end(), [](const Root* a, const Root* b) {
    return std::tie(a->cell.x, a->cell.y, a->cell.z, a->second) < std::tie(b->cell.x, b->cell.y, b->cell.z, b->second);
  });
  for (const Root* root : order) {
    visitor(corner(root->cell) + root->node.sum.cast<double>() / root->node.count);
  }
}

}  // namespace aslio::plugins
