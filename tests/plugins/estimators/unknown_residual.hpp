#pragma once
/// A residual of planes of which nobody knows how well they are known.

#include <limits>
#include <span>

#include "aslio/config/binder.hpp"
#include "aslio/plugin/registry.hpp"
#include "aslio/stages/build_context.hpp"
#include "aslio/stages/residual.hpp"
#include "plugins/under_test.hpp"

namespace aslio::test {

/// `unknown`: the information of a match of the map is not a number. Surfaces that it has not fitted itself are as good
/// as sigma says.
class UnknownResidual final : public Residual {
 public:
  struct Params {};
  static void describe(config::Binder&, Params&) {}
  UnknownResidual(const Params&, const BuildContext&) {}

  int rows_per_match() const override { return 1; }
  MapQuery query() const override { return {.k = 1, .max_distance = 1.0}; }
  void fit(std::span<const Vec3> queries, const Neighbours& neighbours, std::span<Surface> out) override {
    for (std::size_t i = 0; i < queries.size(); ++i) {
      out[i] = {};
      out[i].anchor = queries[i];
      out[i].normal = Vec3::UnitX();
      out[i].quality = std::numeric_limits<double>::quiet_NaN();
      out[i].valid = neighbours.count[i] > 0;
    }
  }
  void evaluate(std::span<const Vec3> world, std::span<const float>, std::span<const Surface> surfaces, double sigma,
                std::span<ResidualRow> rows) override {
    for (std::size_t i = 0; i < world.size(); ++i) {
      const Surface& surface = surfaces[i];
      rows[i] = surface.valid ? ResidualRow{surface.normal.dot(world[i] - surface.anchor), surface.normal,
                                            surface.quality / (sigma * sigma)}
                              : ResidualRow{};
    }
  }
};

/// The stages under test, and that one.
inline plugin::Catalog stages_and_unknown() {
  plugin::Catalog stages = stages_under_test();
  plugin::Registry<Residual>(stages).add<UnknownResidual>("unknown", "planes of unknown noise");
  return stages;
}

}  // namespace aslio::test
