#include "aslio/core/cell_index.hpp"

#include <bit>
#include <utility>

namespace aslio {

void CellIndex::clear() {
  used_ = 0;
  slots_.clear();
  resize(10);
}

void CellIndex::place(const Slot& entry) {
  std::size_t slot = home(entry.key);
  while (slots_[slot].key != kEmpty) slot = (slot + 1) & mask_;
  slots_[slot] = entry;
}

void CellIndex::resize(std::size_t log2_size) {
  const std::vector<Slot> old = std::exchange(slots_, std::vector<Slot>(std::size_t{1} << log2_size));
  mask_ = slots_.size() - 1;
  shift_ = static_cast<unsigned>(64 - log2_size);
  for (const Slot& entry : old) {
    if (entry.key != kEmpty) place(entry);
  }
}

void CellIndex::insert(std::uint64_t key, std::uint32_t number) {
  if (2 * (used_ + 1) > slots_.size()) resize(static_cast<std::size_t>(std::bit_width(slots_.size())));
  place({key, number});
  ++used_;
}

void CellIndex::erase(std::uint64_t key) {
  std::size_t gap = home(key);
  while (slots_[gap].key != key) gap = (gap + 1) & mask_;
  for (std::size_t slot = (gap + 1) & mask_; slots_[slot].key != kEmpty; slot = (slot + 1) & mask_) {
    // An entry may move back into the gap only if its home does not lie between the gap and itself.
    if (((slot - home(slots_[slot].key)) & mask_) >= ((slot - gap) & mask_)) {
      slots_[gap] = slots_[slot];
      gap = slot;
    }
  }
  slots_[gap] = Slot{};
  --used_;
}

}  // namespace aslio
