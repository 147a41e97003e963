#pragma once

#include <cstdint>
#include <vector>

#include "aslio/config/binder.hpp"
#include "aslio/stages/build_context.hpp"
#include "aslio/stages/overlap.hpp"

namespace my_plugin {

/// Which cells of space are occupied? Here: a sorted list of cells, in which a query looks at those near it along x.
/// The contract stands in aslio/stages/overlap.hpp.
class MyStage final : public aslio::OccupancyStore {
 public:
  /// Defaults stand here and nowhere else.
  struct Params {
    std::int64_t reserve = 65536;
  };
  /// Names, units, ranges and meanings: for `aslio describe` and for the check of a configuration.
  static void describe(aslio::config::Binder& b, Params& p);

  MyStage(const Params& params, const aslio::BuildContext& context);

  void insert(std::span<const aslio::Cell> cells) override;
  void layers(std::span<const aslio::Cell> cells, int depth, aslio::LayerMetric metric,
              std::span<std::uint8_t> out) override;
  void keep_inside(const aslio::Cell& lo, const aslio::Cell& hi) override;
  std::size_t size() const override { return cells_.size(); }
  std::size_t memory_bytes() const override { return cells_.capacity() * sizeof(aslio::Cell); }
  void clear() override { cells_.clear(); }

 private:
  std::vector<aslio::Cell> cells_;  ///< sorted by x, y, z, each once
};

}  // namespace my_plugin
