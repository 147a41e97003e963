#include "maps/bundle_voxels.hpp"

#include <algorithm>
#include <limits>
#include <tuple>

#include "maps/octant.hpp"
#include "maps/plane_shape.hpp"

namespace aslio::plugins {

namespace {

constexpr std::size_t kSurfacesPerChunk = 256;
constexpr std::size_t kBatch = CellBatch::kSize;
constexpr std::uint32_t kNone = CellIndex::kNone;
constexpr std::uint32_t kAll = std::numeric_limits<std::uint32_t>::max();
/// Distance from a plane within which a point seen along it is one of its own, in thicknesses.
constexpr float kOwn = 2;
/// Of a unit vector, and how many of them a sum of 16 bits holds.
constexpr float kViewSteps = 127;
constexpr std::uint32_t kMaxViews = 256;

Eigen::Vector3f sum_of(const std::array<std::int16_t, 3>& view) { return Eigen::Vector3f(view[0], view[1], view[2]); }

std::array<std::int16_t, 3> steps_of(const Eigen::Vector3f& direction) {
  return {static_cast<std::int16_t>(kViewSteps * direction.x()), static_cast<std::int16_t>(kViewSteps * direction.y()),
          static_cast<std::int16_t>(kViewSteps * direction.z())};
}

}  // namespace

BundleVoxels::BundleVoxels(const Params& params, exec::Executor& exec, double phase)
    : params_(params),
      thickness_(params.thickness),
      aspect_(least_aspect(1.0)),
      offset_(kGridOffset + Vec3::Constant(phase)),
      exec_(exec) {}

Vec3 BundleVoxels::corner(const VoxelCell& cell) const {
  return params_.voxel * (Vec3(cell.x, cell.y, cell.z) - offset_);
}

template <class With>
void BundleVoxels::each_node(Root& root, With with) {
  with(root.node);
  if (root.node.children == kNone) return;
  for (std::uint32_t i = 0; i < 8; ++i) with(nodes_[root.node.children + i]);
}

void BundleVoxels::surfaces(std::span<const Vec3> queries, const MapQuery& query, std::span<Surface> out,
                            std::size_t from, std::size_t step) const {
  const std::size_t own = queries.size() > from ? (queries.size() - from - 1) / step + 1 : 0;
  exec_.for_ranges(own, kSurfacesPerChunk, [&](std::size_t begin, std::size_t end, std::size_t) {
    CellBatch cells;
    std::array<std::uint32_t, kBatch> roots{};
    for (std::size_t first = begin; first < end; first += kBatch) {
      const std::size_t count = std::min(kBatch, end - first);
      const auto place = [&](std::size_t i) { return from + (first + i) * step; };
      const auto point = [&](std::size_t i) -> const Vec3& { return queries[place(i)]; };
      cells.find(count, point, params_.voxel, offset_);
      for (std::size_t i = 0; i < count; ++i) index_.prefetch(cells.key(i));
      for (std::size_t i = 0; i < count; ++i) {
        roots[i] = cells.key(i) == CellBatch::kNoCell ? kNone : index_.find(cells.key(i));
        if (roots[i] != kNone) __builtin_prefetch(&roots_[roots[i]].node.longest);
      }
      for (std::size_t i = 0; i < count; ++i) out[place(i)] = surface(point(i), cells.inside(i), roots[i], query);
    }
  });
}

/// What `query`, at p in its voxel, meets there.
Surface BundleVoxels::surface(const Vec3& query, const Eigen::Vector3f& p, std::uint32_t first,
                              const MapQuery& how) const {
  if (first == kNone) return {};
  const Root& root = roots_[first];
  const Node* node = nullptr;
  if (params_.faces && how.viewpoint) {
    node = facing(root, p, (query - *how.viewpoint).cast<float>().normalized(), how.max_stamp);
  } else {
    node = plane_at(root, p, how.max_stamp);
    if (node == nullptr && root.other != kNone) node = plane_at(roots_[root.other], p, how.max_stamp);
  }
  if (node == nullptr) return {};
  Surface found;
  found.normal = node->normal.cast<double>().normalized();
  found.anchor = corner(root.cell) + node->mean.cast<double>();
  found.quality = plane_quality(node->count, params_.doubt, p - node->mean, node->normal, node->along, node->longest,
                                node->shortest);
  found.valid = true;
  found.owner = node;
  return found;
}

/// The plane of the coarser level at p in this part of its voxel; nullptr if there is none.
const BundleVoxels::Node* BundleVoxels::plane_at(const Root& root, const Eigen::Vector3f& p,
                                                 std::uint32_t max_stamp) const {
  if (root.node.planar && root.node.stamp <= max_stamp) return &root.node;
  if (root.node.children == kNone) return nullptr;
  Eigen::Vector3f low = Eigen::Vector3f::Zero();
  const Node& part = nodes_[root.node.children + descend(p, 0.5F * static_cast<float>(params_.voxel), low)];
  return part.planar && part.stamp <= max_stamp ? &part : nullptr;
}

/// Of the planes at p in both parts, one that faces who looks in the direction `view`; else one that is seen along it.
/// eq. MAP-4.
const BundleVoxels::Node* BundleVoxels::facing(const Root& first, const Eigen::Vector3f& p, const Eigen::Vector3f& view,
                                               std::uint32_t max_stamp) const {
  const Node* along = nullptr;
  for (const Root* root = &first;; root = &roots_[first.other]) {
    const Node* node = plane_at(*root, p, max_stamp);
    if (node != nullptr) {
      const float away = node->sided ? view.dot(node->normal) : 0;
      if (away <= 0) return node;
      if (away <= kGrazing && along == nullptr) along = node;
    }
    if (root != &first || first.other == kNone) return along;
  }
}

InsertCount BundleVoxels::insert(std::span<const WorldPoint> points, std::uint32_t stamp, std::uint32_t keyframe) {
  last_stamp_ = stamp;
  InsertCount count{points.size(), 0};
  CellBatch cells;
  for (std::size_t first = 0; first < points.size(); first += kBatch) {
    const auto batch = points.subspan(first, std::min(kBatch, points.size() - first));
    const auto point = [&](std::size_t i) -> const Vec3& { return batch[i].p_W; };
    cells.find(batch.size(), point, params_.voxel, offset_);
    for (std::size_t i = 0; i < batch.size(); ++i) index_.prefetch(cells.key(i));
    for (std::size_t i = 0; i < batch.size(); ++i) {
      if (cells.key(i) == CellBatch::kNoCell) continue;
      std::uint32_t root = index_.find(cells.key(i));
      if (root == kNone) {
        root = take_root(cells.cell(i));
        index_.insert(cells.key(i), root);
      }
      ViewSteps view{};
      if (params_.faces) {
        const Eigen::Vector3f direction = batch[i].view.vector();
        root = part_for(root, cells.inside(i), direction);
        view = steps_of(direction);
      }
      count.inserted += add(root, cells.inside(i), view, keyframe) ? 1U : 0U;
    }
  }
  for (const Touched& touched : touched_) {
    Node& node = touched.node == kNone ? roots_[touched.root].node : nodes_[touched.node];
    node.touched = false;
    if (node.count >= node.next_fit) fit(node, stamp);
  }
  touched_.clear();
  return count;
}

std::uint32_t BundleVoxels::take_root(const VoxelCell& cell) {
  std::uint32_t number = kNone;
  if (free_roots_.empty()) {
    number = static_cast<std::uint32_t>(roots_.grow(1));
  } else {
    number = free_roots_.back();
    free_roots_.pop_back();
  }
  Root& root = roots_[number];
  root = {};
  root.cell = cell;
  root.in_use = true;
  ++roots_in_use_;
  return number;
}

/// The part of the voxel that takes a point seen in the direction `view` (unit, or zero). eq. MAP-4.
std::uint32_t BundleVoxels::part_for(std::uint32_t first, const Eigen::Vector3f& p, const Eigen::Vector3f& view) {
  const Root& root = roots_[first];
  const Node* node = plane_at(root, p, kAll);
  if (node != nullptr) {
    const float away = node->sided ? view.dot(node->normal) : 0;
    const float distance = std::abs((p - node->mean).dot(node->normal));
    if (away <= 0 || (away <= kGrazing && distance <= kOwn * static_cast<float>(thickness_))) return first;
  } else if (view.dot(sum_of(root.node.view)) >= 0) {
    return first;
  }
  if (root.other == kNone) {
    const std::uint32_t second = take_root(root.cell);
    roots_[second].second = true;
    roots_[first].other = second;
  }
  return roots_[first].other;
}

std::uint32_t BundleVoxels::take_children() {
  if (free_blocks_.empty()) return static_cast<std::uint32_t>(nodes_.grow(8));
  const std::uint32_t first = free_blocks_.back();
  free_blocks_.pop_back();
  for (std::uint32_t i = 0; i < 8; ++i) nodes_[first + i] = {};
  return first;
}

/// Adds a point to its voxels of both levels; false when those take no more.
bool BundleVoxels::add(std::uint32_t number, const Eigen::Vector3f& p, const ViewSteps& view, std::uint32_t keyframe) {
  Root& root = roots_[number];
  if (!root.active) {
    root.active = true;
    active_.push_back(number);
  }
  const auto touch = [&](Node& node, std::uint32_t which) {
    if (!node.touched) touched_.push_back({number, which});
    node.touched = true;
  };
  bool added = take(root.node, p, view, keyframe);
  if (added) touch(root.node, kNone);
  // Parts of a plane are not asked for, and those of a voxel with few points tell nothing.
  if (root.node.planar || root.node.next_fit == 0) return added;
  if (root.node.children == kNone) root.node.children = take_children();
  Eigen::Vector3f low = Eigen::Vector3f::Zero();
  const std::uint32_t part = root.node.children + descend(p, 0.5F * static_cast<float>(params_.voxel), low);
  if (take(nodes_[part], p, view, keyframe)) {
    touch(nodes_[part], part);
    added = true;
  }
  return added;
}

/// A closed plane takes points too: they tell where their keyframe is. A closed voxel without plane does not.
bool BundleVoxels::take(Node& node, const Eigen::Vector3f& p, const ViewSteps& view, std::uint32_t keyframe) {
  if (node.closed && !node.planar) return false;
  ClusterPool::Cluster& cluster = pool_.of(node.clusters, keyframe);
  if (cluster.points.n >= static_cast<double>(params_.keyframe_points)) return false;
  cluster.points.add(p.cast<double>());
  if (node.closed) return true;
  if (++node.count <= kMaxViews) {
    for (std::size_t axis = 0; axis < 3; ++axis)
      node.view[axis] = static_cast<std::int16_t>(node.view[axis] + view[axis]);
  }
  return true;
}

/// eq. MAP-1, of all points that it holds. One that is closed is fitted once more, to what has settled.
void BundleVoxels::fit(Node& node, std::uint32_t stamp) {
  if (node.count < static_cast<std::uint32_t>(params_.min_points)) return;
  PointMoments all = node.settled;
  if (!node.closed) pool_.each(node.clusters, [&](const ClusterPool::Cluster& cluster) { all += cluster.points; });
  node.next_fit = static_cast<std::uint32_t>(kRefit * node.count) + 1;
  const Vec3 mean = all.mean();
  const PlaneShape shape =
      plane_shape(all.scatter() / all.n, {thickness_, aspect_, 1e-9 * params_.voxel * params_.voxel});
  if (shape.planar && !node.planar) node.stamp = stamp;
  node.planar = shape.planar;
  node.mean = mean.cast<float>();
  node.normal = shape.normal.cast<float>();
  const float away = sum_of(node.view).dot(node.normal);
  node.sided = away != 0;
  if (away > 0) node.normal = -node.normal;
  node.along = shape.along.cast<float>();
  node.longest = static_cast<float>(shape.variance[2]);
  node.shortest = static_cast<float>(shape.variance[1]);
}

void BundleVoxels::each_plane(const std::function<void(const Seen&)>& take) const {
  std::vector<const ClusterPool::Cluster*> clusters;
  const auto tell = [&](const Root& root, const Node& node) {
    if (!node.planar || node.clusters == ClusterPool::kNone) return;
    clusters.clear();
    pool_.each(node.clusters, [&](const ClusterPool::Cluster& cluster) { clusters.push_back(&cluster); });
    take({corner(root.cell), node.normal.cast<double>(), node.mean.cast<double>(), &node.settled,
          static_cast<double>(node.settled_keyframes), clusters});
  };
  for (const std::uint32_t number : active_) {
    const Root& root = roots_[number];
    tell(root, root.node);
    if (root.node.planar || root.node.children == kNone) continue;
    for (std::uint32_t i = 0; i < 8; ++i) tell(root, nodes_[root.node.children + i]);
  }
}

void BundleVoxels::move(std::uint32_t first, std::span<const Pose> moves, std::uint32_t stamp) {
  for (const std::uint32_t number : active_) {
    Root& root = roots_[number];
    const Vec3 origin = corner(root.cell);
    each_node(root, [&](Node& node) {
      if (node.clusters == ClusterPool::kNone) return;
      pool_.each(node.clusters, [&](ClusterPool::Cluster& cluster) {
        const std::size_t i = cluster.keyframe - first;
        if (i >= moves.size()) return;
        cluster.points = cluster.points.moved({moves[i].R, moves[i] * origin - origin});
      });
      if (!node.closed && node.next_fit > 0) fit(node, stamp);
    });
  }
}

void BundleVoxels::settle(Node& node, std::uint32_t until, std::uint32_t stamp) {
  pool_.leave(node.clusters, until, [&](const ClusterPool::Cluster& cluster) {
    if (node.closed) return;
    node.settled += cluster.points;
    ++node.settled_keyframes;
  });
  if (node.closed || node.settled.n < static_cast<double>(params_.max_points)) return;
  node.closed = true;
  node.count = static_cast<std::uint32_t>(node.settled.n);
  fit(node, stamp);
}

void BundleVoxels::settle(std::uint32_t until, std::uint32_t stamp) {
  std::size_t kept = 0;
  for (const std::uint32_t number : active_) {
    Root& root = roots_[number];
    bool seen = false;
    each_node(root, [&](Node& node) {
      settle(node, until, stamp);
      seen = seen || node.clusters != ClusterPool::kNone;
    });
    if (root.node.closed && root.node.planar) give_back(root.node);  // its parts will never be asked for
    root.active = seen;
    if (seen) active_[kept++] = number;
  }
  active_.resize(kept);
}

/// eq. NOI-2. What was too thick before may be a plane now; what is one stays one until it is fitted again.
void BundleVoxels::set_noise_scale(double scale) {
  const double before = thickness_;
  thickness_ = params_.thickness * scale;
  aspect_ = least_aspect(scale);
  if (thickness_ <= before) return;
  for (std::uint32_t number = 0; number < roots_.size(); ++number) {
    if (!roots_[number].in_use) continue;
    each_node(roots_[number], [&](Node& node) {
      if (!node.planar && node.next_fit > 0) fit(node, last_stamp_);
    });
  }
}

void BundleVoxels::give_back(Node& node) {
  if (node.children == kNone) return;
  for (std::uint32_t i = 0; i < 8; ++i)
    pool_.leave(nodes_[node.children + i].clusters, kAll, [](const ClusterPool::Cluster&) {});
  free_blocks_.push_back(node.children);
  node.children = kNone;
}

void BundleVoxels::release(std::uint32_t number) {
  Root& root = roots_[number];
  give_back(root.node);
  pool_.leave(root.node.clusters, kAll, [](const ClusterPool::Cluster&) {});
  root.in_use = false;
  free_roots_.push_back(number);
  --roots_in_use_;
}

void BundleVoxels::trim(const Vec3& centre_W) {
  if (!trims_.due(centre_W, params_.voxel)) return;
  for (std::uint32_t number = 0; number < roots_.size(); ++number) {
    const Root& root = roots_[number];
    if (!root.in_use || root.second) continue;
    const Vec3 relative = centre_W - corner(root.cell);
    if (squared_distance_to_cube(relative, params_.voxel) <= params_.radius * params_.radius) continue;
    index_.erase(pack(root.cell));
    const std::uint32_t other = root.other;
    release(number);
    if (other != kNone) release(other);
  }
  std::erase_if(active_, [&](std::uint32_t number) { return !roots_[number].in_use; });
}

void BundleVoxels::clear() {
  index_.clear();
  roots_.clear();
  free_roots_.clear();
  nodes_.clear();
  free_blocks_.clear();
  active_.clear();
  pool_.clear();
  roots_in_use_ = 0;
  trims_.reset();
}

std::size_t BundleVoxels::memory_bytes() const {
  return index_.memory_bytes() + roots_.memory_bytes() + nodes_.memory_bytes() + pool_.memory_bytes() +
         (free_roots_.capacity() + free_blocks_.capacity() + active_.capacity()) * sizeof(std::uint32_t) +
         touched_.capacity() * sizeof(Touched);
}

void BundleVoxels::visit(const std::function<void(const Vec3&)>& visitor) const {
  std::vector<const Root*> order;
  for (std::size_t number = 0; number < roots_.size(); ++number)
    if (roots_[number].in_use) order.push_back(&roots_[number]);
  std::sort(order.begin(), order.end(), [](const Root* a, const Root* b) {
    return std::tie(a->cell.x, a->cell.y, a->cell.z, a->second) < std::tie(b->cell.x, b->cell.y, b->cell.z, b->second);
  });
  for (const Root* root : order) {
    PointMoments all = root->node.settled;
    if (!root->node.closed)
      pool_.each(root->node.clusters, [&](const ClusterPool::Cluster& cluster) { all += cluster.points; });
    visitor(corner(root->cell) + all.mean());
  }
}

}  // namespace aslio::plugins
