#include "samplers/stride.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <set>

#include "plugins/build_environment.hpp"
#include "plugins/samplers/batch.hpp"

namespace aslio {
namespace {

using plugins::StrideSampler;

std::vector<std::uint32_t> kept(const StrideSampler::Params& params, std::uint64_t seed, std::size_t points = 6000) {
  test::BuildEnvironment environment;
  environment.order_seed = seed;
  StrideSampler sampler(params, environment.context());
  test::Batch batch = test::random_batch(points, 1, 10.0f);
  SampleBatch view = batch.view();
  sampler.sample(view);
  std::vector<std::uint32_t> indices;
  for (std::size_t i = 0; i < points; ++i) {
    if (batch.uses[i] != 0) indices.push_back(batch.raw[i].index);
  }
  return indices;
}

}  // namespace

TEST_CASE("stride keeps every k-th point of the stream, with the phase of the order seed") {
  for (const std::uint64_t seed : {0ULL, 1ULL, 4ULL, 5ULL, 1234567890123ULL}) {
    CAPTURE(seed);
    const auto indices = kept({.keep_every = 5}, seed);
    REQUIRE(indices.size() == 1200);
    for (const std::uint32_t index : indices) REQUIRE(index % 5 == seed % 5);
  }
  CHECK(kept({.keep_every = 1}, 3).size() == 6000);
}

TEST_CASE("a stride of 5 sees all six interleaved lines, a stride of 3 only two") {
  const auto lines = [](const std::vector<std::uint32_t>& indices) {
    std::set<std::uint32_t> seen;
    for (const std::uint32_t index : indices) seen.insert(index % 6);
    return seen.size();
  };
  CHECK(lines(kept({.keep_every = 5}, 0)) == 6);
  CHECK(lines(kept({.keep_every = 3}, 0)) == 2);
}

TEST_CASE("stride warns when it leaves out lines for good") {
  const auto logged = [](StrideSampler::Params params, int lines) {
    test::BuildEnvironment environment;
    environment.sensor.scan_lines = lines;
    const StrideSampler sampler(params, environment.context());
    return environment.logged();
  };
  CHECK_THAT(logged({.keep_every = 3}, 6), Catch::Contains("keep_every 3") &&
                                               Catch::Contains("6 interleaved scan lines") &&
                                               Catch::Contains("only 2 of the lines"));
  CHECK_THAT(logged({.keep_every = 4}, 64), Catch::Contains("only 16 of the lines"));
  CHECK(logged({.keep_every = 5}, 6).empty());
  CHECK(logged({.keep_every = 3}, 1).empty());
  CHECK(logged({.keep_every = 3, .by = StrideSampler::By::firing}, 6).empty());
}

TEST_CASE("stride by firing keeps or drops firings whole, a k-th of them, another set for another seed") {
  const StrideSampler::Params params{.keep_every = 4, .by = StrideSampler::By::firing};
  const auto indices = kept(params, 0, 60'000);
  REQUIRE(indices.size() % 6 == 0);
  for (std::size_t i = 0; i < indices.size(); i += 6) {
    REQUIRE(indices[i] % 6 == 0);
    REQUIRE(indices[i + 5] == indices[i] + 5);
  }
  // 10 000 firings, each kept with probability 1/4: standard deviation 43.
  const double firings = static_cast<double>(indices.size()) / 6.0;
  CHECK(firings == Approx(2500).margin(5 * 43.3));
  CHECK(kept(params, 0, 60'000) == indices);
  CHECK(kept(params, 1, 60'000) != indices);
}

// eq. SMP-1
TEST_CASE("stride with a known overlap thins after an update that knew its view, and only then") {
  test::BuildEnvironment environment;
  StrideSampler sampler({.keep_every = 5, .known = 0.9, .warmup = 1.0}, environment.context());
  const auto kept = [&] {
    test::Batch batch = test::random_batch(1000, 1, 10.0f);
    SampleBatch view = batch.view();
    sampler.sample(view);
    return batch.count(PointUse::map);
  };
  CHECK(kept() == 1000);  // nothing is known before the first update
  Feedback feedback;
  feedback.t = 3 * kSecond;
  feedback.first_insertion = 2 * kSecond;
  feedback.status = UpdateStatus::ok;
  const auto kept_after = [&](std::optional<double> overlap) {
    feedback.overlap.value = overlap;
    sampler.observe(feedback);
    return kept();
  };
  CHECK(kept_after(0.9) == 200);
  CHECK(kept_after(0.8999) == 1000);
  CHECK(kept_after(1.0) == 200);
  CHECK(kept_after(std::nullopt) == 1000);  // nothing was scored
  CHECK(kept_after(std::nan("")) == 1000);
  for (const auto status : {UpdateStatus::initialising, UpdateStatus::few_matches, UpdateStatus::degenerate,
                            UpdateStatus::not_converged, UpdateStatus::non_finite}) {
    feedback.status = status;
    CHECK(kept_after(1.0) == 1000);
  }
  feedback.status = UpdateStatus::ok;
  CHECK(kept_after(1.0) == 200);
  feedback.t -= 1;  // in the first second
  CHECK(kept_after(1.0) == 1000);
  feedback.first_insertion = kTimeMax;  // an empty map
  CHECK(kept_after(1.0) == 1000);
}

TEST_CASE("stride acts for its uses only") {
  test::BuildEnvironment environment;
  StrideSampler sampler({.keep_every = 2, .uses = {"match"}}, environment.context());
  test::Batch batch = test::random_batch(10, 1, 10.0f);
  SampleBatch view = batch.view();
  sampler.sample(view);
  CHECK(batch.count(PointUse::match) == 5);
  CHECK(batch.count(PointUse::overlap) == 10);
  CHECK(batch.count(PointUse::map) == 10);
}

}  // namespace aslio
