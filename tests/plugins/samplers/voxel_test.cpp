#include "samplers/voxel.hpp"

#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <map>

#include "plugins/allocation_count.hpp"
#include "plugins/build_environment.hpp"
#include "plugins/samplers/batch.hpp"

namespace aslio {
namespace {

using plugins::VoxelSampler;

/// The definition, one use at a time over an ordered map of cubes.
std::vector<PointUses> brute_force(const test::Batch& batch, const VoxelSampler::Params& params) {
  std::vector<PointUses> uses = batch.uses;
  const auto leaves_per_metre = static_cast<float>(1.0 / params.leaf);
  for (const std::string& name : params.uses) {
    const PointUse use = name == "overlap" ? PointUse::overlap : name == "map" ? PointUse::map : PointUse::match;
    std::map<std::array<int, 3>, std::pair<float, std::size_t>> holders;
    for (std::size_t i = 0; i < uses.size(); ++i) {
      if ((uses[i] & mask(use)) == 0) continue;
      const Eigen::Vector3f p = batch.body[i] * leaves_per_metre;
      const Eigen::Vector3f floor = p.array().floor();
      const Eigen::Vector3f d = p - (floor + Eigen::Vector3f::Constant(0.5f));
      const float squared =
          params.keep == VoxelSampler::Keep::first ? 0.0f : d.x() * d.x() + d.y() * d.y() + d.z() * d.z();
      const std::array<int, 3> cell = {static_cast<int>(floor.x()), static_cast<int>(floor.y()),
                                       static_cast<int>(floor.z())};
      const auto [at, fresh] = holders.try_emplace(cell, squared, i);
      if (!fresh && squared < at->second.first) at->second = {squared, i};
    }
    for (PointUses& bits : uses) bits = static_cast<PointUses>(bits & ~mask(use) & kAllUses);
    for (const auto& [cell, holder] : holders)
      uses[holder.second] = static_cast<PointUses>(uses[holder.second] | mask(use));
  }
  return uses;
}

}  // namespace

TEST_CASE("voxel agrees with its definition, also when uses were thinned apart, and from frame to frame") {
  test::BuildEnvironment environment;
  const auto keep = GENERATE(VoxelSampler::Keep::centre, VoxelSampler::Keep::first);
  const double leaf = GENERATE(0.05, 0.3, 2.0);
  const auto uses =
      GENERATE(aslio::UseNames{"map", "match"}, aslio::UseNames{"overlap", "map", "match"}, aslio::UseNames{"match"});
  const VoxelSampler::Params params{.leaf = leaf, .keep = keep, .uses = uses};
  VoxelSampler sampler(params, environment.context());
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    CAPTURE(leaf, seed, uses.size());
    test::Batch batch = test::random_batch(200 * seed, seed, 1.0f, seed % 2 == 0);
    const auto expected = brute_force(batch, params);
    SampleBatch view = batch.view();
    sampler.sample(view);
    CHECK(batch.uses == expected);
  }
}

TEST_CASE("voxel keeps the point nearest to the centre of its cube, and of equal ones the first") {
  test::BuildEnvironment environment;
  VoxelSampler sampler({.leaf = 1.0, .uses = {"map"}}, environment.context());
  test::Batch batch;
  batch.add({0.1f, 0.5f, 0.5f});
  batch.add({0.75f, 0.5f, 0.5f});
  batch.add({0.25f, 0.5f, 0.5f});
  batch.add({0.9f, 0.5f, 0.5f});
  SampleBatch view = batch.view();
  sampler.sample(view);
  const auto without_map = static_cast<PointUses>(kAllUses & ~mask(PointUse::map));
  CHECK(batch.uses == std::vector<PointUses>{without_map, kAllUses, without_map, without_map});
}

TEST_CASE("voxel keeps a point for every use that has one in the cube, also where it moves them to means") {
  test::BuildEnvironment environment;
  VoxelSampler sampler({.leaf = 1.0, .keep = VoxelSampler::Keep::mean, .uses = {"overlap", "map", "match"}},
                       environment.context());
  test::Batch batch;
  batch.add({0.5f, 0.5f, 0.5f});
  batch.add({0.7f, 0.5f, 0.5f});
  batch.add({0.9f, 0.5f, 0.5f});
  const PointUses map = mask(PointUse::map), match = mask(PointUse::match);
  batch.uses = {map, static_cast<PointUses>(map | match), match};
  SampleBatch view = batch.view();
  sampler.sample(view);
  CHECK(batch.uses == std::vector<PointUses>{map, match, 0});
  CHECK(batch.body[0].x() == Approx(0.6f));
  CHECK(batch.body[1].x() == Approx(0.8f));  // of the two as they were
}

TEST_CASE("voxel moves the point that it keeps to the mean of its cube") {
  test::BuildEnvironment environment;
  VoxelSampler sampler({.leaf = 1.0, .keep = VoxelSampler::Keep::mean, .uses = {"map", "match"}},
                       environment.context());
  test::Batch batch = test::random_batch(3000, 4, 5.0f, false);
  const std::vector<Eigen::Vector3f> before = batch.body;
  std::map<std::array<int, 3>, std::pair<Vec3, int>> cubes;
  const auto cube_of = [](const Eigen::Vector3f& p) {
    return std::array<int, 3>{static_cast<int>(std::floor(p.x())), static_cast<int>(std::floor(p.y())),
                              static_cast<int>(std::floor(p.z()))};
  };
  for (const Eigen::Vector3f& p : before) {
    auto& [sum, points] = cubes.try_emplace(cube_of(p), Vec3::Zero(), 0).first->second;
    sum += p.cast<double>();
    ++points;
  }
  SampleBatch view = batch.view();
  sampler.sample(view);
  std::size_t kept = 0;
  for (std::size_t i = 0; i < before.size(); ++i) {
    if ((batch.uses[i] & mask(PointUse::match)) == 0) {
      CHECK(batch.body[i] == before[i]);
      continue;
    }
    ++kept;
    const auto& [sum, points] = cubes.at(cube_of(before[i]));
    CHECK((batch.body[i].cast<double>() - sum / points).norm() < 1e-5);
  }
  CHECK(kept == cubes.size());
}

TEST_CASE("voxel does not merge the cubes around the origin") {
  test::BuildEnvironment environment;
  VoxelSampler sampler({.leaf = 1.0, .uses = {"map"}}, environment.context());
  test::Batch batch;
  for (const float x : {-0.5f, 0.5f}) {
    for (const float y : {-0.5f, 0.5f}) {
      for (const float z : {-0.5f, 0.5f}) batch.add({x, y, z});
    }
  }
  SampleBatch view = batch.view();
  sampler.sample(view);
  CHECK(batch.count(PointUse::map) == 8);
}

TEST_CASE("voxel: points that are not finite or absurdly far lose the uses") {
  test::BuildEnvironment environment;
  VoxelSampler sampler({.leaf = 0.5}, environment.context());
  test::Batch batch;
  batch.add({1.0f, std::nanf(""), 0.0f});
  batch.add({std::numeric_limits<float>::infinity(), 0.0f, 0.0f});
  batch.add({0.0f, -1e6f, 0.0f});
  batch.add({std::nanf(""), 1.0f, 1.0f});
  batch.add({1.0f, 1.0f, 1.0f});
  SampleBatch view = batch.view();
  sampler.sample(view);
  CHECK(batch.count(PointUse::map) == 1);
  CHECK(batch.uses[4] == kAllUses);
}

TEST_CASE("a point whose use was cleared before does not win a cube for that use") {
  test::BuildEnvironment environment;
  VoxelSampler sampler({.leaf = 1.0}, environment.context());
  test::Batch batch;
  batch.add({0.5f, 0.5f, 0.5f}, mask(PointUse::map));
  batch.add({0.9f, 0.9f, 0.9f}, kAllUses);
  SampleBatch view = batch.view();
  sampler.sample(view);
  CHECK(batch.count(PointUse::map) == 1);
  CHECK(batch.count(PointUse::match) == 1);
}

TEST_CASE("voxel does not allocate after the largest frame") {
  test::BuildEnvironment environment;
  VoxelSampler sampler({}, environment.context());
  test::Batch large = test::random_batch(5000, 1, 10.0f), small = test::random_batch(500, 2, 10.0f);
  SampleBatch view = large.view();
  sampler.sample(view);
  view = small.view();
  const std::size_t before = test::allocation_count();
  sampler.sample(view);
  CHECK(test::allocation_count() == before);
}

}  // namespace aslio
