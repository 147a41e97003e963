#include "maps/bundle_voxels.hpp"

#include <algorithm>
#include <limits>
#include <tuple>

#include "maps/octant.hpp"

namespace aslio::plugins {

namespace {

constexpr std::size_t kSurfacesPerChunk = 256;
constexpr std::size_t kBatch = CellBatch::kSize;
constexpr std::uint32_t kNone = CellIndex::kNone;
constexpr std::uint32_t kAll = std::numeric_limits<std::uint32_t>::max();
}  // namespace

BundleVoxels::BundleVoxels(const Params& params, const BuildContext& context, double phase)
    : params_(params),
      thickness_(params.thickness),
      aspect_(least_aspect(1.0)),
      offset_(kGridOffset + Vec3::Constant(phase)),
      exec_(context.exec) {}

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
                            QueryShare share) const {
  const std::size_t own = share.size(queries.size());
  exec_.for_ranges(own, kSurfacesPerChunk, [&](std::size_t begin, std::size_t end, std::size_t) {
    CellBatch cells;
    std::array<std::uint32_t, kBatch> roots{};
    for (std::size_t first = begin; first < end; first += kBatch) {
      const std::size_t count = std::min(kBatch, end - first);
      const auto place = [&](std::size_t i) { return share.place(first + i); };
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
  const Root* second = root.other == kNone ? nullptr : &roots_[root.other];
  const auto plane = [&](const Root& part) { return plane_at(part, p, how.max_stamp); };
  const Node* node = met(query, how, params_.faces, root, second, plane);
  return node == nullptr ? Surface{} : surface_of(*node, corner(root.cell), p, params_.doubt);
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
  const std::uint32_t number = roots_.take();
  Root& root = roots_[number];
  root.cell = cell;
  root.in_use = true;
  return number;
}

/// The part of the voxel that takes a point seen in the direction `view` (unit, or zero). eq. MAP-4.
std::uint32_t BundleVoxels::part_for(std::uint32_t first, const Eigen::Vector3f& p, const Eigen::Vector3f& view) {
  const Root& root = roots_[first];
  if (is_of_first(plane_at(root, p, kAll), root.node, p, view, thickness_)) return first;
  if (root.other == kNone) {
    const std::uint32_t second = take_root(root.cell);
    roots_[second].second = true;
    roots_[first].other = second;
  }
  return roots_[first].other;
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
  if (root.node.children == kNone) root.node.children = nodes_.take();
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
  count_point(node, view);
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
  set_plane(node, shape, mean, stamp);
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
  nodes_.give_back(node.children);
  node.children = kNone;
}

void BundleVoxels::release(std::uint32_t number) {
  Root& root = roots_[number];
  give_back(root.node);
  pool_.leave(root.node.clusters, kAll, [](const ClusterPool::Cluster&) {});
  root.in_use = false;
  roots_.give_back(number);
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
  nodes_.clear();
  active_.clear();
  pool_.clear();
  last_stamp_ = 0;
  trims_.reset();
}

std::size_t BundleVoxels::memory_bytes() const {
  return index_.memory_bytes() + roots_.memory_bytes() + nodes_.memory_bytes() + pool_.memory_bytes() +
         active_.capacity() * sizeof(std::uint32_t) + touched_.capacity() * sizeof(Touched);
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
