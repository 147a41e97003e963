// When block_hash dilates: what it keeps between queries.
#include <catch2/catch.hpp>

#include "plugins/build_environment.hpp"
#include "stores/block_hash.hpp"

using namespace aslio;

TEST_CASE("block_hash dilates a brick at its first query after a change next to it, and not again") {
  test::BuildEnvironment environment;
  plugins::BlockHash store({}, environment.context());
  std::vector<std::uint8_t> layer(1);
  const auto ask = [&](const Cell& cell) {
    store.layers(std::span(&cell, 1), 3, LayerMetric::chebyshev, layer);
    return static_cast<int>(layer[0]);
  };
  store.insert(std::vector<Cell>{{0, 0, 0}});
  REQUIRE(store.dilations() == 0);
  REQUIRE(ask({-1, -2, -3}) == 3);
  REQUIRE(ask({-8, -1, -1}) == 4);
  REQUIRE(store.dilations() == 1);
  store.insert(std::vector<Cell>{{100, 0, 0}, {0, 0, 0}});  // far away, and nothing new
  REQUIRE(ask({-1, -2, -3}) == 3);
  REQUIRE(store.dilations() == 1);
  store.insert(std::vector<Cell>{{0, -2, -1}});  // in a brick beside it
  REQUIRE(ask({-1, -2, -1}) == 1);
  REQUIRE(store.dilations() == 2);
}
