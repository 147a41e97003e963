#pragma once
/// What the maps that keep points by cell have in common. A Cell of theirs has a `cell`, a `count` (0: not in use) and
/// `points` (a Chunk) relative to the cell's corner.

#include <algorithm>
#include <functional>
#include <numeric>
#include <span>
#include <tuple>
#include <vector>

#include "aslio/core/cell_index.hpp"
#include "aslio/core/types.hpp"
#include "aslio/toolkit/block_pool.hpp"

namespace aslio {

/// Points in the order of their cells, then of their coordinates within: it says nothing of the order of insertion.
/// `corner(VoxelCell)` is a cell's corner [m].
template <class Cell, class Corner>
void visit_by_cell(std::span<const Cell> cells, const Corner& corner, const std::function<void(const Vec3&)>& visitor) {
  std::vector<const Cell*> order;
  for (const Cell& cell : cells) {
    if (cell.count > 0) order.push_back(&cell);
  }
  std::sort(order.begin(), order.end(), [](auto* a, auto* b) { return pack(a->cell) < pack(b->cell); });
  std::vector<std::uint32_t> inside;
  for (const Cell* cell : order) {
    inside.resize(cell->count);
    std::iota(inside.begin(), inside.end(), 0U);
    const Chunk& points = cell->points;
    const auto key = [&](std::uint32_t i) { return std::tuple(points.x[i], points.y[i], points.z[i]); };
    std::sort(inside.begin(), inside.end(), [&](std::uint32_t a, std::uint32_t b) { return key(a) < key(b); });
    for (const std::uint32_t i : inside) {
      visitor(corner(cell->cell) + Eigen::Vector3f(points.x[i], points.y[i], points.z[i]).cast<double>());
    }
  }
}

}  // namespace aslio
