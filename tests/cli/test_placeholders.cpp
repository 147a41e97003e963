/// What a draft or a template leaves to its user, and who is warned of it.
#include <catch2/catch.hpp>

#include "fixture.hpp"

using namespace aslio::test;
using Catch::Matchers::Contains;

namespace fs = std::filesystem;

namespace {

/// The sensor file of the recording with the identity as extrinsic, and `more` beside it.
std::string with_identity(const std::string& more) {
  std::string text = sensor_text();
  const std::size_t begin = text.find("T_imu_lidar:");
  REQUIRE(begin != std::string::npos);
  return text.replace(begin, text.find('\n', begin) - begin,
                      "T_imu_lidar: {translation: [0, 0, 0], rotation: [1, 0, 0, 0, 1, 0, 0, 0, 1]" + more + "}");
}

}  // namespace

TEST_CASE("check, inspect --check and run warn once of an extrinsic that nobody has measured") {
  const Bench bench;
  write_text(bench / "marked.yaml", with_identity(", placeholder: true"));
  write_text(bench / "meant.yaml", with_identity(""));
  const auto commands = [&](const std::string& sensor) {
    const std::string bag = bench / "recording.bag", file = bench / sensor;
    return std::vector<std::vector<std::string>>{
        {"check", file},
        {"inspect", bag, "--sensor", file, "--check"},
        {"run", bench / "pipeline.yaml", "--input", bag, "--sensor", file, "--output", bench / (sensor + "_out")}};
  };
  const std::string said = "marked.yaml:", what = "T_imu_lidar is still a placeholder";
  for (const auto& command : commands("marked.yaml")) {
    const Ended ended = run_aslio(command);
    INFO(command.front() << ": " << ended.err);
    const std::size_t at = ended.err.find(what);
    REQUIRE(at != std::string::npos);
    CHECK(ended.err.find(what, at + 1) == std::string::npos);
    CHECK_THAT(ended.err, Contains("warning: ") && Contains(said) && Contains("docs/howto_check_frames.md"));
  }
  CHECK(run_aslio(commands("marked.yaml").front()).code == 0);
  CHECK_THAT(content(bench / "marked.yaml_out" / "summary.json"), Contains(what));
  for (const auto& command : commands("meant.yaml")) {
    const Ended ended = run_aslio(command);
    INFO(command.front() << ": " << ended.err);
    CHECK(ended.err.find("placeholder") == std::string::npos);
  }
}

TEST_CASE("check and experiment warn of the text of a template that a study still holds, for every template") {
  const TemporaryFolder folder;
  const fs::path source(ASLIO_SOURCE_DIR);
  fs::copy_file(source / "tools/templates/plugin/common/study/scene.yaml", folder / "scene.yaml");
  fs::copy_file(source / "configs/pipelines/as_lio_plus.yaml", folder / "as_lio_plus.yaml");
  const std::string request = "prediction: Write here", study = folder / "study.yaml";
  const std::vector<std::string> check = {"check", study},
                                 plan = {"experiment", study, "--output", folder / "out", "--dry-run", "--quiet"};
  std::size_t templates = 0;
  for (const auto& family : fs::directory_iterator(source / "tools/templates/plugin")) {
    const fs::path file = family.path() / "study/study.yaml";
    if (!fs::exists(file)) continue;
    ++templates;
    // The stage itself is not there: of the template, the texts alone count here.
    std::string text = content(file);
    text = text.substr(0, text.find("datasets:")) +
           "datasets: [{scene: scene.yaml}]\nmethods: [{name: m, pipeline: as_lio_plus.yaml}]\n";
    write_text(study, text);
    for (const auto& command : {check, plan}) {
      const Ended ended = run_aslio(command);
      INFO(family.path() << ": " << command.front() << ": " << ended.err);
      CHECK(ended.code == 0);
      CHECK_THAT(ended.err, Contains("study.yaml:3:13: 'prediction' still holds the text of the template"));
      CHECK(ended.err.find("'question' still") == std::string::npos);
    }
    REQUIRE(text.find(request) != std::string::npos);
    write_text(study, text.replace(text.find(request), request.size(), "prediction: I expect"));
    CHECK(run_aslio(check).err.empty());
    CHECK(run_aslio(plan).err.empty());
  }
  CHECK(templates >= 10);
}
