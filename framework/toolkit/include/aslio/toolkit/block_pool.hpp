#pragma once
/// Storage of the points of one voxel: structure of arrays in chunks of a few sizes, recycled.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

namespace aslio {

/// Arrays for `capacity` points (a multiple of 8). Coordinates [m] are relative to the corner of the voxel. Slots that
/// hold no point lie at kFarAway, so that loops over whole vectors need no remainder.
struct Chunk {
  static constexpr float kFarAway = 1e18F;  // its square is still finite

  float* x = nullptr;
  float* y = nullptr;
  float* z = nullptr;
  std::uint32_t* stamp = nullptr;  ///< update of insertion
  std::uint32_t* order = nullptr;  ///< count of insertions into the map (mod 2^32)
  std::uint32_t capacity = 0;
};

/// Hands out chunks and takes them back; memory is kept for reuse until clear().
class BlockPool {
 public:
  /// Largest chunk that will be asked for [points].
  explicit BlockPool(std::size_t max_points);
  /// Smallest chunk with room for `points`; all slots far away.
  Chunk take(std::size_t points);
  void give_back(const Chunk& chunk);
  void clear();
  std::size_t memory_bytes() const { return bytes_; }

 private:
  struct SizeClass {
    std::uint32_t capacity = 0;
    std::vector<Chunk> free;
  };
  void refill(SizeClass& size);

  std::vector<SizeClass> sizes_;  // ascending
  std::vector<std::unique_ptr<float[]>> coordinates_;
  std::vector<std::unique_ptr<std::uint32_t[]>> marks_;
  std::size_t bytes_ = 0;
};

}  // namespace aslio
