#include "stores/block_hash.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <utility>

#include "aslio/core/spread.hpp"
#include "stores/shells.hpp"

namespace aslio::plugins {

namespace {

constexpr std::size_t kSmallest = 1024;  // slots
constexpr Brick kEmpty{};
/// Cells of a brick that are looked at one by one before its planes are made: these cost as much as some ten of them.
constexpr std::uint32_t kAlone = 8;

/// Keys of bricks: neighbours differ by a constant, at the edge of the range too, which bricks come nowhere near.
std::uint64_t key_of(const Cell& cell) { return pack_cell(cell.x >> 3, cell.y >> 3, cell.z >> 3); }

std::uint64_t step(int dx, int dy, int dz) { return pack_cell(dx, dy, dz) - pack_cell(0, 0, 0); }

/// The lowest cell of a brick.
Cell corner_of(std::uint64_t key) {
  constexpr std::uint64_t mask = (std::uint64_t{1} << 21) - 1;
  const auto axis = [&](unsigned shift) {
    return (static_cast<std::int32_t>(key >> shift & mask) - kCellRange) * Brick::kEdge;
  };
  return {axis(42), axis(21), axis(0)};
}

Cell lowest_around(const Cell& cell) {
  return {cell.x - kSurroundings, cell.y - kSurroundings, cell.z - kSurroundings};
}

/// visit(x, y, z, key) for the bricks in which the surroundings that begin at `lowest` lie.
template <typename Visit>
void for_corners(const Cell& lowest, const Visit& visit) {
  const std::uint64_t key = key_of(lowest);
  for (int x = 0; x <= (straddles(lowest.x) ? 1 : 0); ++x) {
    for (int y = 0; y <= (straddles(lowest.y) ? 1 : 0); ++y) {
      for (int z = 0; z <= (straddles(lowest.z) ? 1 : 0); ++z) {
        visit(static_cast<std::size_t>(x), static_cast<std::size_t>(y), static_cast<std::size_t>(z),
              key + step(x, y, z));
      }
    }
  }
}

unsigned log2_of(std::size_t power) { return static_cast<unsigned>(std::countr_zero(power)); }

/// Bits 8 y + z of the rows y in [y0, y1] and z in [z0, z1], relative to a brick and clipped to it.
std::uint64_t rectangle(std::int32_t y0, std::int32_t y1, std::int32_t z0, std::int32_t z1) {
  std::uint64_t bits = 0;
  for (std::int32_t y = std::max(0, y0); y <= std::min(7, y1); ++y) {
    for (std::int32_t z = std::max(0, z0); z <= std::min(7, z1); ++z) bits |= Brick::bit({0, y, z});
  }
  return bits;
}

/// Clears what lies outside [lo, hi]; the number of cells left.
std::size_t clip(Brick& brick, const Cell& corner, const Cell& lo, const Cell& hi) {
  const std::uint64_t inside = rectangle(lo.y - corner.y, hi.y - corner.y, lo.z - corner.z, hi.z - corner.z);
  std::size_t left = 0;
  for (std::int32_t x = 0; x < Brick::kEdge; ++x) {
    std::uint64_t& word = brick.words[static_cast<std::size_t>(x)];
    word &= corner.x + x >= lo.x && corner.x + x <= hi.x ? inside : 0;
    left += static_cast<std::size_t>(std::popcount(word));
  }
  return left;
}

}  // namespace

void BlockHash::describe(config::Binder& b, Params& p) {
  b.integer("cached", p.cached, "", {.min = 16, .max = 1 << 20},
            "bricks whose layers are kept between queries, rounded up to a power of two; a frame should touch fewer");
}

BlockHash::BlockHash(const Params& params, const BuildContext& context) {
  (void)context;
  cache_.assign(std::bit_ceil(static_cast<std::size_t>(params.cached)), Line{});
  line_shift_ = 64 - log2_of(cache_.size());
  rehash(kSmallest);
}

std::size_t BlockHash::first_slot(std::uint64_t key) const {
  // Four bricks above each other share a cache line: a dilation asks for three.
  return static_cast<std::size_t>((key >> 2) * kGoldenRatio >> slot_shift_) << 2 | (key & 3);
}

std::size_t BlockHash::slot_of(std::uint64_t key) const {
  std::size_t slot = first_slot(key);
  while (slots_[slot].key != key && slots_[slot].key != kNone) slot = (slot + 1) & (slots_.size() - 1);
  return slot;
}

const Brick* BlockHash::find(std::uint64_t key) const {
  const Slot& slot = slots_[slot_of(key)];
  return slot.key == key ? &bricks_[slot.brick] : &kEmpty;
}

std::size_t BlockHash::find_or_add(std::uint64_t key) {
  std::size_t slot = slot_of(key);
  if (slots_[slot].key == key) return slots_[slot].brick;
  if (2 * (bricks_.size() + 1) > slots_.size()) {
    rehash(2 * slots_.size());
    slot = slot_of(key);
  }
  slots_[slot] = {key, static_cast<std::uint32_t>(bricks_.size())};
  bricks_.emplace_back();
  labels_.push_back({key, 0});
  return bricks_.size() - 1;
}

void BlockHash::rehash(std::size_t slots) {
  slots_.assign(slots, Slot{});
  slot_shift_ = 64 + 2 - log2_of(slots);
  for (std::size_t i = 0; i < labels_.size(); ++i) {
    slots_[slot_of(labels_[i].key)] = {labels_[i].key, static_cast<std::uint32_t>(i)};
  }
}

std::size_t BlockHash::line_of(std::uint64_t key) const {
  return static_cast<std::size_t>(key * kGoldenRatio >> line_shift_);
}

void BlockHash::announce_change(std::uint64_t key) {
  for (int dx = -1; dx <= 1; ++dx) {
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dz = -1; dz <= 1; ++dz) {
        const std::uint64_t other = key + step(dx, dy, dz);
        Line& line = cache_[line_of(other)];
        if (line.key == other) line = {};
      }
    }
  }
}

std::size_t BlockHash::fetch(std::span<const Cell> cells, Keys& keys) const {
  const std::size_t count = std::min(kBatch, cells.size());
  for (std::size_t i = 0; i < count; ++i) {
    keys[i] = key_of(cells[i]);
    __builtin_prefetch(&slots_[first_slot(keys[i])]);
  }
  return count;
}

void BlockHash::insert(std::span<const Cell> cells) {
  Keys keys{};
  std::array<std::size_t, kBatch> bricks{};
  for (; !cells.empty(); cells = cells.subspan(std::min(kBatch, cells.size()))) {
    const std::size_t count = fetch(cells, keys);
    for (std::size_t i = 0; i < count; ++i) {
      bricks[i] = i > 0 && keys[i] == keys[i - 1] ? bricks[i - 1] : find_or_add(keys[i]);
      __builtin_prefetch(&bricks_[bricks[i]]);
      __builtin_prefetch(&labels_[bricks[i]]);
    }
    for (std::size_t i = 0; i < count; ++i) set(bricks[i], cells[i], keys[i]);
  }
}

void BlockHash::set(std::size_t brick, const Cell& cell, std::uint64_t key) {
  std::uint64_t& word = bricks_[brick].words[Brick::word(cell)];
  const std::uint64_t bit = Brick::bit(cell);
  if ((word & bit) != 0) return;
  word |= bit;
  ++size_;
  // Once between two queries is enough: nothing is dilated in between.
  if (std::exchange(labels_[brick].announced, queries_) != queries_) announce_change(key);
}

/// Null while looking at single cells is cheaper.
const Brick* BlockHash::planes_of(std::uint64_t key) {
  const std::size_t number = line_of(key), count = static_cast<std::size_t>(depth_);
  Line& line = cache_[number];
  if (line.key != key) line = {.key = key};
  Brick* planes = &planes_[number * count];
  if (line.dilated) return planes;
  if (depth_ <= kSurroundings && ++line.asked <= kAlone) return nullptr;
  line.dilated = true;
  ++dilations_;
  Neighbourhood around;
  std::size_t i = 0;
  for (int dx = -1; dx <= 1; ++dx) {
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dz = -1; dz <= 1; ++dz) around[i++] = find(key + step(dx, dy, dz));
    }
  }
  dilate(around, metric_, {planes, count});
  return planes;
}

int BlockHash::layer_alone(const Cell& cell) const {
  const Cell lowest = lowest_around(cell);
  Corners bricks{};
  for_corners(lowest,
              [&](std::size_t x, std::size_t y, std::size_t z, std::uint64_t key) { bricks[x][y][z] = find(key); });
  return layer_within(surroundings(bricks, lowest), depth_, metric_);
}

void BlockHash::layers(std::span<const Cell> cells, int depth, LayerMetric metric, std::span<std::uint8_t> out) {
  if (depth != depth_ || metric != metric_) {
    depth_ = depth;
    metric_ = metric;
    planes_.resize(cache_.size() * static_cast<std::size_t>(depth));
    forget_planes();
  }
  ++queries_;
  Keys keys{};
  std::array<const Brick*, kBatch> bricks{};
  for (; !cells.empty(); cells = cells.subspan(std::min(kBatch, cells.size()))) {
    const std::size_t count = fetch(cells, keys);
    for (std::size_t i = 0; i < count; ++i) {
      bricks[i] = i > 0 && keys[i] == keys[i - 1] ? bricks[i - 1] : find(keys[i]);
      __builtin_prefetch(bricks[i]);
    }
    // Most cells are occupied, and no reason to look around or to dilate.
    for (std::size_t i = 0; i < count; ++i) {
      out[i] = bricks[i]->has(cells[i]) ? 0 : 1;
      if (out[i] == 0 || depth == 0 || depth > kSurroundings) continue;
      for_corners(lowest_around(cells[i]), [&](std::size_t, std::size_t, std::size_t, std::uint64_t key) {
        __builtin_prefetch(&slots_[first_slot(key)]);
      });
    }
    for (std::size_t i = 0; i < count; ++i) {
      if (out[i] != 0) out[i] = layer_of_unoccupied(cells[i], keys[i]);
    }
    out = out.subspan(count);
  }
}

std::uint8_t BlockHash::layer_of_unoccupied(const Cell& cell, std::uint64_t key) {
  if (depth_ == 0) return 1;
  const Brick* planes = planes_of(key);
  if (!planes) return static_cast<std::uint8_t>(layer_alone(cell));
  int beyond = 1;  // planes without the cell; each contains the one before
  for (int layer = 1; layer <= depth_; ++layer) beyond += planes[layer - 1].has(cell) ? 0 : 1;
  return static_cast<std::uint8_t>(beyond);
}

void BlockHash::keep_inside(const Cell& lo, const Cell& hi) {
  const std::size_t before = size_;
  std::size_t kept = 0;
  size_ = 0;
  for (std::size_t i = 0; i < bricks_.size(); ++i) {
    const std::size_t left = clip(bricks_[i], corner_of(labels_[i].key), lo, hi);
    if (left == 0) continue;
    size_ += left;
    bricks_[kept] = bricks_[i];
    labels_[kept++] = labels_[i];
  }
  if (size_ == before) return;
  bricks_.resize(kept);
  labels_.resize(kept);
  rehash(std::max(kSmallest, std::bit_ceil(2 * kept + 2)));
  forget_planes();
}

void BlockHash::forget_planes() { std::fill(cache_.begin(), cache_.end(), Line{}); }

std::size_t BlockHash::memory_bytes() const {
  return sizeof(*this) + slots_.capacity() * sizeof(Slot) + bricks_.capacity() * sizeof(Brick) +
         labels_.capacity() * sizeof(Label) + cache_.capacity() * sizeof(Line) + planes_.capacity() * sizeof(Brick);
}

void BlockHash::clear() {
  std::fill(slots_.begin(), slots_.end(), Slot{});
  bricks_.clear();
  labels_.clear();
  size_ = 0;
  forget_planes();
}

}  // namespace aslio::plugins
