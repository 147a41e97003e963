#include "stores/flat_hash.hpp"

#include <algorithm>
#include <bit>
#include <utility>

#include "stores/shells.hpp"

namespace aslio::plugins {

namespace {

constexpr unsigned kSmallestBits = 14;  // log2 of slots: 128 KB, room for the cells of a few frames

bool in_range(std::int32_t c) { return c >= -kCellRange && c < kCellRange; }
bool near_edge(std::int32_t c) {
  constexpr auto reach = static_cast<std::int32_t>(kMaxLayers);
  return c < -kCellRange + reach || c >= kCellRange - reach;
}

}  // namespace

void FlatHash::describe(config::Binder& b, Params& p) {
  (void)b;
  (void)p;
}

FlatHash::FlatHash(const Params& params, const BuildContext& context) {
  (void)params;
  (void)context;
  rebuild(kSmallestBits, [](std::uint64_t) { return true; });
}

template <class Keep>
void FlatHash::rebuild(unsigned log2_size, Keep&& keep) {
  const auto old = std::exchange(keys_, std::vector<std::uint64_t>(std::size_t{1} << log2_size, kEmpty));
  mask_ = keys_.size() - 1;
  shift_ = 64 + 3 - log2_size;
  size_ = 0;
  for (const std::uint64_t key : old) {
    if (key != kEmpty && keep(key)) add(key);
  }
}

void FlatHash::add(std::uint64_t key) {
  std::size_t slot = home(key);
  for (; keys_[slot] != kEmpty; slot = (slot + 1) & mask_) {
    if (keys_[slot] == key) return;
  }
  keys_[slot] = key;
  ++size_;
}

void FlatHash::insert(std::span<const Cell> cells) {
  for (const Cell& cell : cells) {
    if (2 * (size_ + 1) > keys_.size()) {
      rebuild(static_cast<unsigned>(std::bit_width(keys_.size())), [](std::uint64_t) { return true; });
    }
    add(pack_cell(cell.x, cell.y, cell.z));
  }
}

int FlatHash::layer(const Cell& cell, int depth, LayerMetric metric) const {
  const std::uint64_t key = pack_cell(cell.x, cell.y, cell.z);
  if (contains(key)) return 0;
  const Shells& shells = Shells::of(metric);
  const bool edge = near_edge(cell.x) || near_edge(cell.y) || near_edge(cell.z);
  for (int i = 1; i <= depth; ++i) {
    for (const Shells::Offset& offset : shells.layer(i)) {
      // Across the edge a key would carry into the next axis.
      if (edge && !(in_range(cell.x + offset.x) && in_range(cell.y + offset.y) && in_range(cell.z + offset.z)))
        continue;
      if (contains(key + offset.key_step)) return i;
    }
  }
  return depth + 1;
}

void FlatHash::layers(std::span<const Cell> cells, int depth, LayerMetric metric, std::span<std::uint8_t> out) {
  for (std::size_t i = 0; i < cells.size(); ++i) out[i] = static_cast<std::uint8_t>(layer(cells[i], depth, metric));
}

void FlatHash::keep_inside(const Cell& lo, const Cell& hi) {
  const auto inside = [&](std::uint64_t key) {
    constexpr std::uint64_t mask = (std::uint64_t{1} << 21) - 1;
    const auto x = static_cast<std::int32_t>(key >> 42) - kCellRange;
    const auto y = static_cast<std::int32_t>(key >> 21 & mask) - kCellRange;
    const auto z = static_cast<std::int32_t>(key & mask) - kCellRange;
    return x >= lo.x && x <= hi.x && y >= lo.y && y <= hi.y && z >= lo.z && z <= hi.z;
  };
  const auto kept = static_cast<std::size_t>(
      std::count_if(keys_.begin(), keys_.end(), [&](std::uint64_t key) { return key != kEmpty && inside(key); }));
  if (kept == size_) return;
  rebuild(std::max(kSmallestBits, static_cast<unsigned>(std::bit_width(2 * kept + 1))), inside);
}

void FlatHash::clear() {
  std::fill(keys_.begin(), keys_.end(), kEmpty);
  size_ = 0;
}

}  // namespace aslio::plugins
