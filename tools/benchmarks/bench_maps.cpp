// Timings of the map and the plane fit on points of a generated street with the given spacing.
// bench_maps [map points] [spacing in m]; thread CPU time, one thread.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <iomanip>
#include <iostream>
#include <random>
#include <vector>

#include "aslio/core/cpu_clock.hpp"
#include "maps/ikd_tree.hpp"
#include "maps/voxel_hash.hpp"
#include "residuals/point_to_plane.hpp"

namespace {

using namespace aslio;

/// Uniform numbers in [0, 1) that are the same everywhere (std distributions are not).
class Uniform {
 public:
  double operator()() { return static_cast<double>(engine_() >> 11) * 0x1p-53; }

 private:
  std::mt19937_64 engine_{1};
};

/// A point on the ground or on one of the walls of streets 20 m apart, with 1 cm of noise.
WorldPoint street_point(Uniform& uniform, double extent) {
  WorldPoint point;
  const double u = extent * uniform(), v = uniform();
  const double noise = 0.01 * (uniform() + uniform() - 1.0);
  const double lane = 20.0 * std::floor(extent / 20.0 * uniform());
  const double kind = uniform();
  if (kind < 0.4) {
    point.p_W = Vec3(u, extent * v, noise);
  } else if (kind < 0.7) {
    point.p_W = Vec3(u, lane + noise, 10.0 * v);
  } else {
    point.p_W = Vec3(lane + noise, u, 10.0 * v);
  }
  point.p_W += Vec3(0.37, 0.61, 0.43);  // off the boundaries of voxels
  point.range = 20.0F;
  return point;
}

template <class F>
double seconds(F&& work) {
  double total = 0;
  {
    CpuTimer timer(total);
    work();
  }
  return total;
}

void report(const char* what, double value, const char* unit) {
  std::cout << std::left << std::setw(44) << what << std::right << std::setw(12) << std::fixed << std::setprecision(2)
            << value << ' ' << unit << '\n';
}

void bench_map(const char* name, Map& map, const BuildContext& context, std::size_t target, double spacing) {
  Uniform uniform;
  std::cout << name << '\n';
  // Ground and walls hold extent^2 * 2.5 / spacing^2 points or so.
  const double extent = std::max(40.0, spacing * std::sqrt(static_cast<double>(target)));
  std::size_t offered = 0;
  double insert_time = 0, longest = 0;
  std::vector<WorldPoint> batch(5000);
  for (std::uint32_t stamp = 1; map.size() < target && stamp < 4000; ++stamp) {
    for (auto& point : batch) point = street_point(uniform, extent);
    const double time = seconds([&] { map.insert(batch, stamp); });
    insert_time += time;
    longest = std::max(longest, time);
    offered += batch.size();
  }
  report("map points", static_cast<double>(map.size()), "");
  report("insert, per point offered", 1e9 * insert_time / static_cast<double>(offered), "ns");
  report("insert, per point kept", 1e9 * insert_time / static_cast<double>(map.size()), "ns");
  report("insert, longest of 5000 points", 1e3 * longest, "ms");
  report("memory per point", static_cast<double>(map.memory_bytes()) / static_cast<double>(map.size()), "B");

  // A frame sees a part of the map: queries around one place, as they come from a sensor.
  constexpr std::size_t count = 5000;
  constexpr int frames = 40;
  Neighbours neighbours;
  std::vector<Surface> surfaces(count);
  std::vector<Vec3> queries(count);
  plugins::PointToPlane residual({}, context);
  double search_time = 0, fit_time = 0;
  std::size_t full = 0, valid = 0;
  for (int frame = 0; frame < frames; ++frame) {
    const double view = std::min(extent, 60.0);
    const Vec3 corner(20 * std::floor((extent - view) * uniform() / 20),
                      20 * std::floor((extent - view) * uniform() / 20), 0);
    for (auto& query : queries) query = corner + street_point(uniform, view).p_W;
    search_time += seconds([&] { map.correspond(queries, residual.query(), neighbours); });
    fit_time += seconds([&] { residual.fit(queries, neighbours, surfaces); });
    for (std::size_t i = 0; i < count; ++i) {
      full += neighbours.count[i] == 5 ? 1 : 0;
      valid += surfaces[i].valid ? 1 : 0;
    }
  }
  const double searched = count * frames;
  report("search k = 5 within 1 m, per query", 1e9 * search_time / searched, "ns");
  report("plane fit, per query", 1e9 * fit_time / searched, "ns");
  report("queries with 5 neighbours", 100.0 * static_cast<double>(full) / searched, "%");
  report("queries with a plane", 100.0 * static_cast<double>(valid) / searched, "%");
}

}  // namespace

int main(int argc, char** argv) {
  const std::size_t target = argc > 1 ? std::strtoul(argv[1], nullptr, 10) : 1000000;
  const double spacing = argc > 2 ? std::strtod(argv[2], nullptr) : 0.1;
  exec::Executor exec(1);
  const SensorModel sensor;
  const BuildContext context{exec, sensor, nullptr};
  plugins::VoxelHash::Params hash;
  hash.min_spacing = spacing;
  plugins::VoxelHash voxel_hash(hash, context);
  bench_map("voxel_hash", voxel_hash, context, target, spacing);
  plugins::IkdTree::Params tree;
  tree.leaf = spacing;
  tree.radius = 1e4;
  plugins::IkdTree ikd_tree(tree, context);
  bench_map("ikd_tree", ikd_tree, context, target, spacing);
}
