#include "samplers/range.hpp"

#include <catch2/catch.hpp>
#include <limits>

#include "aslio/core/errors.hpp"
#include "plugins/build_environment.hpp"
#include "plugins/samplers/batch.hpp"

namespace aslio {
namespace {

using plugins::RangeSampler;

test::Batch at_ranges(const std::vector<float>& ranges) {
  test::Batch batch;
  for (const float r : ranges) batch.add({0.0f, 0.6f * r, -0.8f * r});
  return batch;
}

}  // namespace

TEST_CASE("range keeps what lies between the limits") {
  test::BuildEnvironment environment;
  RangeSampler sampler({.min = 2.0, .max = 20.0}, environment.context());
  test::Batch batch = at_ranges({0.0f, 1.9f, 2.1f, 10.0f, 19.9f, 20.1f, std::nanf("")});
  SampleBatch view = batch.view();
  sampler.sample(view);
  CHECK(batch.uses == std::vector<PointUses>{0, 0, kAllUses, kAllUses, kAllUses, 0, 0});
}

TEST_CASE("range takes absent limits from the sensor") {
  test::BuildEnvironment environment;
  environment.sensor.min_range = 4.0;
  environment.sensor.max_range = 6.0;
  RangeSampler sampler({}, environment.context());
  test::Batch batch = at_ranges({3.9f, 4.1f, 5.9f, 6.1f});
  SampleBatch view = batch.view();
  sampler.sample(view);
  CHECK(batch.uses == std::vector<PointUses>{0, kAllUses, kAllUses, 0});
}

TEST_CASE("range acts for its uses only") {
  test::BuildEnvironment environment;
  RangeSampler sampler({.min = 2.0, .max = 20.0, .uses = {"overlap", "match"}}, environment.context());
  test::Batch batch = at_ranges({1.0f, 5.0f});
  SampleBatch view = batch.view();
  sampler.sample(view);
  CHECK(batch.uses == std::vector<PointUses>{mask(PointUse::map), kAllUses});
}

TEST_CASE("range refuses a limit that contradicts the sensor's other limit, and says which") {
  test::BuildEnvironment environment;
  environment.sensor.max_range = 30.0;
  REQUIRE_THROWS_AS(RangeSampler({.min = 40.0}, environment.context()), ConfigError);
  REQUIRE_THROWS_WITH(RangeSampler({.min = 40.0}, environment.context()),
                      Catch::Contains("min 40 m") && Catch::Contains("max 30 m (the sensor's max_range)"));
}

}  // namespace aslio
