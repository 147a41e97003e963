// When block_hash dilates: what it keeps between queries, and what it looks at alone.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdlib>

#include "plugins/build_environment.hpp"
#include "stores/block_hash.hpp"

using namespace aslio;

namespace {

struct Store {
  test::BuildEnvironment environment;
  plugins::BlockHash store{{}, environment.context()};

  int ask(const Cell& cell, int depth = 3) {
    std::vector<std::uint8_t> layer(1);
    store.layers(std::span(&cell, 1), depth, LayerMetric::chebyshev, layer);
    return layer[0];
  }
};

}  // namespace

TEST_CASE("block_hash dilates a brick that is asked for many unoccupied cells between changes, and not again") {
  Store s;
  s.store.insert(std::vector<Cell>{{0, 0, 0}});
  for (int i = 0; i < 8; ++i) REQUIRE(s.ask({-1, -2, -3}) == 3);  // a look each
  REQUIRE(s.store.dilations() == 0);
  for (int i = 0; i < 8; ++i) REQUIRE(s.ask({-8, -1, -1}) == 4);
  REQUIRE(s.store.dilations() == 1);
  s.store.insert(std::vector<Cell>{{100, 0, 0}, {0, 0, 0}});  // far away, and nothing new
  REQUIRE(s.ask({-1, -2, -3}) == 3);
  REQUIRE(s.store.dilations() == 1);
  s.store.insert(std::vector<Cell>{{0, -2, -1}});  // in a brick beside it
  for (int i = 0; i < 8; ++i) REQUIRE(s.ask({-1, -2, -1}) == 1);
  REQUIRE(s.store.dilations() == 1);
  REQUIRE(s.ask({-1, -2, -1}) == 1);
  REQUIRE(s.store.dilations() == 2);
}

TEST_CASE("block_hash dilates at once where layers reach farther than a look does") {
  Store s;
  s.store.insert(std::vector<Cell>{{0, 0, 0}});
  REQUIRE(s.ask({-1, -2, -4}, 4) == 4);
  REQUIRE(s.store.dilations() == 1);
}

TEST_CASE("the cells around one are found wherever it lies in its brick, and measured as the metric says") {
  std::uint64_t state = 1;
  const auto random = [&] { return (state = state * 6364136223846793005ULL + 1442695040888963407ULL) >> 33U; };
  for (const LayerMetric metric : {LayerMetric::chebyshev, LayerMetric::manhattan, LayerMetric::euclid_rounded}) {
    for (int round = 0; round < 600; ++round) {
      Store s;
      const auto coordinate = [&](int half) { return static_cast<std::int32_t>(random() % (2U * half + 1U)) - half; };
      const Cell cell{coordinate(9), coordinate(9), coordinate(9)};
      const int depth = 1 + round % 3;
      std::vector<Cell> cells;
      int nearest = depth + 1;
      for (int i = 0; i < 1 + round % 5; ++i) {
        const int dx = coordinate(4), dy = coordinate(4), dz = coordinate(4);
        cells.push_back({cell.x + dx, cell.y + dy, cell.z + dz});
        const int x = std::abs(dx), y = std::abs(dy), z = std::abs(dz);
        const int layer = metric == LayerMetric::chebyshev ? std::max({x, y, z})
                          : metric == LayerMetric::manhattan
                              ? x + y + z
                              : static_cast<int>(std::lround(std::sqrt(x * x + y * y + z * z)));
        nearest = std::min(nearest, layer);
      }
      s.store.insert(cells);
      std::vector<std::uint8_t> layer(1);
      s.store.layers(std::span(&cell, 1), depth, metric, layer);
      CAPTURE(round, depth);
      REQUIRE(static_cast<int>(layer[0]) == nearest);
      REQUIRE(s.store.dilations() == 0);
    }
  }
}
