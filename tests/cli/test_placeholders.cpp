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
