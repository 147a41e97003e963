#pragma once
/// What a drive along a street costs the metric of the overlap, by its store.

#include <random>
#include <string>
#include <vector>

#include "aslio/core/cpu_clock.hpp"
#include "aslio/stages/overlap.hpp"
#include "plugins/overlaps/one_stage.hpp"
#include "street.hpp"

namespace aslio::test {

/// Of a metric on 60 sweeps.
struct Cost {
  double cpu_s = 0;  ///< [s]
  std::size_t bytes = 0;
};

/// 60 m of a street, a sweep per metre, scored and learnt.
inline Cost drive(const plugin::Catalog& catalog, const std::string& store, const BuildContext& context) {
  const auto metric = make_stage<OverlapMetric>(
      catalog, "{type: soft_voxel, voxel: 0.2, layers: 3, max_points: 0, store: {type: " + store + "}}", context);
  std::mt19937_64 engine(1);
  Cost cost;
  for (int frame = 0; frame < 60; ++frame) {
    const std::vector<WorldPoint> points = benchmarks::sweep(engine, frame);
    const CpuTimer timer(cost.cpu_s);
    metric->evaluate(points, frame * kSecond / 10);
    metric->extend(points, frame * kSecond / 10);
  }
  cost.bytes = metric->memory_bytes();
  return cost;
}

}  // namespace aslio::test
