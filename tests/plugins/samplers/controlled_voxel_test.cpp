#include "samplers/controlled_voxel.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "plugins/allocation_count.hpp"
#include "plugins/build_environment.hpp"
#include "plugins/samplers/batch.hpp"

namespace aslio {
namespace {

using plugins::ControlledVoxel;
using plugins::LeafController;
using plugins::VoxelCount;

/// `points` of a square wall of 2 x `half` metres, `away` metres ahead, over `seconds`.
test::Batch wall(std::size_t points, double seconds, double half, double away, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  const auto coordinate = [&] {
    return static_cast<float>(half * (2.0 * static_cast<double>(random() >> 11) * 0x1p-53 - 1.0));
  };
  test::Batch batch;
  for (std::size_t i = 0; i < points; ++i) {
    const float y = coordinate(), z = coordinate();
    batch.add({static_cast<float>(away), y, z});
    batch.raw.back().t = to_ns(seconds * static_cast<double>(i) / static_cast<double>(points - 1));
  }
  return batch;
}

/// Counts of the map use, for a period of 0.1 s, over `windows` windows of `seconds`.
std::vector<double> counts(ControlledVoxel& sampler, int windows, double seconds, double half, double away) {
  std::vector<double> out;
  for (int k = 0; k < windows; ++k) {
    test::Batch batch =
        wall(static_cast<std::size_t>(240000 * seconds), seconds, half, away, 100 + static_cast<std::uint64_t>(k));
    SampleBatch view = batch.view();
    sampler.sample(view);
    out.push_back(static_cast<double>(batch.count(PointUse::map)) * 0.1 / seconds);
  }
  return out;
}

/// One set-point, whatever the scale.
ControlledVoxel::Params holding(double points, double leaf) {
  ControlledVoxel::Params params;
  params.control.leaf = leaf;
  params.control.min_points = params.control.max_points = points;
  return params;
}

}  // namespace

TEST_CASE("controlled_voxel reaches its set-point from either side, and stays there") {  // eq. SMP-2
  test::BuildEnvironment environment;
  const double half = GENERATE(3.0, 12.0);
  const double leaf = GENERATE(0.05, 0.25, 2.0);
  CAPTURE(half, leaf);
  ControlledVoxel sampler(holding(2000, leaf), environment.context());
  const auto first = counts(sampler, 1, 0.1, half, 5.0);
  CHECK(std::abs(first[0] - 2000) > 400);  // there is something to do
  counts(sampler, 150, 0.1, half, 5.0);
  // The wall holds a whole number of cubes: 44^2 or 46^2.
  for (const double count : counts(sampler, 20, 0.1, half, 5.0)) CHECK(count == Approx(2000).epsilon(0.08));
  // Cubes of sqrt(area / points), as the wall lies inside one layer of them.
  CHECK(sampler.leaf() == Approx(2.0 * half / std::sqrt(2000.0)).epsilon(0.15));
}

TEST_CASE("controlled_voxel: the leaf keeps within its bounds, and moves by no more than what reaches the set-point") {
  test::BuildEnvironment environment;
  for (const double points : {10.0, 1e6}) {  // that no leaf within the bounds gives
    CAPTURE(points);
    ControlledVoxel::Params params = holding(points, 0.3);
    params.control.min_leaf = 0.2;
    params.control.max_leaf = 0.4;
    ControlledVoxel sampler(params, environment.context());
    for (int k = 0; k < 300; ++k) {
      counts(sampler, 1, 0.1, 3.0, 5.0);
      REQUIRE((sampler.leaf() >= 0.2 && sampler.leaf() <= 0.4));
    }
    CHECK(sampler.leaf() == (points == 10.0 ? 0.4 : 0.2));
  }
  LeafController::Params violent;
  violent.p_gain_min = violent.p_gain_max = 1.0;
  violent.min_points = violent.max_points = 1000;
  LeafController controller(violent);
  controller.observe({.periods = 1.0, .per_period = 4000, .range = 5.0});
  CHECK(controller.leaf() == Approx(0.5));  // a quarter of the points on a surface
  controller.observe({.periods = 0.1, .per_period = 250, .range = 5.0});
  CHECK(controller.leaf() == Approx(0.475));  // a tenth of the way to 0.25
}

TEST_CASE("controlled_voxel: short windows move the leaf as far as one long one does") {  // eq. SMP-2
  LeafController::Params params;
  params.d_gain_min = params.d_gain_max = 0.0;
  params.p_gain_min = params.p_gain_max = 5e-6;
  params.min_points = params.max_points = 2000;
  LeafController whole(params), parts(params);
  whole.observe({.periods = 1.0, .per_period = 2400, .range = 5.0});
  for (int k = 0; k < 12; ++k) parts.observe({.periods = 1.0 / 12, .per_period = 2400, .range = 5.0});
  CHECK(whole.leaf() == Approx(params.leaf + 400 * 5e-6));
  CHECK(parts.leaf() == Approx(whole.leaf()));

  // Through the filter: windows of 8 ms come to rest at as many points per second.
  test::BuildEnvironment environment;
  ControlledVoxel sampler(holding(2000, 0.5), environment.context());
  counts(sampler, 1500, 0.008, 12.0, 5.0);
  double sum = 0;
  for (const double count : counts(sampler, 25, 0.008, 12.0, 5.0)) sum += count / 25;
  CHECK(sum == Approx(2000).epsilon(0.05));
}

TEST_CASE("controlled_voxel: short windows are remembered for as many periods as long ones") {  // eq. SMP-2
  LeafController::Params params;
  params.scale_periods = 20.0;
  LeafController whole(params), parts(params);
  for (int period = 0; period < 40; ++period) {
    const double range = period < 25 ? 5.0 : 20.0;  // of the last 20 periods, 5 are of the narrow scene
    whole.observe({.periods = 1.0, .per_period = 2000, .range = range});
    for (int k = 0; k < 50; ++k) parts.observe({.periods = 0.02, .per_period = 2000, .range = range});
  }
  CHECK(parts.set_point() == Approx(whole.set_point()).epsilon(0.02));
  for (int k = 0; k < 50 * 10; ++k) parts.observe({.periods = 0.02, .per_period = 2000, .range = 5.0});
  CHECK(parts.set_point() < 0.9 * whole.set_point());
}

TEST_CASE("controlled_voxel: the set-point rises with the median range, over the last periods") {  // eq. SMP-2
  LeafController::Params params;
  LeafController controller(params);
  CHECK(controller.set_point() == 1000);  // nothing seen: the narrowest scene
  const auto see = [&](double range, double periods = 1.0) {
    controller.observe({.periods = periods, .per_period = 2000, .range = range});
  };
  see(15.0);
  CHECK(controller.set_point() == Approx(1000 + 3000 * (1 - 0.25)));
  see(30.0);
  CHECK(controller.set_point() == Approx(1000 + 3000 * (1 - 0.0625)));  // mean 22.5 m
  for (int k = 0; k < 5; ++k) see(60.0);
  CHECK(controller.set_point() == 4000);
  for (int k = 0; k < 50; ++k) see(0.0, 0.1);  // as long as five periods
  CHECK(controller.set_point() == Approx(1000));
}

TEST_CASE("controlled_voxel: the gains grow with the error and its change, between their bounds") {  // eq. SMP-2
  LeafController::Params params;
  params.min_points = params.max_points = 2000;
  const auto step = [&](std::initializer_list<double> per_period) {
    LeafController controller(params);
    double before = params.leaf;
    for (const double points : per_period) {
      before = controller.leaf();
      controller.observe({.periods = 1.0, .per_period = points, .range = 5.0});
    }
    return controller.leaf() - before;
  };
  CHECK(step({2000}) == 0.0);
  CHECK(step({2100}) == Approx(100 * (5e-6 + 0.5 * 4.5e-5)));  // half of the sensitivity of 200 points
  CHECK(step({2400}) == Approx(400 * 5e-5));                   // beyond it
  CHECK(step({2400, 2200}) == Approx(200 * 5e-5 - 200 * (5e-8 + 0.5 * 4.5e-7)));  // half of the 400 points of the rate
  CHECK(step({2200, 2000}) == 0.0);                                               // there
  CHECK(step({1900}) == Approx(-step({2100})));
}

TEST_CASE("controlled_voxel takes the points that voxel takes with the same leaf") {
  test::BuildEnvironment environment;
  const auto keep = GENERATE(plugins::VoxelSampler::Keep::centre, plugins::VoxelSampler::Keep::mean);
  ControlledVoxel::Params params;
  params.keep = keep;
  ControlledVoxel sampler(params, environment.context());
  for (int k = 0; k < 4; ++k) {
    plugins::VoxelSampler plain({.leaf = sampler.leaf(), .keep = keep}, environment.context());
    test::Batch batch = wall(24000, 0.1, 3.0, 5.0, static_cast<std::uint64_t>(k)), other = batch;
    SampleBatch view = batch.view(), other_view = other.view();
    sampler.sample(view);
    plain.sample(other_view);
    CHECK(batch.uses == other.uses);
    CHECK(batch.body == other.body);
  }
  CHECK(sampler.leaf() != 0.25);
  CHECK(sampler.moves_points() == (keep == plugins::VoxelSampler::Keep::mean));
}

TEST_CASE("controlled_voxel: windows that say nothing change nothing") {
  test::BuildEnvironment environment;
  ControlledVoxel sampler({}, environment.context());
  const auto leaf_after = [&](test::Batch batch) {
    SampleBatch view = batch.view();
    sampler.sample(view);
    return sampler.leaf();
  };
  CHECK(leaf_after({}) == 0.25);
  CHECK(leaf_after(wall(2000, 0.0005, 3.0, 5.0, 1)) == 0.25);  // too short
  test::Batch nowhere = wall(2000, 0.1, 3.0, 5.0, 1);
  for (auto& p : nowhere.body) p = Eigen::Vector3f::Constant(std::nanf(""));
  CHECK(leaf_after(nowhere) == 0.25);
  test::Batch unwanted = wall(2000, 0.1, 3.0, 5.0, 1);
  for (auto& uses : unwanted.uses) uses = mask(PointUse::overlap);
  CHECK(leaf_after(unwanted) == 0.25);
  CHECK(leaf_after(wall(24000, 0.1, 3.0, 5.0, 1)) != 0.25);
}

TEST_CASE("controlled_voxel: the same bits in every run, and no allocation after the largest frame") {
  test::BuildEnvironment environment;
  ControlledVoxel one({}, environment.context()), other({}, environment.context());
  for (int k = 0; k < 30; ++k) {
    counts(one, 1, 0.1, 3.0, 2.0 + k);
    counts(other, 1, 0.1, 3.0, 2.0 + k);
    REQUIRE(one.leaf() == other.leaf());
  }
  test::Batch batch = wall(20000, 0.1, 3.0, 5.0, 1);
  SampleBatch view = batch.view();
  const std::size_t before = test::allocation_count();
  one.sample(view);
  CHECK(test::allocation_count() == before);
}

}  // namespace aslio
