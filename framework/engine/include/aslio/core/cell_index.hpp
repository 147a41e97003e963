#pragma once
/// Open-addressing index from integer cells to numbers, the skeleton of a voxel map.

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "aslio/core/lie.hpp"
#include "aslio/core/spread.hpp"

namespace aslio {

/// Integer coordinates of a voxel, floor(p / edge) per axis.
struct VoxelCell {
  std::int32_t x = 0, y = 0, z = 0;
  friend bool operator==(const VoxelCell&, const VoxelCell&) = default;
};

/// Cells this near to the edge of the 21-bit range are refused, so that the neighbourhood of a cell always has a key.
inline constexpr std::int32_t kCellMargin = 64;
inline constexpr std::int32_t kCellLimit = (1 << 20) - kCellMargin;

/// The cell of `p` [m]; nothing when it is not finite or beyond kCellLimit (a packed key would wrap).
inline std::optional<VoxelCell> cell_of(const Vec3& p, double inverse_edge) {
  const double x = p.x() * inverse_edge, y = p.y() * inverse_edge, z = p.z() * inverse_edge;
  // Written so that NaN fails: the cast below is undefined for anything that does not fit.
  if (!(std::abs(x) < kCellLimit) || !(std::abs(y) < kCellLimit) || !(std::abs(z) < kCellLimit)) return std::nullopt;
  return VoxelCell{static_cast<std::int32_t>(std::floor(x)), static_cast<std::int32_t>(std::floor(y)),
                   static_cast<std::int32_t>(std::floor(z))};
}

/// 3 x 21 bits. Pre: every coordinate within +-2^20.
constexpr std::uint64_t pack(const VoxelCell& c) {
  constexpr std::int64_t offset = std::int64_t{1} << 20;
  return static_cast<std::uint64_t>(c.x + offset) << 42 | static_cast<std::uint64_t>(c.y + offset) << 21 |
         static_cast<std::uint64_t>(c.z + offset);
}

/// Squared distance [m^2] to a cube with the given edge [m] of a point `relative` to its corner [m]; 0 inside.
inline double squared_distance_to_cube(const Vec3& relative, double edge) {
  return (relative - relative.cwiseMax(0.0).cwiseMin(edge)).squaredNorm();
}

/// Packed cell -> number, linear probing, at most half full. Not iterated: order depends on the hash alone.
class CellIndex {
 public:
  static constexpr std::uint32_t kNone = 0xffffffff;

  CellIndex() { clear(); }
  /// The number of a key, or kNone.
  std::uint32_t find(std::uint64_t key) const {
    for (std::size_t slot = home(key);; slot = (slot + 1) & mask_) {
      if (slots_[slot].key == key) return slots_[slot].number;
      if (slots_[slot].key == kEmpty) return kNone;
    }
  }
  /// Starts to load the slot of a key.
  void prefetch(std::uint64_t key) const { __builtin_prefetch(&slots_[home(key)]); }
  /// Pre: the key is absent. Amortised O(1).
  void insert(std::uint64_t key, std::uint32_t number);
  /// Pre: the key is present. Closes the gap, so that no tombstones pile up.
  void erase(std::uint64_t key);
  void clear();
  std::size_t memory_bytes() const { return slots_.capacity() * sizeof(Slot); }

 private:
  static constexpr std::uint64_t kEmpty = ~std::uint64_t{0};  // no cell: keys have 63 bits
  struct Slot {
    std::uint64_t key = kEmpty;
    std::uint32_t number = kNone;
  };

  std::size_t home(std::uint64_t key) const { return static_cast<std::size_t>(key * kGoldenRatio >> shift_); }
  void place(const Slot& entry);
  void resize(std::size_t log2_size);

  std::vector<Slot> slots_;
  std::size_t mask_ = 0;
  std::size_t used_ = 0;
  unsigned shift_ = 0;
};

}  // namespace aslio
