#pragma once
/// Incremental k-d tree of points: the structure of Cai, Xu, Zhang, "ikd-Tree: An Incremental K-D Tree for Robotic
/// Applications", 2021, from the description there.

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "aslio/core/lie.hpp"
#include "aslio/toolkit/nearest.hpp"

namespace aslio::plugins {

/// What the tree keeps of a point. `order` is unique among the points of a tree.
struct TreePoint {
  Vec3 p = Vec3::Zero();  ///< [m]
  std::uint32_t stamp = 0;
  std::uint32_t order = 0;
  std::uint8_t feature = 0;
};

/// How much of a box of the tree lies in a region.
enum class Cover : std::uint8_t { none, part, all };

/// A part of space whose points are deleted at once. `part` is always a correct answer of cover().
class Region {
 public:
  virtual ~Region() = default;
  virtual bool contains(const Vec3& p) const = 0;
  virtual Cover cover(const Vec3& low, const Vec3& high) const = 0;
};

/// Every node holds a point, the box around its subtree, and counts of the subtree's nodes and of the deleted ones
/// among them. Deletion only sets labels; a label on a whole subtree is handed down to its children when an insertion
/// passes. settle() rebuilds the topmost subtrees that are out of balance or hold too many deleted nodes, from their
/// median points, in one thread: the tree is a function of the operations alone. Nodes live in one pool and refer to
/// each other by number. Points are doubles and boxes are floats relative to the point of their node, rounded outward,
/// so that distances are as accurate far from the origin as near it.
class PointTree {
 public:
  static constexpr std::uint32_t kNone = 0xffffffff;
  static constexpr double kMaxBalance = 0.8;
  /// Bounds every recursion and the stacks of the searches.
  static constexpr int kMaxDepth = 128;

  /// A subtree of n >= kSmall nodes is rebuilt when a child holds more than balance * (n - 1) of them (balance in
  /// [0.55, kMaxBalance]) or more than deleted * n are deleted (deleted in (0, 1)).
  PointTree(double balance, double deleted) : balance_(balance), deleted_(deleted) {}

  /// Pre: finite coordinates, |.| <= 1e8 m. May leave subtrees out of shape until settle().
  void insert(const TreePoint& point);
  /// Deletes the point of a node found by find_in_cell().
  void erase(std::uint32_t number);
  /// Deletes all points in the region and returns their number.
  std::size_t erase(const Region& region);
  void settle();
  void clear();

  /// The k nearest of class `feature` with stamp <= max_stamp within the bound of `nearest`.
  void search(const Vec3& query, std::uint32_t max_stamp, std::uint8_t feature, Nearest& nearest) const;
  /// A node with a point of class `feature` in the cell floor(p / leaf) == cell, or kNone.
  std::uint32_t find_in_cell(const Vec3& cell, double leaf, std::uint8_t feature) const;
  const Vec3& point(std::uint32_t number) const { return nodes_[number].p; }
  /// In no particular order.
  void for_each(const std::function<void(const TreePoint&)>& visitor) const;

  std::size_t size() const { return root_ == kNone ? 0 : tallies_[root_].size - tallies_[root_].deleted; }
  /// Nodes on the longest way down.
  int depth() const { return depth_below(root_); }
  std::size_t memory_bytes() const;

 private:
  static constexpr std::uint32_t kSmall = 16;  // nodes; below, a poor shape costs less than its repair

  /// What a search reads: one cache line.
  struct alignas(64) Node {
    Vec3 p = Vec3::Zero();
    std::array<float, 3> low{}, high{};  // box of the subtree minus p [m]
    std::array<std::uint32_t, 2> child{kNone, kNone};
    std::uint32_t stamp = 0;
    std::uint8_t feature = 0;
    std::uint8_t axis : 2 = 0;
    bool deleted : 1 = false;    // this point
    bool dropped : 1 = false;    // all of the subtree; the labels below may be out of date
    bool due : 1 = false;        // out of shape
    bool due_below : 1 = false;  // a node below is due
  };
  static_assert(sizeof(Node) == 64);
  struct Tally {
    std::uint32_t size = 1;     // nodes of the subtree
    std::uint32_t deleted = 0;  // of these
    std::uint32_t parent = kNone;
    std::uint32_t order = 0;
  };

  std::uint32_t take_node(const TreePoint& point, int axis, std::uint32_t parent);
  void drop(std::uint32_t number);
  void hand_down(std::uint32_t number);
  bool out_of_shape(std::uint32_t number) const;
  void mark_due(std::uint32_t number);
  std::uint32_t erase_below(std::uint32_t number, const Region& region);
  std::uint32_t settle_below(std::uint32_t number);
  std::uint32_t rebuild(std::uint32_t number);
  void collect(std::uint32_t number);
  std::uint32_t build(std::size_t begin, std::size_t end, std::uint32_t parent);
  int depth_below(std::uint32_t number) const;

  double balance_;
  double deleted_;
  std::uint32_t root_ = kNone;
  std::vector<Node> nodes_;
  std::vector<Tally> tallies_;         // [number of the node]
  std::vector<std::uint32_t> free_;    // numbers not in use, taken from the back
  std::vector<TreePoint> rebuilding_;  // scratch
};

}  // namespace aslio::plugins
