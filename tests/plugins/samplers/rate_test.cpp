/// The sampler `rate`, eq. SMP-3.
#include "samplers/rate.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "plugins/build_environment.hpp"
#include "plugins/samplers/batch.hpp"

namespace aslio {
namespace {

using plugins::RateSampler;

/// Points at an even rate from t = 0; `first` is the index of the first one.
test::Batch stream(double points_per_s, double seconds, std::uint32_t first = 0) {
  test::Batch batch;
  const auto points = static_cast<std::size_t>(points_per_s * seconds);
  for (std::size_t i = 0; i < points; ++i) {
    batch.add({1.0f, 2.0f, 3.0f});
    batch.raw.back().index = first + static_cast<std::uint32_t>(i);
    batch.raw.back().t = to_ns(static_cast<double>(i) / points_per_s);
  }
  return batch;
}

RateSampler sampler(double points_per_s, std::uint64_t seed = 0) {
  test::BuildEnvironment environment;
  environment.order_seed = seed;
  return {{.points_per_s = points_per_s}, environment.context()};
}

std::size_t in_second(const test::Batch& batch, TimeNs second, PointUse use = PointUse::map) {
  std::size_t n = 0;
  for (std::size_t i = 0; i < batch.raw.size(); ++i) {
    n += batch.raw[i].t / kSecond == second && (batch.uses[i] & mask(use)) != 0;
  }
  return n;
}

test::Batch sampled(RateSampler sampler, test::Batch batch) {
  SampleBatch view = batch.view();
  view.body = {};
  sampler.sample(view);
  return batch;
}

}  // namespace

TEST_CASE("rate keeps the points of the first second, then as many of a second as it may") {
  const test::Batch batch = sampled(sampler(30'000), stream(120'000, 4.0));
  CHECK(in_second(batch, 0) == 120'000);
  for (const TimeNs second : {1, 2, 3}) {
    CAPTURE(second);
    CHECK(static_cast<double>(in_second(batch, second)) == Approx(30'000).margin(5 * std::sqrt(30'000 * 0.75)));
  }
}

TEST_CASE("rate takes all points of a sensor that has fewer, and leaves the uses alone that it does not name") {
  const test::Batch few = sampled(sampler(30'000), stream(29'000, 3.0));
  CHECK(few.count(PointUse::map) == few.raw.size());
  const test::Batch many = sampled(sampler(1'000), stream(29'000, 3.0));
  CHECK(many.count(PointUse::match) == many.raw.size());
  CHECK(many.count(PointUse::overlap) == many.raw.size());
}

TEST_CASE("rate follows the number of points of the second before") {
  test::Batch batch = stream(60'000, 1.0);
  const test::Batch denser = stream(240'000, 3.0, 60'000);
  for (std::size_t i = 0; i < denser.raw.size(); ++i) {
    batch.add({1.0f, 2.0f, 3.0f});
    batch.raw.back() = denser.raw[i];
    batch.raw.back().t += kSecond;
  }
  const test::Batch after = sampled(sampler(30'000), std::move(batch));
  CHECK(static_cast<double>(in_second(after, 1)) == Approx(120'000).epsilon(0.02));
  CHECK(static_cast<double>(in_second(after, 2)) == Approx(30'000).epsilon(0.03));
  CHECK(static_cast<double>(in_second(after, 3)) == Approx(30'000).epsilon(0.03));
}

TEST_CASE("rate decides the same for a point in every window that holds it") {
  const test::Batch whole = sampled(sampler(20'000), stream(100'000, 4.0));
  test::Batch windows = stream(100'000, 4.0);
  RateSampler streamed = sampler(20'000);
  constexpr std::size_t kStep = 3'000, kLength = 20'000;
  for (std::size_t end = kStep; end <= windows.raw.size(); end += kStep) {
    const std::size_t begin = end > kLength ? end - kLength : 0;
    std::vector<PointUses> uses(end - begin, kAllUses);
    SampleBatch window{.raw = std::span(windows.raw).subspan(begin, end - begin), .body = {}, .uses = uses};
    streamed.sample(window);
    for (std::size_t i = begin; i < end; ++i) REQUIRE(uses[i - begin] == whole.uses[i]);
  }
}

TEST_CASE("rate counts on where the number of points passes 2^32") {
  const test::Batch batch = sampled(sampler(30'000), stream(120'000, 3.0, 4'294'967'295U - 60'000U));
  CHECK(static_cast<double>(in_second(batch, 1)) == Approx(30'000).epsilon(0.03));
  CHECK(static_cast<double>(in_second(batch, 2)) == Approx(30'000).epsilon(0.03));
}

TEST_CASE("rate counts over the gap that a loss leaves") {
  test::Batch batch = stream(120'000, 4.0);
  RateSampler gapped = sampler(30'000);
  const auto part = [&](std::size_t begin, std::size_t end) {
    SampleBatch view{.raw = std::span(batch.raw).subspan(begin, end - begin),
                     .body = {},
                     .uses = std::span(batch.uses).subspan(begin, end - begin)};
    gapped.sample(view);
  };
  part(0, 60'000);
  part(360'000, 480'000);
  CHECK(static_cast<double>(in_second(batch, 3)) == Approx(30'000).epsilon(0.03));
}

TEST_CASE("rate keeps other points for another order seed") {
  const test::Batch batch = stream(100'000, 2.0);
  CHECK(sampled(sampler(30'000, 1), batch).uses == sampled(sampler(30'000, 1), batch).uses);
  CHECK(sampled(sampler(30'000, 1), batch).uses != sampled(sampler(30'000, 2), batch).uses);
}

}  // namespace aslio
