#include "stores/brick.hpp"

#include "stores/shells.hpp"

namespace aslio::plugins {

namespace {

constexpr std::size_t kSpan = 3 * Brick::kEdge;  // words of three bricks in a row along x

/// The byte in each of the eight rows along z of a word.
constexpr std::uint64_t in_each_row(unsigned byte) { return 0x0101010101010101u * (byte & 0xffu); }

/// Columns of bricks at one y (below, in the middle, above), smeared along z by 0, 1, .. cells.
using Smeared = std::array<std::array<std::uint64_t, kSpan>, 3>;

void smear_along_z(const Neighbourhood& around, std::size_t reach, std::array<Smeared, kMaxLayers>& out) {
  for (std::size_t bx = 0; bx < 3; ++bx) {
    for (std::size_t by = 0; by < 3; ++by) {
      const Brick* const* column = &around[9 * bx + 3 * by];
      const auto &below = column[0]->words, &middle = column[1]->words, &above = column[2]->words;
      const std::size_t begin = 8 * bx;
      for (std::size_t x = 0; x < 8; ++x) out[0][by][begin + x] = middle[x];
      for (std::size_t w = 1; w <= reach; ++w) {
        const auto shift = static_cast<unsigned>(w);
        // Masks cut off what a shift carries from one row into the next.
        const std::uint64_t up = in_each_row(0xffu << shift), from_below = ~up;
        const std::uint64_t down = in_each_row(0xffu >> shift), from_above = ~down;
        for (std::size_t x = 0; x < 8; ++x) {
          out[w][by][begin + x] = out[w - 1][by][begin + x] | (middle[x] << shift & up) |
                                  (below[x] >> (8 - shift) & from_below) | (middle[x] >> shift & down) |
                                  (above[x] << (8 - shift) & from_above);
        }
      }
    }
  }
}

/// out |= the smeared words, dx cells along x and dy along y from there.
void add_row(const Smeared& smeared, int dx, int dy, Brick& out) {
  const auto begin = static_cast<std::size_t>(Brick::kEdge + dx);
  const std::uint64_t* middle = &smeared[1][begin];
  if (dy == 0) {
    for (std::size_t x = 0; x < 8; ++x) out.words[x] |= middle[x];
  } else if (dy > 0) {
    const std::uint64_t* next = &smeared[2][begin];
    for (std::size_t x = 0; x < 8; ++x) out.words[x] |= middle[x] >> 8 * dy | next[x] << (64 - 8 * dy);
  } else {
    const std::uint64_t* next = &smeared[0][begin];
    for (std::size_t x = 0; x < 8; ++x) out.words[x] |= middle[x] << -8 * dy | next[x] >> (64 + 8 * dy);
  }
}

}  // namespace

Balls::Balls(LayerMetric metric) {
  for (int layer = 0; layer < static_cast<int>(kMaxLayers); ++layer) {
    for (int dx = -layer; dx <= layer; ++dx) {
      for (int dy = -layer; dy <= layer; ++dy) {
        int reach = layer;
        while (reach >= 0 && layer_of(dx, dy, reach, metric) > layer) --reach;
        if (reach < 0) continue;
        rows_[static_cast<std::size_t>(layer)].push_back(
            {static_cast<std::int8_t>(dx), static_cast<std::int8_t>(dy), static_cast<std::int8_t>(reach)});
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
  planes[0] = *around[13];
  if (planes.size() == 1) return;
  std::array<Smeared, kMaxLayers> smeared;
  smear_along_z(around, planes.size() - 1, smeared);
  const Balls& balls = Balls::of(metric);
  for (std::size_t layer = 1; layer < planes.size(); ++layer) {
    Brick grown;
    for (const Balls::Row& row : balls.within(static_cast<int>(layer))) {
      add_row(smeared[static_cast<std::size_t>(row.reach)], row.dx, row.dy, grown);
    }
    planes[layer] = grown;
  }
}

}  // namespace aslio::plugins
