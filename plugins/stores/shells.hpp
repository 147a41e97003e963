#pragma once
/// Neighbourhoods of a cell as shells of equal distance.

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "aslio/stages/overlap.hpp"

namespace aslio::plugins {

/// Distance of a cell offset in units of `metric`; euclid_rounded is to the nearest integer.
int layer_of(int dx, int dy, int dz, LayerMetric metric);

/// All offsets of layer 0..kMaxLayers - 1, nearest layer first.
class Shells {
 public:
  struct Offset {
    std::int8_t x, y, z;
    std::uint64_t key_step;  ///< what to add to a key (mod 2^64)
  };
  explicit Shells(LayerMetric metric);
  std::span<const Offset> layer(int i) const {
    const auto l = static_cast<std::size_t>(i);
    return std::span(offsets_).subspan(begins_[l], begins_[l + 1] - begins_[l]);
  }
  /// The table of a metric, built once and never changed.
  static const Shells& of(LayerMetric metric);

 private:
  std::vector<Offset> offsets_;
  std::array<std::size_t, kMaxLayers + 1> begins_{};
};

}  // namespace aslio::plugins
