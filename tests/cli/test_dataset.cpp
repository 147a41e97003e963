/// Dataset files: what a run takes from them, what overrides them, and what is told of those that are wrong.

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "fixture.hpp"

using namespace aslio::test;
using Catch::Matchers::Contains;

namespace {

nlohmann::json json(const std::filesystem::path& file) { return nlohmann::json::parse(content(file)); }

/// Runs the bench's pipeline over a dataset.
Ended run_dataset(const Bench& bench, const std::string& dataset, const std::vector<std::string>& more = {}) {
  std::vector<std::string> arguments = {"run",        bench / "pipeline.yaml", "--dataset", bench / dataset, "--output",
                                        bench / "out"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return run_aslio(arguments);
}

/// A dataset file in a folder of its own; the recording lies beside that folder.
void write_dataset(const Bench& bench, const std::string& more = "") {
  std::filesystem::create_directories(bench / "data");
  write_text(bench / "data/dataset.yaml",
             "schema: aslio/dataset/1\ninput: ../recording.bag\nsensor: ../sensor.yaml\n" + more);
}

}  // namespace

TEST_CASE("a dataset stands for input, sensor, reference and section") {
  const Bench bench;
  write_truth(bench / "truth.tum");
  write_dataset(bench, "reference: ../truth.tum\nstart: 0.25\nduration: 1.25\nclosed_loop: true\n");
  const std::string truth = bench / "truth.tum";
  REQUIRE(bench.run("plain", {"--reference", truth, "--start", "0.25", "--duration", "1.25", "--closed-loop"}).code ==
          0);
  for (const char* dataset : {"data", "data/dataset.yaml"}) {
    const Ended ended = run_dataset(bench, dataset);
    INFO(dataset << "\n" << ended.err);
    CHECK(ended.code == 0);
    CHECK(content(bench / "out/trajectory.tum") == content(bench / "plain/trajectory.tum"));
    CHECK(json(bench / "out/summary.json").at("metrics") == json(bench / "plain/summary.json").at("metrics"));
    CHECK_FALSE(json(bench / "out/summary.json").at("metrics").at("ate_m").is_null());
    const auto manifest = json(bench / "out/manifest.json");
    CHECK_THAT(manifest.at("dataset").get<std::string>(), Contains("dataset.yaml"));
    CHECK(manifest.at("input").at("duration_s") == 1.25);
  }
  CHECK(json(bench / "plain/manifest.json").at("dataset").is_null());
}

TEST_CASE("between the ends of what is no closed loop there is no error") {
  const Bench bench;
  write_dataset(bench, "closed_loop: true\n");
  REQUIRE(run_dataset(bench, "data").code == 0);
  CHECK(json(bench / "out/summary.json").at("metrics").at("end_to_end_m").is_number());
  write_dataset(bench, "");
  REQUIRE(run_dataset(bench, "data").code == 0);
  CHECK(json(bench / "out/summary.json").at("metrics").at("end_to_end_m").is_null());
  const Ended said = run_dataset(bench, "data", {"--closed-loop"});
  REQUIRE(said.code == 0);
  CHECK(json(bench / "out/summary.json").at("metrics").at("end_to_end_m").is_number());
}

TEST_CASE("options override a dataset") {
  const Bench bench;
  write_truth(bench / "truth.tum");
  write_text(bench / "other.yaml", sensor_text("max_range: 20\n"));
  write_dataset(bench, "start: 1.5\n");
  REQUIRE(bench.run("plain", {"--start", "0", "--duration", "1.5"}).code == 0);
  const Ended ended =
      run_dataset(bench, "data", {"--start", "0", "--duration", "1.5", "--reference", bench / "truth.tum"});
  INFO(ended.err);
  CHECK(ended.code == 0);
  CHECK(content(bench / "out/trajectory.tum") == content(bench / "plain/trajectory.tum"));
  CHECK_FALSE(json(bench / "out/summary.json").at("metrics").at("ate_m").is_null());
  REQUIRE(run_dataset(bench, "data", {"--start", "0", "--sensor", bench / "other.yaml"}).code == 0);
  CHECK_THAT(json(bench / "out/manifest.json").at("sensor").at("path").get<std::string>(), Contains("other.yaml"));
}

TEST_CASE("input and dataset: one of them, not both") {
  const Bench bench(Recording{.duration = 0.1});
  write_dataset(bench);
  const Ended both = run_dataset(bench, "data", {"--input", bench / "recording.bag"});
  CHECK(both.code == 2);
  CHECK_THAT(both.err, Contains("--input and --dataset exclude each other"));
  const Ended none = run_aslio({"run", bench / "pipeline.yaml", "--output", bench / "out"});
  CHECK(none.code == 2);
  CHECK_THAT(none.err, Contains("give --input and --sensor, or --dataset"));
  const Ended half =
      run_aslio({"run", bench / "pipeline.yaml", "--input", bench / "recording.bag", "--output", bench / "out"});
  CHECK(half.code == 2);
  CHECK_THAT(half.err, Contains("--input needs --sensor"));
  const Ended folder =
      run_aslio({"run", bench / "pipeline.yaml", "--input", bench / "data", "--output", bench / "out"});
  CHECK(folder.code == 2);
  CHECK_THAT(folder.err, Contains("give it as --dataset " + (bench / "data").string()));
  CHECK_FALSE(std::filesystem::exists(bench / "out"));
}

TEST_CASE("what a dataset names and is not there is told with its place") {
  const Bench bench(Recording{.duration = 0.1});
  write_dataset(bench);
  write_text(bench / "data/dataset.yaml",
             "schema: aslio/dataset/1\ninput: gone.bag\nsensor: ../sensor.yaml\nreference: ..\n");
  const Ended ended = run_dataset(bench, "data");
  CHECK(ended.code == 2);
  CHECK_THAT(ended.err, Contains("dataset.yaml:2:8: ") && Contains("data/gone.bag") &&
                            Contains("paths are relative to the folder of this file"));
  CHECK_THAT(ended.err, Contains("dataset.yaml:4:12: ") && Contains("is a folder") && Contains("name a file"));
  CHECK_FALSE(std::filesystem::exists(bench / "out"));
}

TEST_CASE("check and describe know dataset files") {
  const Bench bench(Recording{.duration = 0.1});
  write_dataset(bench, "name: corridor\nclosed_loop: true\n");
  const Ended good = run_aslio({"check", bench / "data/dataset.yaml"});
  INFO(good.err);
  CHECK(good.code == 0);
  CHECK_THAT(good.out, Contains("dataset.yaml: ok (dataset)"));
  write_text(bench / "data/dataset.yaml", "schema: aslio/dataset/1\ninput: ../recording.bag\nsenser: a\nstart: -1\n");
  const Ended bad = run_aslio({"check", bench / "data/dataset.yaml"});
  CHECK(bad.code == 2);
  CHECK_THAT(bad.err, Contains("dataset.yaml:3:1: ") && Contains("did you mean 'sensor'") &&
                          Contains("dataset.yaml:4:8: ") && Contains("start"));
  write_text(bench / "data/dataset.yaml", "schema: aslio/dataset/1\ninput: ../recording.bag\n");
  const Ended partial = run_aslio({"check", bench / "data/dataset.yaml"});
  CHECK(partial.code == 2);
  CHECK_THAT(partial.err, Contains("'sensor'") && Contains("is required"));
  const Ended keys = run_aslio({"describe", "dataset"});
  CHECK(keys.code == 0);
  CHECK_THAT(keys.out, Contains("schema: aslio/dataset/1") && Contains("closed_loop: true|false, default false"));
}

TEST_CASE("a folder without a dataset file is no dataset") {
  const Bench bench(Recording{.duration = 0.1});
  std::filesystem::create_directories(bench / "data");
  const Ended ended = run_dataset(bench, "data");
  CHECK(ended.code == 2);
  CHECK_THAT(ended.err, Contains("the folder has no dataset.yaml"));
}

TEST_CASE("a run does not overwrite its dataset file") {
  const Bench bench(Recording{.duration = 0.1});
  std::filesystem::create_directories(bench / "out");
  const std::string text = "schema: aslio/dataset/1\ninput: ../recording.bag\nsensor: ../sensor.yaml\n";
  write_text(bench / "out/resolved.yaml", text);
  const Ended ended = run_dataset(bench, "out/resolved.yaml");
  CHECK(ended.code == 2);
  CHECK_THAT(ended.err, Contains("resolved.yaml would be overwritten, and --dataset reads it"));
  CHECK(content(bench / "out/resolved.yaml") == text);
}
