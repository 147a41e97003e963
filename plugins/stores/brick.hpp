#pragma once
/// 8^3 cells as bits, and the bits of all cells near a set one.

#include <array>
#include <cstdint>
#include <span>

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

/// The cells within 0, 1, .. kMaxLayers - 1 of a cell as rows along z: reach(layer, |dx|, |dy|) is the largest |dz|, or
/// -1 if there is none. |dx| + 1 has the same rows as |dx| where `repeats` says so.
class Balls {
 public:
  explicit Balls(LayerMetric metric);
  int reach(std::size_t layer, std::size_t dx, std::size_t dy) const { return reaches_[layer][dx][dy]; }
  bool repeats(std::size_t layer, std::size_t dx) const { return reaches_[layer][dx] == reaches_[layer][dx + 1]; }
  /// The table of a metric, built once and never changed.
  static const Balls& of(LayerMetric metric);

 private:
  using Slice = std::array<std::int8_t, kMaxLayers>;
  std::array<std::array<Slice, kMaxLayers + 1>, kMaxLayers> reaches_{};
};

inline constexpr int kSurroundings = 3;  ///< cells either way: in one direction at most two bricks
/// The cells within kSurroundings = 3 of one, as bits: word dx + 3, bit 8 (dy + 3) + dz + 3.
using Surroundings = std::array<std::uint64_t, 2 * kSurroundings + 1>;

/// The bricks in which the surroundings of a cell lie: [x][y][z], from that of the lowest cell on. Those not needed may
/// be null: an axis needs a second one where straddles() says so.
using Corners = std::array<std::array<std::array<const Brick*, 2>, 2>, 2>;
inline bool straddles(std::int32_t lowest) { return (lowest & 7) > 7 - 2 * kSurroundings; }
Surroundings surroundings(const Corners& bricks, const Cell& lowest);

/// The smallest distance, up to `depth`, to a set cell of the surroundings, or depth + 1. Pre: depth <= kSurroundings,
/// the cell itself is not set.
int layer_within(const Surroundings& around, int depth, LayerMetric metric);

/// planes[i] becomes the cells of the middle brick within i + 1 of a set one. Pre: planes.size() < kMaxLayers, so that
/// no such distance leaves the 27 bricks.
void dilate(const Neighbourhood& around, LayerMetric metric, std::span<Brick> planes);

}  // namespace aslio::plugins
