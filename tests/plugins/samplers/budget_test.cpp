#include "samplers/budget.hpp"

#include <catch2/catch.hpp>

#include "plugins/build_environment.hpp"
#include "plugins/samplers/batch.hpp"

namespace aslio {
namespace {

std::vector<std::size_t> kept(std::int64_t budget, std::size_t points, PointUse use) {
  test::BuildEnvironment environment;
  plugins::BudgetSampler sampler({.points = budget}, environment.context());
  test::Batch batch = test::random_batch(points, 1, 10.0f);
  SampleBatch view = batch.view();
  sampler.sample(view);
  std::vector<std::size_t> indices;
  for (std::size_t i = 0; i < points; ++i) {
    if ((batch.uses[i] & mask(use)) != 0) indices.push_back(i);
  }
  return indices;
}

}  // namespace

TEST_CASE("budget keeps exactly as many points as it may, evenly, and all of fewer") {
  for (const std::int64_t budget : {1, 7, 999, 1000, 1001, 5000}) {
    CAPTURE(budget);
    const auto indices = kept(budget, 1000, PointUse::match);
    REQUIRE(indices.size() == static_cast<std::size_t>(std::min<std::int64_t>(budget, 1000)));
    const double step = 1000.0 / static_cast<double>(std::min<std::int64_t>(budget, 1000));
    for (std::size_t i = 0; i < indices.size(); ++i) {
      CHECK(std::abs(static_cast<double>(indices[i]) - step * static_cast<double>(i + 1)) <= step + 1.0);
    }
  }
}

TEST_CASE("budget leaves the uses alone that it does not name") {
  CHECK(kept(10, 1000, PointUse::match).size() == 10);
  CHECK(kept(10, 1000, PointUse::map).size() == 1000);
  CHECK(kept(10, 1000, PointUse::overlap).size() == 1000);
}

}  // namespace aslio
