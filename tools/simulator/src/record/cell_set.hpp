#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "aslio/core/spread.hpp"

namespace aslio::simulator {

/// Cells seen so far: a set of cell_key() values with open addressing.
class CellSet {
 public:
  CellSet() : slots_(kInitialSlots, kEmpty) {}

  bool contains(std::uint64_t key) const { return slots_[slot(key)] == key; }

  void insert(std::uint64_t key) {
    std::uint64_t& slot_of_key = slots_[slot(key)];
    if (slot_of_key == key) return;
    slot_of_key = key;
    if (2 * ++size_ > slots_.size()) grow();
  }

  std::size_t size() const { return size_; }

 private:
  static constexpr std::uint64_t kEmpty = ~std::uint64_t{0};  // keys have 63 bits
  static constexpr std::size_t kInitialSlots = 1U << 16U;

  std::size_t slot(std::uint64_t key) const {
    const std::size_t mask = slots_.size() - 1;
    // Fibonacci hashing; the upper bits are the mixed ones.
    std::size_t at = static_cast<std::size_t>((key * kGoldenRatio) >> 20U) & mask;
    while (slots_[at] != kEmpty && slots_[at] != key) at = (at + 1) & mask;
    return at;
  }

  void grow() {
    std::vector<std::uint64_t> old(2 * slots_.size(), kEmpty);
    old.swap(slots_);
    for (const std::uint64_t key : old)
      if (key != kEmpty) slots_[slot(key)] = key;
  }

  std::vector<std::uint64_t> slots_;
  std::size_t size_ = 0;
};

}  // namespace aslio::simulator
