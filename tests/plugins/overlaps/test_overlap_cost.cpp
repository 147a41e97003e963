// What the metric of the overlap may cost on sweeps of 24000 points: memory.
// tools/benchmarks/bench_stores prints the same in milliseconds.
#include <catch2/catch.hpp>

#include "plugins/build_environment.hpp"
#include "plugins/overlaps/drive.hpp"
#include "register_all.hpp"

using namespace aslio;

TEST_CASE("block_hash keeps the cells of 60 m of street in 10 MB, half of what the nested hash of the paper does") {
  plugin::Catalog catalog;
  plugins::register_all(catalog);
  test::BuildEnvironment environment;
  const test::Cost block = test::drive(catalog, "block_hash", environment.context());
  const test::Cost nested = test::drive(catalog, "nested_hash", environment.context());
  CHECK(block.bytes > 1'000'000);
  CHECK(block.bytes <= 10'000'000);  // measured 7.1 MB
  CHECK(block.bytes < nested.bytes / 2);
}
