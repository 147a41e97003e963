#include "aslio/toolkit/block_pool.hpp"

#include <algorithm>

namespace aslio {

BlockPool::BlockPool(std::size_t max_points) {
  // 8, 16, 24, 32, 48, 64, 96, ..: less than half of a chunk is empty once it has grown beyond the first.
  for (std::uint32_t step = 8, capacity = 8;; capacity += step) {
    sizes_.push_back({capacity, {}});
    if (capacity >= max_points) break;
    if (capacity >= 4 * step) step *= 2;
  }
}

Chunk BlockPool::take(std::size_t points) {
  SizeClass& size = *std::find_if(sizes_.begin(), sizes_.end(), [&](const auto& s) { return s.capacity >= points; });
  if (size.free.empty()) refill(size);
  const Chunk chunk = size.free.back();
  size.free.pop_back();
  std::fill_n(chunk.x, 3 * chunk.capacity, Chunk::kFarAway);
  return chunk;
}

void BlockPool::refill(SizeClass& size) {
  const std::size_t count = std::max<std::size_t>(1, 4096 / size.capacity);
  coordinates_.push_back(std::make_unique<float[]>(3 * count * size.capacity));
  marks_.push_back(std::make_unique<std::uint32_t[]>(2 * count * size.capacity));
  bytes_ += count * size.capacity * (3 * sizeof(float) + 2 * sizeof(std::uint32_t));
  const std::size_t c = size.capacity;
  for (std::size_t i = count; i-- > 0;) {
    float* x = coordinates_.back().get() + 3 * c * i;
    std::uint32_t* stamp = marks_.back().get() + 2 * c * i;
    size.free.push_back({x, x + c, x + 2 * c, stamp, stamp + c, size.capacity});
  }
}

void BlockPool::give_back(const Chunk& chunk) {
  std::find_if(sizes_.begin(), sizes_.end(), [&](const auto& s) {
    return s.capacity == chunk.capacity;
  })->free.push_back(chunk);
}

void BlockPool::clear() {
  for (auto& size : sizes_) size.free.clear();
  coordinates_.clear();
  marks_.clear();
  bytes_ = 0;
}

}  // namespace aslio
