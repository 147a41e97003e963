#include "my_stage.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <tuple>

#include "aslio/plugin/entry.hpp"

namespace my_plugin {

using namespace aslio;

namespace {

bool before(const Cell& a, const Cell& b) { return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z); }

int distance(const Cell& a, const Cell& b, LayerMetric metric) {
  const int x = std::abs(a.x - b.x), y = std::abs(a.y - b.y), z = std::abs(a.z - b.z);
  if (metric == LayerMetric::chebyshev) return std::max({x, y, z});
  if (metric == LayerMetric::manhattan) return x + y + z;
  return static_cast<int>(std::lround(std::hypot(x, y, z)));
}

}  // namespace

void MyStage::describe(config::Binder& b, Params& p) {
  b.integer("reserve", p.reserve, "", {.min = 0, .max = 1e8}, "cells to make room for at the start");
}

MyStage::MyStage(const Params& params, const BuildContext& context) {
  (void)context;
  cells_.reserve(static_cast<std::size_t>(params.reserve));
}

void MyStage::insert(std::span<const Cell> cells) {
  const auto known = static_cast<std::ptrdiff_t>(cells_.size());
  cells_.insert(cells_.end(), cells.begin(), cells.end());
  std::sort(cells_.begin() + known, cells_.end(), before);
  std::inplace_merge(cells_.begin(), cells_.begin() + known, cells_.end(), before);
  cells_.erase(std::unique(cells_.begin(), cells_.end()), cells_.end());
}

void MyStage::layers(std::span<const Cell> cells, int depth, LayerMetric metric, std::span<std::uint8_t> out) {
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const Cell& cell = cells[i];
    int nearest = depth + 1;
    auto other = std::lower_bound(cells_.begin(), cells_.end(), cell.x - depth,
                                  [](const Cell& c, std::int32_t x) { return c.x < x; });
    for (; other != cells_.end() && other->x <= cell.x + depth; ++other) {
      nearest = std::min(nearest, distance(cell, *other, metric));
    }
    out[i] = static_cast<std::uint8_t>(nearest);
  }
}

void MyStage::keep_inside(const Cell& lo, const Cell& hi) {
  std::erase_if(cells_, [&](const Cell& c) {
    return c.x < lo.x || c.x > hi.x || c.y < lo.y || c.y > hi.y || c.z < lo.z || c.z > hi.z;
  });
}

namespace {

void register_types(plugin::Catalog& catalog) {
  plugin::Registry<OccupancyStore>(catalog).add<MyStage>("my_stage", "A sorted list of cells.");
}

}  // namespace

}  // namespace my_plugin

ASLIO_PLUGIN(my_plugin::register_types)
