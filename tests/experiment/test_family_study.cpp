/// Studies over sequences of a family.

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "cli/recordings.hpp"
#include "family_files.hpp"
#include "study_files.hpp"

using namespace aslio::test;
using namespace aslio::experiment;
using Catch::Matchers::Contains;

namespace fs = std::filesystem;

namespace {

/// A study beside a family of two sequences, whose data lie in `data`.
struct Bench {
  StudyFiles study;
  std::string methods = "methods:\n" + method("a", "fixed_window");

  Bench() {
    write_text(at("sensor.yaml"), sensor_text());
    write_text(at("walks.yaml"), family_head() +
                                     "sensor: sensor.yaml\nextrinsics: [{source: maker}]\n"
                                     "input: ['{sequence}.bag']\n"
                                     "sequences: [{name: quad_easy}, {name: quad_hard}, {name: stairs}]\n");
    fs::create_directories(at("data"));
    for (const char* name : {"quad_easy", "quad_hard", "stairs"}) {
      write_text(at("data") / (std::string(name) + ".bag"), "none is read");
    }
  }
  fs::path at(const std::string& name) const { return study.folder / name; }
  std::string text(const std::string& entry) const {
    return head() + "datasets: [{family: " + entry + ", data: data}]\n" + methods;
  }
  std::vector<std::string> names(const std::string& entry) const {
    std::vector<std::string> out;
    for (const StudyData& data : study.load(text(entry)).data) out.push_back(data.name);
    return out;
  }
};

}  // namespace

TEST_CASE("a study takes the sequences of a family that it names") {
  using Names = std::vector<std::string>;
  const Bench bench;
  CHECK(bench.names("walks.yaml") == Names{"quad_easy", "quad_hard", "stairs"});
  CHECK(bench.names("walks.yaml, sequences: '*'") == Names{"quad_easy", "quad_hard", "stairs"});
  CHECK(bench.names("walks.yaml, sequences: stairs") == Names{"stairs"});
  CHECK(bench.names("walks.yaml, sequences: [stairs, 'quad_h*']") == Names{"quad_hard", "stairs"});
  CHECK(bench.names("walks.yaml, sequences: stairs, name: ncd") == Names{"ncd_stairs"});
  const Study study = bench.study.load(bench.text("walks.yaml, sequences: stairs"));
  CHECK(study.data[0].dataset == bench.at("walks.yaml") / "stairs");
  CHECK(study.data[0].folder == bench.at("data"));
  CHECK(study.data[0].sequence == "stairs");
  // By its name, from the folder of shipped ones.
  StudyReading reading;
  reading.families = bench.at(".");
  CHECK(bench.study.load(bench.text("walks"), reading).data.size() == 3);
}

TEST_CASE("the data of a family are another recording once a file of theirs has changed") {
  const Bench bench;
  const auto identity = [&] { return bench.study.load(bench.text("walks.yaml, sequences: stairs")).data[0].identity; };
  const std::string before = identity();
  CHECK(identity() == before);
  write_text(bench.at("data/stairs.bag"), "longer than before");
  const std::string other_data = identity();
  CHECK(other_data != before);
  write_text(bench.at("sensor.yaml"), sensor_text("max_range: 20\n"));
  CHECK(identity() != other_data);
}

TEST_CASE("what is wrong with a family in a study is reported with its place") {
  const Bench bench;
  const auto complaint = [&](const std::string& datasets) {
    return bench.study.complaint(head() + "datasets: [{" + datasets + "}]\n" + bench.methods);
  };
  CHECK_THAT(complaint("family: walks.yaml"), Contains("study.yaml:5:") && Contains("folder with the files"));
  CHECK_THAT(complaint("family: wals, data: data"), Contains("study.yaml:5:") && Contains("no family 'wals'"));
  CHECK_THAT(complaint("family: walks.yaml, data: data, sequences: quad"),
             Contains("study.yaml:5:") && Contains("no sequence 'quad'") && Contains("quad_easy, quad_hard, stairs"));
  CHECK_THAT(complaint("family: walks.yaml, data: data, sequences: {a: 1}"), Contains("a list of them"));
  CHECK_THAT(complaint("family: walks.yaml, data: data, scene: scene_a.yaml"), Contains("exclude each other"));
  CHECK_THAT(complaint("scene: scene_a.yaml, sequences: '*'"), Contains("goes with `family`"));
  fs::remove(bench.at("data/stairs.bag"));
  CHECK_THAT(complaint("family: walks.yaml, data: data"),
             Contains("study.yaml:5:") && Contains("walks/stairs") && Contains("stairs.bag (recording)"));
}

TEST_CASE("a study over a family runs, and a second call repeats nothing") {
  const Bench bench;
  for (const char* name : {"quad_easy.bag", "stairs.bag"}) write_bag(bench.at("data") / name);
  write_text(bench.at("quick.yaml"), pipeline_text());
  write_text(bench.at("study.yaml"), head() +
                                         "datasets: [{family: walks.yaml, data: data, sequences: [quad_e*, stairs]}]\n"
                                         "methods: [{name: quick, pipeline: quick.yaml}]\n");
  const auto run = [&] { return run_aslio({"experiment", bench.at("study.yaml"), "--output", bench.at("out")}); };
  const Ended first = run();
  INFO(first.err);
  REQUIRE(first.code == 0);
  CHECK(column(bench.at("out/results.csv"), "data") == std::vector<std::string>{"quad_easy", "stairs"});
  const auto manifest = nlohmann::json::parse(content(bench.at("out/runs/stairs/quick/manifest.json")));
  CHECK(manifest.at("published").at("family") == "walks");
  CHECK(manifest.at("published").at("sequence") == "stairs");
  CHECK_THAT(manifest.at("data").at("dataset").get<std::string>(), Contains("walks.yaml/stairs"));
  const Ended second = run();
  CHECK(second.code == 0);
  CHECK_THAT(second.err, !Contains("[1/2] quad_easy/quick: ok"));
  // The whole report of the study needs no file of the data.
  CHECK(run_aslio({"report", bench.at("out")}).code == 0);
}
