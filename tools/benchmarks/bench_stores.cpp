// Cost per point and memory per cell of the occupancy stores, on sweeps of 24000 points that move 1 m per frame along a
// street: the store alone, and soft_voxel with each store. Thread CPU time, one thread.

#include <fmt/format.h>

#include <algorithm>
#include <iomanip>
#include <iostream>
#include <random>
#include <string>
#include <vector>

#include "aslio/config/load.hpp"
#include "aslio/core/cpu_clock.hpp"
#include "aslio/plugin/registry.hpp"
#include "aslio/stages/build_context.hpp"
#include "overlaps/cell_of.hpp"
#include "register_all.hpp"
#include "street.hpp"

namespace {

using namespace aslio;
using benchmarks::sweep;

constexpr int kFrames = 60, kWarmUp = 20;
constexpr double kScored = kFrames - kWarmUp;

template <class F>
double seconds(F&& work) {
  double total = 0;
  {
    CpuTimer timer(total);
    work();
  }
  return total;
}

struct Cost {
  double query = 0, insert = 0;  // s
  std::size_t points = 0, bytes = 0, cells = 0;
  double score = 0;  // sum
};

void print(const std::string& name, const Cost& cost) {
  const auto points = static_cast<double>(cost.points);
  std::cout << "  " << std::left << std::setw(24) << name << std::right << std::fixed << std::setprecision(2)
            << std::setw(9) << 1e3 * cost.query / kScored << std::setw(9) << 1e3 * cost.insert / kScored
            << std::setprecision(1) << std::setw(9) << 1e9 * cost.query / points << std::setw(9)
            << 1e9 * cost.insert / points << std::setprecision(2) << std::setw(9)
            << static_cast<double>(cost.bytes) / 1e6;
  if (cost.cells > 0) {
    std::cout << std::setprecision(1) << std::setw(9)
              << static_cast<double>(cost.bytes) / static_cast<double>(cost.cells) << std::setw(10) << cost.cells;
  } else {
    std::cout << std::setw(19) << "" << std::setprecision(4) << std::setw(9) << cost.score / kScored;
  }
  std::cout << '\n';
}

/// The store alone: every point of a frame is asked and inserted.
Cost bench_store(OccupancyStore& store, double voxel, int depth) {
  std::mt19937_64 engine(1);
  Cost cost;
  for (int frame = 0; frame < kFrames; ++frame) {
    std::vector<Cell> cells;
    for (const WorldPoint& point : sweep(engine, 1.0 * frame)) {
      Cell cell;
      if (plugins::cell_of(point.p_W, 1.0 / voxel, cell)) cells.push_back(cell);
    }
    std::vector<std::uint8_t> layers(cells.size());
    const double query = seconds([&] { store.layers(cells, depth, LayerMetric::chebyshev, layers); });
    const double insert = seconds([&] { store.insert(cells); });
    if (frame < kWarmUp) continue;
    cost.query += query;
    cost.insert += insert;
    cost.points += cells.size();
  }
  cost.bytes = store.memory_bytes();
  cost.cells = store.size();
  return cost;
}

Cost bench_metric(OverlapMetric& metric) {
  std::mt19937_64 engine(1);
  Cost cost;
  for (int frame = 0; frame < kFrames; ++frame) {
    const std::vector<WorldPoint> points = sweep(engine, 1.0 * frame);
    const TimeNs t = frame * kSecond / 10;
    OverlapScore score;
    const double query = seconds([&] { score = metric.evaluate(points, t); });
    const double insert = seconds([&] { metric.extend(points, t); });
    if (frame < kWarmUp) continue;
    cost.query += query;
    cost.insert += insert;
    cost.points += points.size();
    cost.score += score.value.value_or(0);
  }
  cost.bytes = metric.memory_bytes();
  return cost;
}

/// A file of one metric.
struct MetricFile {
  config::Nested<OverlapMetric> overlap;
  static void describe(config::Binder& b, MetricFile& p) { b.stage("overlap", p.overlap, "the metric under test"); }
};

struct StoreFile {
  config::Nested<OccupancyStore> store;
  static void describe(config::Binder& b, StoreFile& p) { b.stage("store", p.store, "the store under test"); }
};

template <class File>
File file_of(const std::string& text, const plugin::Catalog& catalog) {
  return config::parse<File>("schema: aslio/pipeline/1\n" + text + "\n", "bench_stores", config::FileKind::pipeline,
                             catalog)
      .value;
}

void heading(const std::string& what, const char* last) {
  std::cout << what << "\n  " << std::left << std::setw(24) << "" << std::right << std::setw(9) << "query ms"
            << std::setw(9) << "ins. ms" << std::setw(9) << "ns/point" << std::setw(9) << "ns/point" << std::setw(9)
            << "MB" << last << '\n';
}

}  // namespace

int main() {
  exec::Executor exec(1);
  const SensorModel sensor;
  const BuildContext context{exec, sensor, nullptr};
  plugin::Catalog catalog;
  plugins::register_all(catalog);
  for (const std::string voxel : {"0.1", "0.2", "0.4"}) {
    for (const int depth : {0, 3}) {
      heading(fmt::format("store alone, voxel {} m, {} layers", voxel, depth), "   B/cell     cells");
      for (const auto& type : catalog.types(OccupancyStore::family)) {
        const auto store = file_of<StoreFile>("store: " + type, catalog).store.make(context);
        print(type, bench_store(*store, std::stod(voxel), depth));
      }
    }
    for (const std::string most : {"0", "5000"}) {
      heading(fmt::format("soft_voxel, voxel {} m, max_points {}", voxel, most), "                 mean O");
      for (const auto& type : catalog.types(OccupancyStore::family)) {
        for (const std::string delay : {"0", "0.1"}) {
          const std::string text =
              fmt::format("overlap: {{type: soft_voxel, voxel: {}, max_points: {}, delay: {}, store: {}}}", voxel, most,
                          delay, type);
          const auto metric = file_of<MetricFile>(text, catalog).overlap.make(context);
          print(fmt::format("{}, delay {} s", type, delay), bench_metric(*metric));
        }
      }
    }
  }
}
