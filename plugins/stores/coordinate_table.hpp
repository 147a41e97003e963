#pragma once
/// A hash from one integer coordinate of a cell to a value: one layer of the nested hash.

#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <type_traits>
#include <utility>
#include <vector>

namespace aslio::plugins {

/// Open addressing with linear probing, at most three quarters full. Of an empty Value only the coordinates are kept.
template <class Value>
class CoordinateTable {
 public:
  bool contains(std::int32_t c) const { return size_ != 0 && keys_[slot_of(c)] == c; }
  /// Null if absent; valid until the next change.
  const Value* find(std::int32_t c) const {
    if (size_ == 0) return nullptr;
    const std::size_t slot = slot_of(c);
    return keys_[slot] == c ? &values_[slot] : nullptr;
  }
  /// The slot of `c`, which is added if absent, and whether it was. Valid until the next change.
  std::pair<std::size_t, bool> add(std::int32_t c) {
    if (4 * (size_ + 1) > 3 * keys_.size()) resize(keys_.empty() ? kSmallest : 2 * keys_.size());
    const std::size_t slot = slot_of(c);
    if (keys_[slot] == c) return {slot, false};
    keys_[slot] = c;
    ++size_;
    return {slot, true};
  }
  Value& value(std::size_t slot) { return values_[slot]; }

  /// Drops the coordinates for which keep(c, value) is false, and the memory they took.
  template <class Keep>
  void retain(Keep&& keep) {
    std::size_t kept = 0;
    for (std::size_t slot = 0; slot < keys_.size(); ++slot) {
      if (keys_[slot] == kNone) continue;
      if (keep_slot(slot, keep)) {
        ++kept;
      } else {
        keys_[slot] = kNone;
      }
    }
    if (kept == size_) return;
    // Also where the size stays: a probe must not stop at the slot of a dropped coordinate.
    resize(kept == 0 ? 0 : std::bit_ceil(2 * kept + 2));
  }

  std::size_t size() const { return size_; }
  /// Of the table alone.
  std::size_t table_bytes() const {
    return keys_.capacity() * sizeof(std::int32_t) + values_.capacity() * (kSet ? 0 : sizeof(Value));
  }
  /// visit(value) for each, in the order of the table.
  template <class Visit>
  void for_each(Visit&& visit) const {
    for (std::size_t slot = 0; slot < keys_.size(); ++slot) {
      if (keys_[slot] != kNone) visit(values_[slot]);
    }
  }

 private:
  static constexpr bool kSet = std::is_empty_v<Value>;
  static constexpr std::int32_t kNone = std::numeric_limits<std::int32_t>::min();
  static constexpr std::size_t kSmallest = 4;

  template <class Keep>
  bool keep_slot(std::size_t slot, Keep&& keep) {
    if constexpr (kSet) {
      return keep(keys_[slot]);
    } else {
      return keep(keys_[slot], values_[slot]);
    }
  }
  /// Where `c` is, or would go. Pre: there is an empty slot.
  std::size_t slot_of(std::int32_t c) const {
    const std::size_t mask = keys_.size() - 1;
    std::size_t slot = static_cast<std::size_t>(static_cast<std::uint32_t>(c) * 0x9e3779b9u >> shift_);
    while (keys_[slot] != c && keys_[slot] != kNone) slot = (slot + 1) & mask;
    return slot;
  }
  void resize(std::size_t slots) {
    const auto keys = std::exchange(keys_, std::vector<std::int32_t>(slots, kNone));
    auto values = std::exchange(values_, std::vector<Value>(kSet ? 0 : slots));
    shift_ = 32 - static_cast<unsigned>(std::countr_zero(slots));
    size_ = 0;
    for (std::size_t old = 0; old < keys.size(); ++old) {
      if (keys[old] == kNone) continue;
      const std::size_t slot = slot_of(keys[old]);
      keys_[slot] = keys[old];
      if constexpr (!kSet) values_[slot] = std::move(values[old]);
      ++size_;
    }
  }

  std::vector<std::int32_t> keys_;
  std::vector<Value> values_;
  std::size_t size_ = 0;
  unsigned shift_ = 0;  // 32 - log2(slots)
};

}  // namespace aslio::plugins
