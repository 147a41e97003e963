#pragma once

#include "aslio/config/binder.hpp"
#include "aslio/stages/build_context.hpp"
#include "aslio/stages/overlap.hpp"
#include "stores/coordinate_table.hpp"

namespace aslio::plugins {

/// Occupied cells in AS-LIO's three-layer embedded hash: x to y to the set of z. A look-up is up to three probes and
/// stops at the first layer that misses. A query looks at the shells around a cell from the inside out and stops at the
/// first hit; each column (x, y) is looked up once per queried cell. layers() may be called concurrently.
class NestedHash final : public OccupancyStore {
 public:
  struct Params {};
  static void describe(config::Binder& b, Params& p);
  NestedHash(const Params& params, const BuildContext& context);

  void insert(std::span<const Cell> cells) override;
  void layers(std::span<const Cell> cells, int depth, LayerMetric metric, std::span<std::uint8_t> out) override;
  void keep_inside(const Cell& lo, const Cell& hi) override;
  std::size_t size() const override { return size_; }
  /// Walks over all columns.
  std::size_t memory_bytes() const override;
  void clear() override;

 private:
  struct Occupied {};
  using Column = CoordinateTable<Occupied>;  // of z
  using Plane = CoordinateTable<Column>;     // of y
  const Column* column(std::int32_t x, std::int32_t y) const {
    const Plane* plane = planes_.find(x);
    return plane ? plane->find(y) : nullptr;
  }
  int layer(const Cell& cell, int depth, LayerMetric metric) const;

  CoordinateTable<Plane> planes_;  // of x
  std::size_t size_ = 0;
};

}  // namespace aslio::plugins
