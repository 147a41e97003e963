#include "maps/point_tree.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

namespace aslio::plugins {

namespace {

/// Squared distances of points are floats with a relative error of some 1e-7, those to boxes and planes are doubles:
/// a box is left out only if it is farther than the bound by more than both errors.
constexpr double kShrink = 1.0 - 1e-6;

float round_down(double v) {
  const auto f = static_cast<float>(v);
  return static_cast<double>(f) > v ? std::nextafter(f, -HUGE_VALF) : f;
}

float round_up(double v) {
  const auto f = static_cast<float>(v);
  return static_cast<double>(f) < v ? std::nextafter(f, HUGE_VALF) : f;
}

/// Squared distance [m^2] from the origin of `d` to the box d + [low, high].
double box_squared(const Vec3& d, const std::array<float, 3>& low, const std::array<float, 3>& high) {
  double sum = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double at = d[static_cast<Eigen::Index>(axis)];
    const double outside = std::max({0.0, at + static_cast<double>(low[axis]), -at - static_cast<double>(high[axis])});
    sum += outside * outside;
  }
  return sum;
}

Vec3 to_vec(const std::array<float, 3>& v) { return Eigen::Vector3f(v[0], v[1], v[2]).cast<double>(); }

}  // namespace

std::uint32_t PointTree::take_node(const TreePoint& point, int axis, std::uint32_t parent) {
  std::uint32_t number = static_cast<std::uint32_t>(nodes_.size());
  if (free_.empty()) {
    // Grows by a quarter: memory stays near what is needed, and copying is still amortised.
    if (nodes_.size() == nodes_.capacity()) {
      const std::size_t room = std::max<std::size_t>(1024, nodes_.size() + nodes_.size() / 4);
      nodes_.reserve(room);
      tallies_.reserve(room);
    }
    nodes_.emplace_back();
    tallies_.emplace_back();
  } else {
    number = free_.back();
    free_.pop_back();
  }
  Node& node = nodes_[number] = Node{};
  node.p = point.p;
  node.stamp = point.stamp;
  node.feature = point.feature;
  node.axis = static_cast<std::uint8_t>(axis) & 3U;
  tallies_[number] = {.parent = parent, .order = point.order};
  return number;
}

void PointTree::drop(std::uint32_t number) {
  nodes_[number].deleted = true;
  nodes_[number].dropped = true;
  tallies_[number].deleted = tallies_[number].size;
}

void PointTree::hand_down(std::uint32_t number) {
  for (const std::uint32_t child : nodes_[number].child) {
    if (child != kNone) drop(child);
  }
  nodes_[number].dropped = false;
}

bool PointTree::out_of_shape(std::uint32_t number) const {
  const Tally& tally = tallies_[number];
  if (tally.size < kSmall) return false;
  if (tally.deleted > deleted_ * tally.size) return true;
  const double allowed = balance_ * (tally.size - 1);
  const auto heavy = [&](std::uint32_t child) { return child != kNone && tallies_[child].size > allowed; };
  return heavy(nodes_[number].child[0]) || heavy(nodes_[number].child[1]);
}

void PointTree::mark_due(std::uint32_t number) {
  nodes_[number].due = true;
  for (std::uint32_t above = tallies_[number].parent; above != kNone && !nodes_[above].due_below;
       above = tallies_[above].parent) {
    nodes_[above].due_below = true;
  }
}

void PointTree::insert(const TreePoint& point) {
  if (root_ == kNone) {
    root_ = take_node(point, 0, kNone);
    return;
  }
  std::uint32_t number = root_, unbalanced = kNone;
  for (int depth = 2;; ++depth) {
    if (nodes_[number].dropped) hand_down(number);
    Node& node = nodes_[number];
    Tally& tally = tallies_[number];
    ++tally.size;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto i = static_cast<Eigen::Index>(axis);
      const double relative = point.p[i] - node.p[i];
      if (relative < static_cast<double>(node.low[axis])) node.low[axis] = round_down(relative);
      if (relative > static_cast<double>(node.high[axis])) node.high[axis] = round_up(relative);
    }
    const std::size_t side = point.p[node.axis] < node.p[node.axis] ? 0 : 1;
    const std::uint32_t child = node.child[side];
    if (child == kNone) {
      const std::uint32_t leaf = take_node(point, (node.axis + 1) % 3, number);
      nodes_[number].child[side] = leaf;
      if (unbalanced != kNone) mark_due(unbalanced);
      // Between two calls of settle() a run of sorted points could go as deep as it is long.
      const int deep = 2 * std::bit_width(tallies_[root_].size) + static_cast<int>(kSmall);
      if (depth >= std::min(deep, kMaxDepth - 1)) settle();
      return;
    }
    if (unbalanced == kNone && tally.size >= kSmall && tallies_[child].size + 1 > balance_ * (tally.size - 1)) {
      unbalanced = number;
    }
    number = child;
  }
}

void PointTree::erase(std::uint32_t number) {
  nodes_[number].deleted = true;
  std::uint32_t topmost = kNone;
  for (std::uint32_t above = number; above != kNone; above = tallies_[above].parent) {
    Tally& tally = tallies_[above];
    ++tally.deleted;
    nodes_[above].dropped = tally.deleted == tally.size;
    if (tally.size >= kSmall && tally.deleted > deleted_ * tally.size) topmost = above;
  }
  if (topmost != kNone) mark_due(topmost);
}

std::size_t PointTree::erase(const Region& region) { return root_ == kNone ? 0 : erase_below(root_, region); }

std::uint32_t PointTree::erase_below(std::uint32_t number, const Region& region) {
  Node& node = nodes_[number];
  Tally& tally = tallies_[number];
  if (node.dropped) return 0;
  const std::uint32_t before = tally.deleted;
  const Cover cover = region.cover(node.p + to_vec(node.low), node.p + to_vec(node.high));
  if (cover == Cover::none) return 0;
  if (cover == Cover::all) {
    drop(number);
  } else {
    if (!node.deleted && region.contains(node.p)) {
      node.deleted = true;
      ++tally.deleted;
    }
    for (const std::uint32_t child : node.child) {
      if (child != kNone) tally.deleted += erase_below(child, region);
    }
    node.dropped = tally.deleted == tally.size;
  }
  if (tally.deleted > before && out_of_shape(number)) mark_due(number);
  return tally.deleted - before;
}

void PointTree::settle() {
  if (root_ != kNone) root_ = settle_below(root_);
}

std::uint32_t PointTree::settle_below(std::uint32_t number) {
  if (nodes_[number].due) return rebuild(number);
  if (!nodes_[number].due_below) return number;
  nodes_[number].due_below = false;
  Tally tally{.parent = tallies_[number].parent, .order = tallies_[number].order};
  tally.deleted = nodes_[number].deleted ? 1 : 0;
  for (std::uint32_t& child : nodes_[number].child) {
    if (child == kNone) continue;
    child = settle_below(child);
    if (child == kNone) continue;
    tally.size += tallies_[child].size;
    tally.deleted += tallies_[child].deleted;
  }
  tallies_[number] = tally;
  nodes_[number].dropped = tally.deleted == tally.size;
  // What the rebuilt children have lost may have shifted the balance here.
  return out_of_shape(number) ? rebuild(number) : number;
}

std::uint32_t PointTree::rebuild(std::uint32_t number) {
  const std::uint32_t parent = tallies_[number].parent;
  const std::size_t freed = free_.size();
  rebuilding_.clear();
  collect(number);
  // In the order of the old tree: neighbours in space stay neighbours in memory.
  std::reverse(free_.begin() + static_cast<std::ptrdiff_t>(freed), free_.end());
  return build(0, rebuilding_.size(), parent);
}

void PointTree::collect(std::uint32_t number) {
  if (nodes_[number].dropped) hand_down(number);
  const Node& node = nodes_[number];
  free_.push_back(number);
  if (!node.deleted) rebuilding_.push_back({node.p, node.stamp, tallies_[number].order, node.feature});
  for (const std::uint32_t child : node.child) {
    if (child != kNone) collect(child);
  }
}

std::uint32_t PointTree::build(std::size_t begin, std::size_t end, std::uint32_t parent) {
  if (begin == end) return kNone;
  const auto first = rebuilding_.begin() + static_cast<std::ptrdiff_t>(begin);
  const auto last = rebuilding_.begin() + static_cast<std::ptrdiff_t>(end);
  Vec3 low = first->p, high = first->p;
  for (auto it = first; it != last; ++it) {
    low = low.cwiseMin(it->p);
    high = high.cwiseMax(it->p);
  }
  int axis = 0;
  (high - low).maxCoeff(&axis);
  const std::size_t middle = begin + (end - begin) / 2;
  const auto median = rebuilding_.begin() + static_cast<std::ptrdiff_t>(middle);
  // A total order: the tree does not depend on how the library partitions.
  std::nth_element(first, median, last, [axis](const TreePoint& a, const TreePoint& b) {
    return a.p[axis] != b.p[axis] ? a.p[axis] < b.p[axis] : a.order < b.order;
  });
  const std::uint32_t number = take_node(*median, axis, parent);
  const std::uint32_t left = build(begin, middle, number);
  const std::uint32_t right = build(middle + 1, end, number);
  Node& node = nodes_[number];
  node.child = {left, right};
  for (std::size_t i = 0; i < 3; ++i) {
    const auto e = static_cast<Eigen::Index>(i);
    node.low[i] = round_down(low[e] - node.p[e]);
    node.high[i] = round_up(high[e] - node.p[e]);
  }
  tallies_[number].size = static_cast<std::uint32_t>(end - begin);
  return number;
}

void PointTree::clear() {
  root_ = kNone;
  nodes_.clear();
  tallies_.clear();
  free_.clear();
  rebuilding_.clear();
}

void PointTree::search(const Vec3& query, std::uint32_t max_stamp, std::uint8_t feature, Nearest& nearest) const {
  struct Pending {
    std::uint32_t number;
    double squared;
  };
  std::array<Pending, kMaxDepth> pending;
  std::size_t waiting = 0;
  std::uint32_t number = root_;
  for (;;) {
    while (number != kNone) {
      const Node& node = nodes_[number];
      if (node.dropped) break;
      const Vec3 d = node.p - query;
      if (box_squared(d, node.low, node.high) * kShrink > static_cast<double>(nearest.bound())) break;
      const auto x = static_cast<float>(d.x()), y = static_cast<float>(d.y()), z = static_cast<float>(d.z());
      const float squared = x * x + y * y + z * z;
      if (squared <= nearest.bound() && !node.deleted && node.stamp <= max_stamp && node.feature == feature) {
        nearest.offer(squared, &tallies_[number].order, x, y, z);
      }
      const double across = d[node.axis];
      const std::size_t near_side = across > 0 ? 0 : 1;
      const std::uint32_t other = node.child[1 - near_side];
      if (other != kNone && across * across * kShrink <= static_cast<double>(nearest.bound())) {
        __builtin_prefetch(&nodes_[other]);
        pending[waiting++] = {other, across * across};
      }
      number = node.child[near_side];
    }
    do {
      if (waiting == 0) return;
      --waiting;
    } while (pending[waiting].squared * kShrink > static_cast<double>(nearest.bound()));
    number = pending[waiting].number;
  }
}

std::uint32_t PointTree::find_in_cell(const Vec3& cell, double leaf, std::uint8_t feature) const {
  const double inverse = 1.0 / leaf;
  const Vec3 centre = (cell + Vec3::Constant(0.5)) * leaf;
  // Wider than the cell by the rounding of the products; which points count is decided as for the new point.
  const Vec3 half = Vec3::Constant(0.5 * leaf) + 1e-15 * centre.cwiseAbs() + Vec3::Constant(1e-9 * leaf);
  std::array<std::uint32_t, kMaxDepth> pending;
  std::size_t waiting = 0;
  std::uint32_t number = root_;
  for (;;) {
    while (number != kNone) {
      const Node& node = nodes_[number];
      const Vec3 d = node.p - centre;
      if (node.dropped || ((d + to_vec(node.low)).array() > half.array()).any() ||
          ((d + to_vec(node.high)).array() < -half.array()).any()) {
        break;
      }
      if (!node.deleted && node.feature == feature && (d.array().abs() <= half.array()).all() &&
          (node.p * inverse).array().floor().matrix() == cell) {
        return number;
      }
      const double across = d[node.axis];
      const bool left = across >= -half[node.axis], right = across <= half[node.axis];
      if (left && right && node.child[1] != kNone) pending[waiting++] = node.child[1];
      number = node.child[left ? 0 : 1];
    }
    if (waiting == 0) return kNone;
    number = pending[--waiting];
  }
}

void PointTree::for_each(const std::function<void(const TreePoint&)>& visitor) const {
  std::array<std::uint32_t, kMaxDepth> pending;
  std::size_t waiting = 0;
  std::uint32_t number = root_;
  for (;;) {
    while (number != kNone && !nodes_[number].dropped) {
      const Node& node = nodes_[number];
      if (!node.deleted) visitor({node.p, node.stamp, tallies_[number].order, node.feature});
      if (node.child[1] != kNone) pending[waiting++] = node.child[1];
      number = node.child[0];
    }
    if (waiting == 0) return;
    number = pending[--waiting];
  }
}

int PointTree::depth_below(std::uint32_t number) const {
  if (number == kNone) return 0;
  return 1 + std::max(depth_below(nodes_[number].child[0]), depth_below(nodes_[number].child[1]));
}

std::size_t PointTree::memory_bytes() const {
  return nodes_.capacity() * sizeof(Node) + tallies_.capacity() * sizeof(Tally) +
         free_.capacity() * sizeof(std::uint32_t) + rebuilding_.capacity() * sizeof(TreePoint);
}

}  // namespace aslio::plugins
