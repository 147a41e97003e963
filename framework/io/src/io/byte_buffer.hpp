#pragma once

#include <cstdint>
#include <memory>
#include <span>

namespace aslio::io {

/// Memory for bytes that are written before they are read: growing it costs no clearing, and room that is never written
/// takes no memory.
class ByteBuffer {
 public:
  /// Makes it `size` bytes long; their content is undefined.
  void reset(std::size_t size) {
    if (size > capacity_) {
      release();
      bytes_ = std::make_unique_for_overwrite<std::uint8_t[]>(size);
      capacity_ = size;
    }
    size_ = size;
  }
  /// Pre: size <= size().
  void shrink(std::size_t size) { size_ = size; }
  /// Gives its memory back.
  void release() {
    bytes_.reset();
    size_ = capacity_ = 0;
  }

  std::uint8_t* data() { return bytes_.get(); }
  std::size_t size() const { return size_; }
  std::size_t capacity() const { return capacity_; }
  std::span<const std::uint8_t> bytes() const { return {bytes_.get(), size_}; }

 private:
  std::unique_ptr<std::uint8_t[]> bytes_;
  std::size_t size_ = 0, capacity_ = 0;
};

}  // namespace aslio::io
