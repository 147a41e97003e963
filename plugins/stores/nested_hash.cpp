#include "stores/nested_hash.hpp"

#include <array>

#include "stores/shells.hpp"

namespace aslio::plugins {

void NestedHash::describe(config::Binder& b, Params& p) {
  (void)b;
  (void)p;
}

NestedHash::NestedHash(const Params& params, const BuildContext& context) {
  (void)params;
  (void)context;
}

void NestedHash::insert(std::span<const Cell> cells) {
  for (const Cell& cell : cells) {
    Plane& plane = planes_.value(planes_.add(cell.x).first);
    Column& column = plane.value(plane.add(cell.y).first);
    if (column.add(cell.z).second) ++size_;
  }
}

int NestedHash::layer(const Cell& cell, int depth, LayerMetric metric) const {
  const Column* centre = column(cell.x, cell.y);
  if (centre && centre->contains(cell.z)) return 0;
  const Shells& shells = Shells::of(metric);
  constexpr int reach = static_cast<int>(kMaxLayers) - 1;
  constexpr auto width = static_cast<std::size_t>(2 * reach + 1);
  struct Looked {
    const Column* column = nullptr;
    bool known = false;
  };
  std::array<std::array<Looked, width>, width> around;
  for (int x = reach - depth; x <= reach + depth; ++x) {
    for (int y = reach - depth; y <= reach + depth; ++y)
      around[static_cast<std::size_t>(x)][static_cast<std::size_t>(y)] = {};
  }
  for (int i = 1; i <= depth; ++i) {
    for (const Shells::Offset& offset : shells.layer(i)) {
      Looked& looked = around[static_cast<std::size_t>(reach + offset.x)][static_cast<std::size_t>(reach + offset.y)];
      if (!looked.known) looked = {column(cell.x + offset.x, cell.y + offset.y), true};
      if (looked.column && looked.column->contains(cell.z + offset.z)) return i;
    }
  }
  return depth + 1;
}

void NestedHash::layers(std::span<const Cell> cells, int depth, LayerMetric metric, std::span<std::uint8_t> out) {
  for (std::size_t i = 0; i < cells.size(); ++i) out[i] = static_cast<std::uint8_t>(layer(cells[i], depth, metric));
}

void NestedHash::keep_inside(const Cell& lo, const Cell& hi) {
  size_ = 0;
  planes_.retain([&](std::int32_t x, Plane& plane) {
    if (x < lo.x || x > hi.x) return false;
    plane.retain([&](std::int32_t y, Column& column) {
      if (y < lo.y || y > hi.y) return false;
      column.retain([&](std::int32_t z) { return z >= lo.z && z <= hi.z; });
      size_ += column.size();
      return column.size() > 0;
    });
    return plane.size() > 0;
  });
}

std::size_t NestedHash::memory_bytes() const {
  std::size_t bytes = sizeof(*this) + planes_.table_bytes();
  planes_.for_each([&](const Plane& plane) {
    bytes += plane.table_bytes();
    plane.for_each([&](const Column& column) { bytes += column.table_bytes(); });
  });
  return bytes;
}

void NestedHash::clear() {
  planes_ = {};
  size_ = 0;
}

}  // namespace aslio::plugins
