/// What every sampler owes the chain.

#include <catch2/catch.hpp>

#include "plugins/build_environment.hpp"
#include "plugins/overlaps/one_stage.hpp"
#include "plugins/samplers/batch.hpp"
#include "plugins/under_test.hpp"

namespace aslio {
namespace {

struct EverySampler {
  std::unique_ptr<Sampler> make(const std::string& text) {
    return test::make_stage<Sampler>(catalog, text, environment.context());
  }
  std::vector<std::string> all() const { return test::under_test(catalog, Sampler::family); }
  const plugin::Catalog catalog = test::stages_under_test();
  test::BuildEnvironment environment;
};

/// Of an update, long after the start, that knew all of its view.
Feedback of_a_known_view() {
  Feedback feedback;
  feedback.t = 1000 * kSecond;
  feedback.first_insertion = 0;
  feedback.status = UpdateStatus::ok;
  feedback.overlap.value = 1.0;
  return feedback;
}

}  // namespace

TEST_CASE("every registered sampler thins, and only ever clears bits") {
  EverySampler every;
  for (const std::string& type : every.all()) {
    CAPTURE(type);
    const auto sampler = every.make(type);
    REQUIRE(sampler);
    sampler->observe(of_a_known_view());
    std::size_t cleared = 0;
    for (std::uint64_t seed = 1; seed <= 10; ++seed) {
      test::Batch batch = test::random_batch(20000, seed, seed % 2 == 0 ? 1.0f : 120.0f, true);
      for (TimedPoint& point : batch.raw) {  // of a stream of two million points a second
        point.index += static_cast<std::uint32_t>(seed) * 2'000'000U;
        point.t += static_cast<TimeNs>(seed) * kSecond;
      }
      const auto before = batch.uses;
      SampleBatch view = batch.view();
      if (sampler->acts_on() == Sampler::ActsOn::raw) view.body = {};
      sampler->sample(view);
      for (std::size_t i = 0; i < before.size(); ++i) {
        REQUIRE((batch.uses[i] & ~before[i]) == 0);
        cleared += batch.uses[i] != before[i];
      }
    }
    CHECK(cleared > 0);
  }
}

TEST_CASE("every registered sampler classes points only if it says so") {
  EverySampler every;
  for (const std::string& type : every.all()) {
    CAPTURE(type);
    const auto sampler = every.make(type);
    if (sampler->acts_on() == Sampler::ActsOn::raw) {
      CHECK_FALSE(sampler->gives_features());  // there is no room for classes before de-skew
      continue;
    }
    constexpr std::uint8_t untouched = 250;
    std::size_t classed = 0;
    for (std::uint64_t seed = 1; seed <= 3; ++seed) {
      test::Batch batch = test::random_batch(20000, seed, 5.0f);
      std::vector<std::uint8_t> features(batch.raw.size(), untouched);
      SampleBatch view = batch.view();
      view.features = features;
      sampler->sample(view);
      for (const std::uint8_t feature : features) classed += feature != untouched;
    }
    CHECK((classed > 0) == sampler->gives_features());
  }
}

TEST_CASE("every registered sampler is deterministic and takes batches of no, one and few points") {
  EverySampler every;
  for (const std::string& type : every.all()) {
    CAPTURE(type);
    const auto one = every.make(type);
    const auto other = every.make(type);
    for (std::size_t points = 0; points <= 9; ++points) {
      test::Batch few = test::random_batch(points, 7, 5.0f);
      SampleBatch view = few.view();
      other->sample(view);
    }
    for (std::uint64_t seed = 1; seed <= 3; ++seed) {
      Feedback feedback = of_a_known_view();
      feedback.overlap.value = 1.0 / static_cast<double>(seed);
      one->observe(feedback);
      other->observe(feedback);
      test::Batch a = test::random_batch(3000, seed, 5.0f);
      test::Batch b = a;
      SampleBatch view_a = a.view(), view_b = b.view();
      one->sample(view_a);
      other->sample(view_b);
      CHECK(a.uses == b.uses);
    }
  }
}

TEST_CASE("every registered raw sampler decides the same wherever windows are cut") {
  EverySampler every;
  for (const std::string& type : every.all()) {
    CAPTURE(type);
    const auto sampler = every.make(type);
    if (sampler->acts_on() != Sampler::ActsOn::raw) continue;
    test::Batch whole = test::random_batch(6000, 5, 90.0f);
    test::Batch pieces = whole;
    SampleBatch view = whole.view();
    sampler->sample(view);
    std::mt19937_64 random(3);
    for (std::size_t begin = 0; begin < pieces.raw.size();) {
      const std::size_t size = std::min<std::size_t>(1 + random() % 500, pieces.raw.size() - begin);
      SampleBatch piece{.raw = std::span(pieces.raw).subspan(begin, size),
                        .body = {},
                        .uses = std::span(pieces.uses).subspan(begin, size)};
      sampler->sample(piece);
      begin += size;
    }
    CHECK(pieces.uses == whole.uses);
  }
}

TEST_CASE("the chain runs the samplers of each phase in order") {
  EverySampler every;
  std::vector<std::unique_ptr<Sampler>> members;
  for (const char* type : {"voxel", "range", "stride"}) {
    members.push_back(every.make(type));
  }
  SamplerChain chain(std::move(members));
  test::Batch batch = test::random_batch(3000, 8, 2.0f);
  SampleBatch view = batch.view();
  chain.sample(Sampler::ActsOn::raw, view);
  const std::size_t after_raw = batch.count(PointUse::map);
  CHECK(batch.count(PointUse::overlap) == after_raw);
  CHECK(after_raw < 3000 / 5 + 1);
  chain.sample(Sampler::ActsOn::body, view);
  CHECK(batch.count(PointUse::overlap) == after_raw);  // by default the voxel sampler leaves the overlap its points
  CHECK(batch.count(PointUse::map) < after_raw);
  CHECK(batch.count(PointUse::map) == batch.count(PointUse::match));
}

}  // namespace aslio
