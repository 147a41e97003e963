#pragma once
/// The k nearest so far of one query.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "aslio/stages/map.hpp"
#include "aslio/toolkit/block_pool.hpp"

namespace aslio {

/// Queries that one thread answers in a row.
inline constexpr std::size_t kQueriesPerChunk = 128;
/// Rounding of a float coordinate inside a voxel, as a share of its edge, with much to spare.
inline constexpr double kSlack = 1e-5;

/// Points as rows of their coordinates, as a Chunk has them or a voxel that holds them itself. The rows have room for a
/// multiple of 8; slots that hold no point lie at Chunk::kFarAway.
struct PointRows {
  const float *x, *y, *z;              ///< [m] from the corner of the voxel
  const std::uint32_t *stamp, *order;  ///< as in Chunk
};

/// Ascending by (squared distance, order of insertion). Everything is relative to the query [m].
class Nearest {
 public:
  Nearest(int k, float max_squared) : k_(k), bound_(max_squared) {}

  /// A point farther than this cannot enter.
  float bound() const { return bound_; }
  int count() const { return count_; }

  /// Offers the first `n` points of a chunk; (qx, qy, qz) is the query relative to the corner of the voxel.
  void scan(const Chunk& chunk, std::size_t n, float qx, float qy, float qz, std::uint32_t max_stamp) {
    scan(PointRows{chunk.x, chunk.y, chunk.z, chunk.stamp, chunk.order}, n, qx, qy, qz, max_stamp);
  }
  void scan(const PointRows& points, std::size_t n, float qx, float qy, float qz, std::uint32_t max_stamp);
  /// Offers one point with squared <= bound(); *order must outlive the query.
  void offer(float squared, const std::uint32_t* order, float x, float y, float z);
  void write(Neighbours& out, std::size_t query) const {
    out.count[query] = static_cast<std::uint8_t>(count_);
    const std::size_t base = query * out.k();
    for (std::size_t j = 0; j < static_cast<std::size_t>(count_); ++j) {
      out.offsets[base + j] = {x_[j], y_[j], z_[j]};
      out.squared[base + j] = squared_[j];
    }
  }

 private:
  static constexpr std::size_t kTile = 64;
  static constexpr std::size_t kLanes = 8;

  void tighten(const float* squared, std::size_t n);

  int k_;
  int count_ = 0;
  float bound_;
  std::array<float, Neighbours::kMax> squared_, x_, y_, z_;
  std::array<const std::uint32_t*, Neighbours::kMax> order_;  // read at ties only: a cache line less
};

inline void Nearest::offer(float squared, const std::uint32_t* order, float x, float y, float z) {
  // Orders compare as a circle: the count of insertions may wrap.
  const auto before = [&](std::size_t j) {
    return squared < squared_[j] || (squared == squared_[j] && static_cast<std::int32_t>(*order - *order_[j]) < 0);
  };
  auto j = static_cast<std::size_t>(count_);
  if (count_ == k_) {
    if (!before(j - 1)) return;
    --j;
  } else {
    ++count_;
  }
  for (; j > 0 && before(j - 1); --j) {
    squared_[j] = squared_[j - 1];
    order_[j] = order_[j - 1];
    x_[j] = x_[j - 1];
    y_[j] = y_[j - 1];
    z_[j] = z_[j - 1];
  }
  squared_[j] = squared;
  order_[j] = order;
  x_[j] = x;
  y_[j] = y;
  z_[j] = z;
  if (count_ == k_) bound_ = std::min(bound_, squared_[static_cast<std::size_t>(k_ - 1)]);
}

inline void Nearest::tighten(const float* squared, std::size_t n) {
  // The minima of 8 disjoint lanes are 8 different points, so the k-th smallest of them bounds the k-th distance. It
  // keeps most points of the first voxel from being sorted in and out again.
  std::array<float, kLanes> least;
  std::copy_n(squared, kLanes, least.begin());
  for (std::size_t i = kLanes; i < n; i += kLanes) {
    for (std::size_t lane = 0; lane < kLanes; ++lane) least[lane] = std::min(least[lane], squared[i + lane]);
  }
  auto [a, b, c, d, e, f, g, h] = least;  // sorting network of Batcher
  const auto order = [](float& low, float& high) {
    const float smaller = std::min(low, high);
    high = std::max(low, high);
    low = smaller;
  };
  order(a, b), order(c, d), order(e, f), order(g, h);
  order(a, c), order(b, d), order(e, g), order(f, h);
  order(b, c), order(f, g), order(a, e), order(d, h);
  order(b, f), order(c, g);
  order(b, e), order(d, g);
  order(c, e), order(d, f);
  order(d, e);
  least = {a, b, c, d, e, f, g, h};
  bound_ = std::min(bound_, least[static_cast<std::size_t>(k_ - 1)]);
}

inline void Nearest::scan(const PointRows& points, std::size_t n, float qx, float qy, float qz,
                          std::uint32_t max_stamp) {
  const std::size_t padded = (n + kLanes - 1) / kLanes * kLanes;
  for (std::size_t begin = 0; begin < padded; begin += kTile) {
    const std::size_t size = std::min(kTile, padded - begin);
    const float* x = points.x + begin;
    const float* y = points.y + begin;
    const float* z = points.z + begin;
    std::array<float, kTile> squared;
    for (std::size_t i = 0; i < size; ++i) {
      const float dx = x[i] - qx, dy = y[i] - qy, dz = z[i] - qz;
      squared[i] = dx * dx + dy * dy + dz * dz;
    }
    if (max_stamp != 0xffffffff) {
      const std::uint32_t* stamp = points.stamp + begin;
      for (std::size_t i = 0; i < size; ++i) squared[i] = stamp[i] <= max_stamp ? squared[i] : HUGE_VALF;
    }
    if (count_ == 0 && k_ <= static_cast<int>(kLanes)) tighten(squared.data(), size);
    // Not bytes and not the member: a byte may alias anything, and the bound would be loaded anew for every point.
    std::array<std::uint32_t, kTile> hits;
    std::size_t found = 0;
    const float bound = bound_;
    for (std::size_t i = 0; i < size; ++i) {  // no branch: which points are near is not predictable
      hits[found] = static_cast<std::uint32_t>(i);
      found += squared[i] <= bound ? 1 : 0;
    }
    for (std::size_t h = 0; h < found; ++h) {
      const std::size_t i = hits[h];
      if (squared[i] <= bound_) offer(squared[i], points.order + begin + i, x[i] - qx, y[i] - qy, z[i] - qz);
    }
  }
}

}  // namespace aslio
