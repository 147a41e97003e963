#include "overlaps/cell_histogram.hpp"

#include <bit>

#include "aslio/core/spread.hpp"

namespace aslio::plugins {

void CellHistogram::reset(std::size_t points) {
  cells_.clear();
  counts_.clear();
  const std::size_t size = std::bit_ceil(2 * points + 2);
  slots_.assign(size, 0);
  shift_ = static_cast<unsigned>(64 - std::bit_width(size - 1));
}

void CellHistogram::add(const Cell& cell) {
  const auto field = [](std::int32_t c) {
    return static_cast<std::uint64_t>(static_cast<std::uint32_t>(c) & 0x1fffff);
  };
  const std::uint64_t key = field(cell.x) << 42 | field(cell.y) << 21 | field(cell.z);
  const std::size_t mask = slots_.size() - 1;
  std::size_t slot = static_cast<std::size_t>(key * kGoldenRatio >> shift_);
  for (; slots_[slot] != 0; slot = (slot + 1) & mask) {
    const std::size_t number = slots_[slot] - 1;
    if (cells_[number] == cell) {
      ++counts_[number];
      return;
    }
  }
  cells_.push_back(cell);
  counts_.push_back(1);
  slots_[slot] = static_cast<std::uint32_t>(cells_.size());
}

std::size_t CellHistogram::memory_bytes() const {
  return cells_.capacity() * sizeof(Cell) + (counts_.capacity() + slots_.capacity()) * sizeof(std::uint32_t);
}

}  // namespace aslio::plugins
