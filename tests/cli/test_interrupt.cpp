#include <signal.h>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "fixture.hpp"

using namespace aslio::test;
using Catch::Matchers::Contains;

TEST_CASE("an interrupted run writes what there is and exits with 130") {
  const int signal = GENERATE(SIGINT, SIGTERM, SIGHUP);
  const Bench bench(Recording{.duration = 4.0});
  // A sampler that keeps every point makes the run long enough to be met in the middle.
  const auto arguments = bench.arguments("out", {"--set", "samplers=[{type: range, min: 0.5, max: 100}]"});
  const Ended ended = run_aslio(arguments, [signal](pid_t child, const std::string& err) {
    if (err.find("real time") == std::string::npos) return false;  // the first line of progress
    ::kill(child, signal);
    return true;
  });
  INFO(ended.err);
  CHECK(ended.code == 130);
  CHECK_THAT(ended.err, Contains("interrupted"));
  const auto summary = nlohmann::json::parse(content(bench / "out/summary.json"));
  CHECK(summary.at("status") == "interrupted");
  CHECK(summary.at("coverage").get<double>() < 0.95);
  CHECK(line_count(bench / "out/trajectory.tum") == summary.at("updates").get<std::size_t>());
  CHECK(line_count(bench / "out/trajectory.tum") > 0);
  CHECK(std::filesystem::exists(bench / "out/manifest.json"));
}

TEST_CASE("an interrupted overlap keeps the frames it has scored and exits with 130") {
  const Bench bench(Recording{.duration = 4.0});
  write_truth(bench / "truth.tum");
  // Every frame is scored twice, in fine voxels: long enough to be met in the middle.
  const std::vector<std::string> arguments = {
      "overlap",  bench / "pipeline.yaml", "--input",          bench / "recording.bag",
      "--sensor", bench / "sensor.yaml",   "--trajectory",     bench / "truth.tum",
      "--output", bench / "sod.csv",       "--period",         "0.01",
      "--set",    "overlap.voxel=0.02",    "--position-error", "0.02"};
  const Ended ended = run_aslio(arguments, [](pid_t child, const std::string& err) {
    if (err.find("real time") == std::string::npos) return false;
    ::kill(child, SIGINT);
    return true;
  });
  INFO(ended.err);
  CHECK(ended.code == 130);
  CHECK_THAT(ended.err, Contains("interrupted") && Contains("frames before"));
  CHECK(line_count(bench / "sod.csv") > 1);
  CHECK(line_count(bench / "sod.csv") < 390);
}
