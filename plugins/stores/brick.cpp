#include "stores/brick.hpp"

#include <cstdlib>

#include "stores/shells.hpp"

namespace aslio::plugins {

namespace {

/// Words of three bricks in a row along x.
using Words = std::array<std::uint64_t, 3 * Brick::kEdge>;

/// The words that a dilation looks at.
struct Extent {
  std::size_t begin, end;
};

/// The byte in each of the eight rows along z of a word.
constexpr std::uint64_t in_each_row(unsigned byte) { return 0x0101010101010101u * (byte & 0xffu); }

/// The bricks at one y (below, in the middle, above), smeared along z by 0, 1, .. cells.
using Smeared = std::array<Words, 3>;

void smear_along_z(const Neighbourhood& around, std::size_t reach, std::array<Smeared, kMaxLayers>& out) {
  for (std::size_t i = 0; i < 9; ++i) {
    const std::size_t by = i % 3, begin = 8 * (i / 3);
    const auto &below = around[3 * i]->words, &middle = around[3 * i + 1]->words, &above = around[3 * i + 2]->words;
    for (std::size_t x = 0; x < 8; ++x) out[0][by][begin + x] = middle[x];
    for (std::size_t w = 1; w <= reach; ++w) {
      const auto shift = static_cast<unsigned>(w);
      // Masks cut off what a shift carries from one row into the next.
      const std::uint64_t up = in_each_row(0xffu << shift), from_below = ~up;
      const std::uint64_t down = in_each_row(0xffu >> shift), from_above = ~down;
      const std::uint64_t* nearer = &out[w - 1][by][begin];
      std::uint64_t* grown = &out[w][by][begin];
      for (std::size_t x = 0; x < 8; ++x) {
        grown[x] = nearer[x] | (middle[x] << shift & up) | (below[x] >> (8 - shift) & from_below) |
                   (middle[x] >> shift & down) | (above[x] << (8 - shift) & from_above);
      }
    }
  }
}

/// The cells within a ball whose x differs by `dx`: rows smeared along z, then along y.
void smear_along_y(const std::array<Smeared, kMaxLayers>& rows, const Balls& balls, std::size_t layer, std::size_t dx,
                   Extent extent, Words& out) {
  const Words& centre = rows[static_cast<std::size_t>(balls.reach(layer, dx, 0))][1];
  for (std::size_t x = extent.begin; x < extent.end; ++x) out[x] = centre[x];
  for (std::size_t dy = 1; dy <= layer && balls.reach(layer, dx, dy) >= 0; ++dy) {
    const auto& [below, middle, above] = rows[static_cast<std::size_t>(balls.reach(layer, dx, dy))];
    const auto near = static_cast<unsigned>(8 * dy), far = 64 - near;
    for (std::size_t x = extent.begin; x < extent.end; ++x) {
      out[x] |= middle[x] << near | below[x] >> far | middle[x] >> near | above[x] << far;
    }
  }
}

}  // namespace

Balls::Balls(LayerMetric metric) {
  constexpr int layers = static_cast<int>(kMaxLayers);
  for (int layer = 0; layer < layers; ++layer) {
    for (int dx = 0; dx <= layers; ++dx) {
      for (int dy = 0; dy < layers; ++dy) {
        int reach = layer;
        while (reach >= 0 && layer_of(dx, dy, reach, metric) > layer) --reach;
        reaches_[static_cast<std::size_t>(layer)][static_cast<std::size_t>(dx)][static_cast<std::size_t>(dy)] =
            static_cast<std::int8_t>(reach);
      }
    }
  }
}

const Balls& Balls::of(LayerMetric metric) {
  static const std::array<Balls, 3> tables{Balls(LayerMetric::chebyshev), Balls(LayerMetric::manhattan),
                                           Balls(LayerMetric::euclid_rounded)};
  return tables[static_cast<std::size_t>(metric)];
}

void dilate(const Neighbourhood& around, LayerMetric metric, std::span<Brick> planes) {
  std::array<Smeared, kMaxLayers> rows;
  smear_along_z(around, planes.size(), rows);
  const Balls& balls = Balls::of(metric);
  const Extent extent = planes.size() <= 4 ? Extent{4, 20} : Extent{0, 24};  // whole vectors
  for (std::size_t layer = 1; layer <= planes.size(); ++layer) {
    Words slice;
    Brick grown;
    for (std::size_t dx = 0; dx <= layer; ++dx) {
      if (dx == 0 || !balls.repeats(layer, dx - 1)) smear_along_y(rows, balls, layer, dx, extent, slice);
      const std::uint64_t *left = &slice[8 - dx], *right = &slice[8 + dx];
      for (std::size_t x = 0; x < 8; ++x) grown.words[x] |= left[x] | right[x];
    }
    planes[layer - 1] = grown;
  }
}

Surroundings surroundings(const Corners& bricks, const Cell& lowest) {
  Surroundings out;
  const auto up = static_cast<unsigned>(8 * (lowest.y & 7)), along = static_cast<unsigned>(lowest.z & 7);
  const bool two_y = straddles(lowest.y), two_z = straddles(lowest.z);
  // Masks cut off what a shift carries from one row into the next.
  const std::uint64_t low_z = in_each_row(0xffu >> along), high_z = in_each_row(0xffu << (8 - along));
  for (std::size_t i = 0; i < out.size(); ++i) {
    const std::size_t x = static_cast<std::size_t>(lowest.x & 7) + i;
    const auto& at = bricks[x >> 3];
    const auto rows = [&](std::size_t z) {
      const std::uint64_t below = at[0][z]->words[x & 7] >> up;
      return two_y ? below | at[1][z]->words[x & 7] << (64 - up) : below;
    };
    out[i] = rows(0) >> along & low_z;
    if (two_z) out[i] |= rows(1) << (8 - along) & high_z;
  }
  return out;
}

namespace {

/// The bits of the surroundings within `layer` of the middle, in the word |dx| from it.
class BallMasks {
 public:
  explicit BallMasks(const Balls& balls) {
    for (std::size_t layer = 1; layer <= kSurroundings; ++layer) {
      for (std::size_t dx = 0; dx <= layer; ++dx) {
        for (int dy = -kSurroundings; dy <= kSurroundings; ++dy) {
          const int reach = balls.reach(layer, dx, static_cast<std::size_t>(std::abs(dy)));
          for (int dz = -reach; dz <= reach; ++dz) {
            masks_[layer - 1][dx] |= Brick::bit({0, dy + kSurroundings, dz + kSurroundings});
          }
        }
      }
    }
  }
  std::uint64_t mask(std::size_t layer, std::size_t dx) const { return masks_[layer - 1][dx]; }
  static const BallMasks& of(LayerMetric metric) {
    static const std::array<BallMasks, 3> tables{BallMasks(Balls::of(LayerMetric::chebyshev)),
                                                 BallMasks(Balls::of(LayerMetric::manhattan)),
                                                 BallMasks(Balls::of(LayerMetric::euclid_rounded))};
    return tables[static_cast<std::size_t>(metric)];
  }

 private:
  std::array<std::array<std::uint64_t, kSurroundings + 1>, kSurroundings> masks_{};
};

}  // namespace

int layer_within(const Surroundings& around, int depth, LayerMetric metric) {
  const BallMasks& masks = BallMasks::of(metric);
  for (int layer = 1; layer <= depth; ++layer) {
    const auto l = static_cast<std::size_t>(layer);
    std::uint64_t set = around[kSurroundings] & masks.mask(l, 0);
    for (std::size_t dx = 1; dx <= l; ++dx) {
      set |= (around[kSurroundings - dx] | around[kSurroundings + dx]) & masks.mask(l, dx);
    }
    if (set != 0) return layer;
  }
  return depth + 1;
}

}  // namespace aslio::plugins
