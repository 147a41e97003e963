#include <algorithm>
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "aslio/io/source.hpp"
#include "fixture.hpp"

using namespace aslio::test;
using Catch::Matchers::Contains;

TEST_CASE("a stage of a shared object runs, and the manifest names the object and its digest") {
  const Bench bench;
  const std::vector<std::string> set = {"--set", "window={type: my_window, period: 0.05}"};
  const Ended without = bench.run("out", set);
  CHECK(without.code == 2);
  CHECK_THAT(without.err, Contains("my_window"));
  auto more = set;
  more.insert(more.end(), {"--plugin", ASLIO_EXAMPLE_PLUGIN});
  const Ended ended = bench.run("out", more);
  INFO(ended.err);
  REQUIRE(ended.code == 0);
  const auto manifest = nlohmann::json::parse(content(bench / "out/manifest.json"));
  REQUIRE(manifest.at("plugins").size() == 1);
  const auto& plugin = manifest.at("plugins").front();
  CHECK(std::filesystem::equivalent(plugin.at("path").get<std::string>(), ASLIO_EXAMPLE_PLUGIN));
  CHECK(plugin.at("sha256") == aslio::io::input_digest(ASLIO_EXAMPLE_PLUGIN));
  const auto stages = manifest.at("stages").get<std::vector<std::string>>();
  CHECK(std::find(stages.begin(), stages.end(), "windows/my_window") != stages.end());
  CHECK(line_count(bench / "out/trajectory.tum") > 30);
}
