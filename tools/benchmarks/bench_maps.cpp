// Timings of the map, the plane fit and the overlap metrics on points of a generated street with the given spacing.
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
#include "maps/voxel_hash.hpp"
#include "overlaps/soft_voxel.hpp"
#include "residuals/point_to_plane.hpp"
#include "stores/flat_hash.hpp"

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

/// A sweep of 64 beams at 375 azimuths from (x, 0, 1.8) in a street 20 m wide with a house corner every 15 m.
std::vector<WorldPoint> sweep(Uniform& uniform, double x) {
  std::vector<WorldPoint> points;
  for (int beam = 0; beam < 64; ++beam) {
    for (int step = 0; step < 375; ++step) {
      const double elevation = (-25.0 + 0.6 * beam) * 0.01745, azimuth = 6.2832 * (step + uniform()) / 375.0;
      const Vec3 ray(std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
                     std::sin(elevation));
      double range = ray.z() < 0 ? -1.8 / ray.z() : 80.0;
      double wall = 10.0 / std::max(1e-3, std::abs(ray.y()));
      const double along = x + wall * ray.x();
      if (std::fmod(std::abs(along), 15.0) < 5.0) wall *= 1.3;  // set back
      range = std::min({range, wall, 80.0}) + 0.02 * (uniform() + uniform() - 1.0);
      WorldPoint point;
      point.p_W = Vec3(x, 0, 1.8) + range * ray;
      point.range = static_cast<float>(range);
      points.push_back(point);
    }
  }
  return points;
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

void bench_map(const BuildContext& context, std::size_t target, double spacing) {
  Uniform uniform;
  plugins::VoxelHash::Params params;
  params.min_spacing = spacing;
  plugins::VoxelHash map(params, context);
  // Ground and walls hold extent^2 * 2.5 / spacing^2 points or so.
  const double extent = std::max(40.0, spacing * std::sqrt(static_cast<double>(target)));
  std::size_t offered = 0;
  double insert_time = 0;
  std::vector<WorldPoint> batch(5000);
  for (std::uint32_t stamp = 1; map.size() < target && stamp < 4000; ++stamp) {
    for (auto& point : batch) point = street_point(uniform, extent);
    insert_time += seconds([&] { map.insert(batch, stamp); });
    offered += batch.size();
  }
  report("map points", static_cast<double>(map.size()), "");
  report("insert, per point offered", 1e9 * insert_time / static_cast<double>(offered), "ns");
  report("insert, per point kept", 1e9 * insert_time / static_cast<double>(map.size()), "ns");
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

void bench_overlap(const BuildContext& context, double voxel, std::int64_t max_points) {
  Uniform uniform;
  plugins::SoftVoxel::Params params;
  params.voxel = voxel;
  params.max_points = max_points;
  config::StageRecipe store{"stores", "flat_hash", [](const BuildContext& c) -> std::unique_ptr<Stage> {
                              return std::make_unique<plugins::FlatHash>(plugins::FlatHash::Params{}, c);
                            }};
  params.store.resolve(std::make_shared<const config::StageRecipe>(store));
  plugins::SoftVoxel overlap(params, context);
  constexpr int frames = 60, warm_up = 20;
  double evaluate_time = 0, extend_time = 0, sum = 0;
  for (int frame = 0; frame < frames; ++frame) {
    const std::vector<WorldPoint> points = sweep(uniform, 1.0 * frame);
    const TimeNs t = frame * kSecond / 10;
    OverlapScore score;
    const double evaluate = seconds([&] { score = overlap.evaluate(points, t); });
    const double extend = seconds([&] { overlap.extend(points, t); });
    if (frame < warm_up) continue;
    evaluate_time += evaluate;
    extend_time += extend;
    sum += score.value.value_or(0);
  }
  constexpr double scored = frames - warm_up;
  std::cout << "soft overlap, 24000 points, voxel " << voxel << " m, max_points " << max_points << '\n';
  report("  evaluate, per frame", 1e3 * evaluate_time / scored, "ms");
  report("  extend, per frame", 1e3 * extend_time / scored, "ms");
  report("  mean overlap", sum / scored, "");
  report("  memory", static_cast<double>(overlap.memory_bytes()) / 1e6, "MB");
}

}  // namespace

int main(int argc, char** argv) {
  const std::size_t target = argc > 1 ? std::strtoul(argv[1], nullptr, 10) : 1000000;
  const double spacing = argc > 2 ? std::strtod(argv[2], nullptr) : 0.1;
  exec::Executor exec(1);
  const SensorModel sensor;
  const BuildContext context{exec, sensor, nullptr};
  bench_map(context, target, spacing);
  for (const double voxel : {0.1, 0.2, 0.4}) {
    bench_overlap(context, voxel, 0);
    bench_overlap(context, voxel, 5000);
  }
}
