/// What every sampler owes the chain.

#include <catch2/catch.hpp>

#include "aslio/plugin/registry.hpp"
#include "plugins/build_environment.hpp"
#include "plugins/samplers/batch.hpp"
#include "register_all.hpp"

namespace aslio {
namespace {

std::unique_ptr<Sampler> make(const plugin::Entry& entry, test::BuildEnvironment& environment) {
  const auto params = entry.defaults();
  return std::unique_ptr<Sampler>(dynamic_cast<Sampler*>(entry.make(params.get(), environment.context()).release()));
}

}  // namespace

TEST_CASE("every registered sampler thins, and only ever clears bits") {
  plugin::Catalog catalog;
  plugins::register_all(catalog);
  test::BuildEnvironment environment;
  for (const std::string& type : catalog.types(Sampler::family)) {
    CAPTURE(type);
    const auto sampler = make(*catalog.find(Sampler::family, type), environment);
    REQUIRE(sampler);
    std::size_t cleared = 0;
    for (std::uint64_t seed = 1; seed <= 10; ++seed) {
      test::Batch batch = test::random_batch(20000, seed, seed % 2 == 0 ? 1.0f : 120.0f, true);
      const auto before = batch.taps;
      SampleBatch view = batch.view();
      if (sampler->acts_on() == Sampler::ActsOn::raw) view.body = {};
      sampler->sample(view);
      for (std::size_t i = 0; i < before.size(); ++i) {
        REQUIRE((batch.taps[i] & ~before[i]) == 0);
        cleared += batch.taps[i] != before[i];
      }
    }
    CHECK(cleared > 0);
  }
}

TEST_CASE("every registered sampler is deterministic and takes an empty batch") {
  plugin::Catalog catalog;
  plugins::register_all(catalog);
  test::BuildEnvironment environment;
  for (const std::string& type : catalog.types(Sampler::family)) {
    CAPTURE(type);
    const auto one = make(*catalog.find(Sampler::family, type), environment);
    const auto other = make(*catalog.find(Sampler::family, type), environment);
    test::Batch empty;
    SampleBatch nothing = empty.view();
    other->sample(nothing);
    for (std::uint64_t seed = 1; seed <= 3; ++seed) {
      test::Batch a = test::random_batch(3000, seed, 5.0f);
      test::Batch b = a;
      SampleBatch view_a = a.view(), view_b = b.view();
      one->sample(view_a);
      other->sample(view_b);
      CHECK(a.taps == b.taps);
    }
  }
}

TEST_CASE("raw samplers decide the same wherever windows are cut") {
  plugin::Catalog catalog;
  plugins::register_all(catalog);
  test::BuildEnvironment environment;
  for (const std::string& type : catalog.types(Sampler::family)) {
    CAPTURE(type);
    const auto sampler = make(*catalog.find(Sampler::family, type), environment);
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
                        .taps = std::span(pieces.taps).subspan(begin, size)};
      sampler->sample(piece);
      begin += size;
    }
    CHECK(pieces.taps == whole.taps);
  }
}

TEST_CASE("the chain runs the samplers of each phase in order") {
  plugin::Catalog catalog;
  plugins::register_all(catalog);
  test::BuildEnvironment environment;
  std::vector<std::unique_ptr<Sampler>> members;
  for (const char* type : {"voxel", "range", "stride"}) {
    members.push_back(make(*catalog.find(Sampler::family, type), environment));
  }
  SamplerChain chain(std::move(members));
  test::Batch batch = test::random_batch(3000, 8, 2.0f);
  SampleBatch view = batch.view();
  chain.sample(Sampler::ActsOn::raw, view);
  const std::size_t after_raw = batch.count(Tap::map);
  CHECK(batch.count(Tap::overlap) == after_raw);
  CHECK(after_raw < 3000 / 5 + 1);
  chain.sample(Sampler::ActsOn::body, view);
  CHECK(batch.count(Tap::overlap) == after_raw);  // by default the voxel sampler leaves the overlap its points
  CHECK(batch.count(Tap::map) < after_raw);
  CHECK(batch.count(Tap::map) == batch.count(Tap::match));
}

}  // namespace aslio
