#pragma once
/// 8^3 cells as bits, and the bits of all cells near a set one.

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "aslio/stages/overlap.hpp"

namespace aslio::plugins {

/// Bit 8 y + z of word x. Aligned to a cache line.
struct alignas(64) Brick {
  static constexpr int kEdge = 8;
  std::array<std::uint64_t, 8> words{};

  static std::uint64_t bit(const Cell& cell) { return std::uint64_t{1} << ((cell.y & 7) << 3 | (cell.z & 7)); }
  static std::size_t word(const Cell& cell) { return static_cast<std::size_t>(cell.x & 7); }
  bool has(const Cell& cell) const { return (words[word(cell)] & bit(cell)) != 0; }
};

/// A brick and the 26 around it: number 9 (dx + 1) + 3 (dy + 1) + dz + 1.
using Neighbourhood = std::array<const Brick*, 27>;

/// The cells within 1, 2, .. kMaxLayers - 1 of a cell as rows along z: all (dx, dy, dz) with |dz| <= reach.
class Balls {
 public:
  struct Row {
    std::int8_t dx, dy, reach;
  };
  explicit Balls(LayerMetric metric);
  std::span<const Row> within(int layer) const { return rows_[static_cast<std::size_t>(layer)]; }
  /// The table of a metric, built once and never changed.
  static const Balls& of(LayerMetric metric);

 private:
  std::array<std::vector<Row>, kMaxLayers> rows_;
};

/// planes[0] becomes the middle brick, planes[i] its cells within i of a set one (i < planes.size() <= kMaxLayers; no
/// such distance leaves the 27 bricks).
void dilate(const Neighbourhood& around, LayerMetric metric, std::span<Brick> planes);

}  // namespace aslio::plugins
