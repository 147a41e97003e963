// What every registered occupancy store promises: the layers of brute force.
#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdlib>
#include <random>
#include <set>
#include <tuple>

#include "aslio/stages/overlap.hpp"
#include "plugins/build_environment.hpp"
#include "plugins/overlaps/one_stage.hpp"
#include "plugins/under_test.hpp"

using namespace aslio;

namespace {

std::vector<Cell> random_cells(std::mt19937_64& engine, std::size_t n, std::int32_t half, const Cell& centre) {
  const auto pick = [&](std::int32_t c) {
    return c + static_cast<std::int32_t>(engine() % static_cast<std::uint64_t>(2 * half + 1)) - half;
  };
  std::vector<Cell> cells(n);
  for (auto& cell : cells) {
    cell.x = pick(centre.x);
    cell.y = pick(centre.y);
    cell.z = pick(centre.z);
  }
  return cells;
}

/// Written from the definition of the metrics, without the library.
int distance(const Cell& a, const Cell& b, LayerMetric metric) {
  const int x = std::abs(a.x - b.x), y = std::abs(a.y - b.y), z = std::abs(a.z - b.z);
  if (metric == LayerMetric::chebyshev) return std::max(x, std::max(y, z));
  if (metric == LayerMetric::manhattan) return x + y + z;
  return static_cast<int>(std::floor(std::sqrt(static_cast<double>(x * x + y * y + z * z)) + 0.5));
}

std::vector<std::uint8_t> brute_force(const std::vector<Cell>& occupied, const std::vector<Cell>& cells, int depth,
                                      LayerMetric metric) {
  std::vector<std::uint8_t> layers;
  for (const Cell& cell : cells) {
    int best = depth + 1;
    for (const Cell& other : occupied) best = std::min(best, distance(cell, other, metric));
    layers.push_back(static_cast<std::uint8_t>(best));
  }
  return layers;
}

std::size_t distinct(const std::vector<Cell>& cells) {
  std::set<std::tuple<int, int, int>> unique;
  for (const Cell& c : cells) unique.emplace(c.x, c.y, c.z);
  return unique.size();
}

template <class F>
void for_every_store(F&& check) {
  const plugin::Catalog catalog = test::stages_under_test();
  test::BuildEnvironment environment;
  const auto types = test::under_test(catalog, OccupancyStore::family);
  REQUIRE(!types.empty());
  for (const auto& type : types) {
    INFO(type);
    const auto context = environment.context();
    const auto store = test::make_stage<OccupancyStore>(catalog, type, context);
    check(*store);
  }
}

constexpr LayerMetric kMetrics[] = {LayerMetric::chebyshev, LayerMetric::manhattan, LayerMetric::euclid_rounded};

}  // namespace

TEST_CASE("every store: layers equal brute force for every metric and depth, also at the edge of the range") {
  for_every_store([](OccupancyStore& store) {
    std::mt19937_64 engine(1);
    constexpr std::int32_t edge = 1 << 20;
    for (const Cell centre : {Cell{0, 0, 0}, Cell{-70000, 12345, -3}, Cell{edge - 12, -edge + 11, edge - 12}}) {
      store.clear();
      const auto occupied = random_cells(engine, 60, 11, centre);
      store.insert(occupied);
      store.insert(occupied);
      REQUIRE(store.size() == distinct(occupied));
      const auto cells = random_cells(engine, 400, 11, centre);
      std::vector<std::uint8_t> layers(cells.size());
      for (const LayerMetric metric : kMetrics) {
        for (const int depth : {0, 1, 3, 7}) {
          store.layers(cells, depth, metric, layers);
          REQUIRE(layers == brute_force(occupied, cells, depth, metric));
        }
      }
    }
  });
}

TEST_CASE("every store: a cell at one end of an axis is no neighbour of the other end") {
  for_every_store([](OccupancyStore& store) {
    constexpr std::int32_t edge = 1 << 20;
    store.insert(std::vector<Cell>{{5, 6, -edge}, {5, -edge, 7}, {0, 0, edge - 1}});
    const std::vector<Cell> cells{{5, 5, edge - 1}, {4, edge - 1, 7}, {0, 1, -edge}};
    std::vector<std::uint8_t> layers(3);
    for (const LayerMetric metric : kMetrics) {
      store.layers(cells, 3, metric, layers);
      REQUIRE(layers == std::vector<std::uint8_t>{4, 4, 4});
    }
  });
}

TEST_CASE("every store: keep_inside keeps the cube and nothing else, while growing and shrinking") {
  for_every_store([](OccupancyStore& store) {
    std::mt19937_64 engine(2);
    std::vector<Cell> oracle;
    for (int round = 0; round < 30; ++round) {
      const Cell centre{10 * round, -3 * round, round};
      const auto fresh = random_cells(engine, 4000, 20, centre);
      store.insert(fresh);
      oracle.insert(oracle.end(), fresh.begin(), fresh.end());
      const Cell lo{centre.x - 15, centre.y - 15, centre.z - 15}, hi{centre.x + 12, centre.y + 13, centre.z + 14};
      store.keep_inside(lo, hi);
      std::erase_if(oracle, [&](const Cell& c) {
        return c.x < lo.x || c.x > hi.x || c.y < lo.y || c.y > hi.y || c.z < lo.z || c.z > hi.z;
      });
      REQUIRE(store.size() == distinct(oracle));
      const auto cells = random_cells(engine, 50, 25, centre);
      std::vector<std::uint8_t> layers(cells.size());
      store.layers(cells, 2, LayerMetric::chebyshev, layers);
      REQUIRE(layers == brute_force(oracle, cells, 2, LayerMetric::chebyshev));
    }
    REQUIRE(store.memory_bytes() < 4000000);
    store.clear();
    REQUIRE(store.size() == 0);
  });
}

TEST_CASE(
    "every store agrees with the others and brute force through random inserts, queries and prunes, on both sides of "
    "zero") {
  const plugin::Catalog catalog = test::stages_under_test();
  test::BuildEnvironment environment;
  const auto context = environment.context();
  for (const std::uint64_t seed : {11, 12, 13}) {
    std::vector<std::unique_ptr<OccupancyStore>> stores;
    for (const auto& type : test::under_test(catalog, OccupancyStore::family)) {
      stores.push_back(test::make_stage<OccupancyStore>(catalog, type, context));
    }
    REQUIRE(stores.size() >= (test::one_under_test(OccupancyStore::family) ? 1 : 3));
    std::mt19937_64 engine(seed);
    const auto pick = [&](int lo, int hi) {
      return lo + static_cast<int>(engine() % static_cast<std::uint64_t>(hi - lo + 1));
    };
    std::vector<Cell> oracle;
    std::array<std::size_t, kMaxLayers + 1> seen{};
    for (int round = 0; round < 400; ++round) {
      const Cell centre{pick(-20, 20), pick(-20, 20), pick(-20, 20)};
      const int action = pick(0, 19);
      if (action < 11) {  // often a single cell: the least that makes a dilated brick stale
        const auto fresh = random_cells(engine, action < 6 ? 1 : 60, 9, centre);
        oracle.insert(oracle.end(), fresh.begin(), fresh.end());
        for (auto& store : stores) store->insert(fresh);
      } else if (action == 11) {
        const Cell lo{centre.x - pick(8, 30), centre.y - pick(8, 30), centre.z - pick(8, 30)};
        const Cell hi{centre.x + pick(8, 30), centre.y + pick(8, 30), centre.z + pick(8, 30)};
        std::erase_if(oracle, [&](const Cell& c) {
          return c.x < lo.x || c.x > hi.x || c.y < lo.y || c.y > hi.y || c.z < lo.z || c.z > hi.z;
        });
        for (auto& store : stores) store->keep_inside(lo, hi);
      } else if (action == 12 && pick(0, 3) == 0) {
        oracle.clear();
        for (auto& store : stores) store->clear();
      }
      // The same metric and depth for a while: planes kept from earlier rounds are asked again.
      const LayerMetric metric = kMetrics[round / 40 % 3];
      const int depth = std::array{3, 7, 1, 5, 0, 2, 6, 4, 3, 3}[static_cast<std::size_t>(round / 40)];
      auto cells = random_cells(engine, 60, 36, {0, 0, 0});
      if (!oracle.empty()) cells[7] = oracle[engine() % oracle.size()];
      const auto expected = brute_force(oracle, cells, depth, metric);
      for (const std::uint8_t layer : expected) ++seen[std::min<std::size_t>(layer, kMaxLayers)];
      for (auto& store : stores) {
        std::vector<std::uint8_t> layers(cells.size());
        store->layers(cells, depth, metric, layers);
        REQUIRE(layers == expected);
        REQUIRE(store->size() == distinct(oracle));
      }
    }
    CAPTURE(seen);
    REQUIRE(std::all_of(seen.begin(), seen.end(), [](std::size_t count) { return count > 50; }));
  }
}
