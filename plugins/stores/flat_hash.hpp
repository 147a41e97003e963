#pragma once

#include "aslio/config/binder.hpp"
#include "aslio/core/spread.hpp"
#include "aslio/stages/build_context.hpp"
#include "aslio/stages/overlap.hpp"

namespace aslio::plugins {

/// Occupied cells as packed 64-bit keys in one open-addressing table (linear probing, at most half full: 16 to 32
/// bytes per cell). A query looks at the shells around a cell from the inside out and stops at the first hit.
/// layers() may be called concurrently.
class FlatHash final : public OccupancyStore {
 public:
  struct Params {};
  static void describe(config::Binder& b, Params& p);
  FlatHash(const Params& params, const BuildContext& context);

  void insert(std::span<const Cell> cells) override;
  void layers(std::span<const Cell> cells, int depth, LayerMetric metric, std::span<std::uint8_t> out) override;
  void keep_inside(const Cell& lo, const Cell& hi) override;
  std::size_t size() const override { return size_; }
  std::size_t memory_bytes() const override { return sizeof(*this) + keys_.capacity() * sizeof(std::uint64_t); }
  /// Keeps the memory.
  void clear() override;

 private:
  static constexpr std::uint64_t kEmpty = ~std::uint64_t{0};  // no cell: keys have 63 bits

  /// Eight cells above each other share a cache line: a query walks up and down columns.
  std::size_t home(std::uint64_t key) const {
    return static_cast<std::size_t>((key >> 3) * kGoldenRatio >> shift_) << 3 | (key & 7);
  }
  bool contains(std::uint64_t key) const {
    for (std::size_t slot = home(key);; slot = (slot + 1) & mask_) {
      if (keys_[slot] == key) return true;
      if (keys_[slot] == kEmpty) return false;
    }
  }
  void add(std::uint64_t key);
  int layer(const Cell& cell, int depth, LayerMetric metric) const;
  /// A table of 2^log2_size slots with those of the old keys for which `keep` holds.
  template <class Keep>
  void rebuild(unsigned log2_size, Keep&& keep);

  std::vector<std::uint64_t> keys_;
  std::size_t mask_ = 0;
  std::size_t size_ = 0;
  unsigned shift_ = 0;
};

}  // namespace aslio::plugins
