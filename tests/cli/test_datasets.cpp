/// `aslio datasets`, and --dataset FAMILY/SEQUENCE with --data.

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "fixture.hpp"

using namespace aslio::test;
using Catch::Matchers::Contains;

namespace fs = std::filesystem;

namespace {

nlohmann::json json(const fs::path& file) { return nlohmann::json::parse(content(file)); }

/// The bench with a family file, whose data lie in `data` as published.
struct FamilyBench : Bench {
  explicit FamilyBench(const std::string& sequence = "{name: walk}") {
    fs::create_directories(folder / "data/walk");
    fs::rename(folder / "recording.bag", folder / "data/walk/walk_0.bag");
    write_truth(folder / "data/walk/truth.tum");
    write_text(
        folder / "walks.yaml",
        "schema: aslio/family/1\ntitle: Walks\nurl: https://example.org\nverified: made up\nsensor: sensor.yaml\n"
        "extrinsics: [{source: the maker}]\ninput: ['{sequence}/*.bag']\n"
        "reference: {file: '{sequence}/truth.tum'}\nsequences: [" +
            sequence + "]\n");
  }
  Ended run(const std::string& dataset, const std::vector<std::string>& more = {}) const {
    std::vector<std::string> arguments = {"run",    folder / "pipeline.yaml", "--dataset", dataset,
                                          "--data", folder / "data",          "--output",  folder / "out"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_aslio(arguments);
  }
};

}  // namespace

TEST_CASE("datasets lists the shipped families, and shows one or a sequence of one") {
  const Ended all = run_aslio({"datasets"});
  INFO(all.err);
  CHECK(all.code == 0);
  for (const char* name : {"name ", "newer_college_2021", "kitti_raw", "ntu_viral", "CC BY-NC-SA 3.0"}) {
    CHECK_THAT(all.out, Contains(name));
  }
  const Ended one = run_aslio({"datasets", "newer_college_2021"});
  CHECK(one.code == 0);
  CHECK_THAT(one.out, Contains("quad_hard") && Contains("1880") && Contains("quad_hard/*.bag") && Contains("in use") &&
                          Contains("RESPLE") && Contains("https://ori-drs.github.io") && Contains("arXiv:2112.08854"));
  const Ended sequence = run_aslio({"datasets", "enwide/tunnel_d"});
  CHECK(sequence.code == 0);
  CHECK_THAT(sequence.out, Contains("tunnel_d/gt-tunnel_d.csv") && Contains("positions only") && !Contains("runway"));
}

TEST_CASE("an unknown family or sequence is answered by the nearest and by all") {
  const TemporaryFolder folder;
  for (const std::vector<std::string>& start :
       {std::vector<std::string>{"datasets"},
        {"run", std::string(ASLIO_SOURCE_DIR) + "/configs/pipelines/as_lio.yaml", "--output", folder / "out", "--data",
         folder / ".", "--dataset"}}) {
    auto arguments = start;
    arguments.emplace_back("newer_colege_2021/quad_hard");
    const Ended family = run_aslio(arguments);
    CHECK(family.code == 2);
    CHECK_THAT(family.err, Contains("did you mean 'newer_college_2021'") && Contains("hilti_2022"));
    arguments.back() = "newer_college_2021/quad_hrad";
    const Ended sequence = run_aslio(arguments);
    CHECK(sequence.code == 2);
    CHECK_THAT(sequence.err, Contains("did you mean 'quad_hard'") && Contains("cloister"));
  }
}

TEST_CASE("files that are missing are named, with the address of the data") {
  const TemporaryFolder folder;
  const Ended ended = run_aslio({"run", std::string(ASLIO_SOURCE_DIR) + "/configs/pipelines/as_lio.yaml", "--dataset",
                                 "newer_college_2021/maths_easy", "--data", folder / ".", "--output", folder / "out"});
  CHECK(ended.code == 2);
  CHECK_THAT(ended.err, Contains("maths_easy/*.bag (recording)") &&
                            Contains("maths_easy/gt_state_easy.csv (reference)") &&
                            Contains("https://ori-drs.github.io"));
  CHECK_FALSE(fs::exists(folder / "out"));
}

TEST_CASE("a sequence of a family runs as its files do, and the manifest says whose extrinsic it took") {
  const FamilyBench bench;
  const Ended plain =
      run_aslio({"run", bench / "pipeline.yaml", "--input", bench / "data/walk/walk_0.bag", "--sensor",
                 bench / "sensor.yaml", "--reference", bench / "data/walk/truth.tum", "--output", bench / "plain"});
  REQUIRE(plain.code == 0);
  const Ended ended = bench.run((bench / "walks.yaml").string() + "/walk");
  INFO(ended.err);
  REQUIRE(ended.code == 0);
  CHECK(content(bench / "out/trajectory.tum") == content(bench / "plain/trajectory.tum"));
  CHECK(json(bench / "out/summary.json").at("metrics") == json(bench / "plain/summary.json").at("metrics"));
  const auto manifest = json(bench / "out/manifest.json");
  CHECK(manifest.at("published").at("family") == "walks");
  CHECK(manifest.at("published").at("sequence") == "walk");
  CHECK(manifest.at("published").at("extrinsic_source") == "the maker");
  CHECK(json(bench / "plain/manifest.json").at("published").is_null());
  CHECK_THAT(ended.err, !Contains("as published"));
  REQUIRE(bench.run((bench / "walks.yaml").string() + "/walk", {"--sensor", bench / "sensor.yaml"}).code == 0);
  CHECK(json(bench / "out/manifest.json").at("published").at("extrinsic_source") == "the file of --sensor");
}

TEST_CASE("a sequence with other counts than published is reported at the end of a run") {
  const FamilyBench bench("{name: walk, sweeps: 19, imu_samples: 10000}");
  const std::string walk = (bench / "walks.yaml").string() + "/walk";
  const Ended ended = bench.run(walk);
  CHECK(ended.code == 0);
  CHECK_THAT(ended.err, Contains("warning: walks/walk has 19 sweeps as published") &&
                            Contains("walks/walk has 10000 IMU samples as published"));
  CHECK_THAT(json(bench / "out/summary.json").dump(), Contains("10000 IMU samples"));
  // A part of it was not to have as many.
  CHECK_THAT(bench.run(walk, {"--duration", "1"}).err, !Contains("as published"));
}

TEST_CASE("the option --data goes with FAMILY/SEQUENCE, and the other way round") {
  const FamilyBench bench;
  const auto refusal = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments = {"run", bench / "pipeline.yaml", "--output", bench / "out"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Ended ended = run_aslio(arguments);
    CHECK(ended.code == 2);
    return ended.err;
  };
  const std::string file = bench / "walks.yaml";
  CHECK_THAT(refusal({"--dataset", file + "/walk"}), Contains("needs --data DIR"));
  CHECK_THAT(refusal({"--dataset", file}), Contains("is a family file; name a sequence"));
  CHECK_THAT(refusal({"--dataset", file, "--data", bench / "data"}), Contains("FAMILY/SEQUENCE"));
  CHECK_THAT(refusal({"--dataset", "gone.yaml"}), Contains("does not exist"));
  CHECK_THAT(refusal({"--dataset", "out/gone"}), Contains("does not exist"));
  CHECK_THAT(refusal({"--data", bench / "data"}), Contains("--data goes with --dataset FAMILY/SEQUENCE"));
  CHECK_THAT(refusal({"--dataset", file + "/walk", "--data", bench / "none"}), Contains("is no folder"));
}

TEST_CASE("evaluate takes the reference of a sequence") {
  const FamilyBench bench;
  const std::string walk = (bench / "walks.yaml").string() + "/walk";
  REQUIRE(bench.run(walk).code == 0);
  const Ended by_name =
      run_aslio({"evaluate", bench / "out/trajectory.tum", "--dataset", walk, "--data", bench / "data", "--json"});
  INFO(by_name.err);
  CHECK(by_name.code == 0);
  const Ended by_file = run_aslio({"evaluate", bench / "out/trajectory.tum", "--reference",
                                   bench / "data/walk/truth.tum", "--sensor", bench / "sensor.yaml", "--json"});
  CHECK(by_name.out == by_file.out);
  const Ended none = run_aslio({"evaluate", bench / "out/trajectory.tum"});
  CHECK(none.code == 2);
  CHECK_THAT(none.err, Contains("give --reference, or --dataset"));
}

TEST_CASE("check and describe know family files") {
  const FamilyBench bench;
  const Ended good = run_aslio({"check", bench / "walks.yaml"});
  INFO(good.err);
  CHECK(good.code == 0);
  CHECK_THAT(good.out, Contains("walks.yaml: ok (family)"));
  write_text(bench / "sensor.yaml", sensor_text("min_range: -1\n"));
  CHECK_THAT(run_aslio({"check", bench / "walks.yaml"}).err, Contains("sensor.yaml:") && Contains("min_range"));
  const Ended keys = run_aslio({"describe", "family"});
  CHECK(keys.code == 0);
  CHECK_THAT(keys.out, Contains("schema: aslio/family/1") && Contains("sequences"));
}
