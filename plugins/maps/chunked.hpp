#pragma once
/// A sequence that grows without moving or copying what it holds, so that its peak memory is what it holds and at most
/// one chunk more.

#include <cstddef>
#include <memory>
#include <vector>

namespace aslio::plugins {

template <class T, std::size_t kLog2ChunkSize>
class Chunked {
 public:
  std::size_t size() const { return size_; }
  T& operator[](std::size_t i) { return chunks_[i >> kLog2ChunkSize][i & kMask]; }
  const T& operator[](std::size_t i) const { return chunks_[i >> kLog2ChunkSize][i & kMask]; }
  /// Appends `count` elements as constructed; the number of the first. Pre: count divides the size of a chunk, and all
  /// calls have the same.
  std::size_t grow(std::size_t count) {
    if (size_ == chunks_.size() << kLog2ChunkSize) chunks_.push_back(std::make_unique<T[]>(kMask + 1));
    size_ += count;
    return size_ - count;
  }
  void clear() {
    chunks_.clear();
    size_ = 0;
  }
  std::size_t memory_bytes() const {
    return chunks_.size() * (kMask + 1) * sizeof(T) + chunks_.capacity() * sizeof(chunks_[0]);
  }

 private:
  static constexpr std::size_t kMask = (std::size_t{1} << kLog2ChunkSize) - 1;
  std::vector<std::unique_ptr<T[]>> chunks_;
  std::size_t size_ = 0;
};

}  // namespace aslio::plugins
