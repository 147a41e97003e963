#pragma once
/// Numbered elements that are given back and used again, in blocks of equal size.

#include <cstdint>

#include "maps/chunked.hpp"

namespace aslio::plugins {

/// Blocks of `kBlock` elements. Memory is that of the most blocks at a time; nothing moves.
template <class T, std::size_t kLog2ChunkSize, std::size_t kBlock = 1>
class Slots {
 public:
  T& operator[](std::size_t i) { return all_[i]; }
  const T& operator[](std::size_t i) const { return all_[i]; }
  /// Elements there are or were.
  std::size_t size() const { return all_.size(); }
  /// Blocks there are.
  std::size_t in_use() const { return all_.size() / kBlock - free_.size(); }
  /// The number of the first element of a block, all as constructed.
  std::uint32_t take() {
    if (free_.empty()) return static_cast<std::uint32_t>(all_.grow(kBlock));
    const std::uint32_t first = free_.back();
    free_.pop_back();
    for (std::size_t i = 0; i < kBlock; ++i) all_[first + i] = {};
    return first;
  }
  /// The block whose first element is `first`; its elements stay as they are until it is taken again.
  void give_back(std::uint32_t first) { free_.push_back(first); }
  void clear() {
    all_.clear();
    free_.clear();
  }
  std::size_t memory_bytes() const { return all_.memory_bytes() + free_.capacity() * sizeof(std::uint32_t); }

 private:
  Chunked<T, kLog2ChunkSize> all_;
  std::vector<std::uint32_t> free_;
};

}  // namespace aslio::plugins
