/// Debian's own python3-rosbag reads what is recorded. The test fails when that package is missing.

#include <catch2/catch.hpp>
#include <cstdio>
#include <filesystem>

#include "recorded.hpp"

using namespace aslio;
using namespace aslio::simulator;
using Catch::Matchers::Contains;
using simulator::test::Recorded;

namespace {

/// What read_bag.py prints, errors included.
std::string read_by_rosbag(const Recorded& recorded) {
  const std::filesystem::path script = std::filesystem::path(ASLIO_SOURCE_DIR) / "tests/simulator/record/read_bag.py";
  const std::string command =
      "/usr/bin/python3 -B -W error '" + script.string() + "' '" + (recorded / "quick.bag").string() + "' 2>&1";
  std::FILE* pipe = popen(command.c_str(), "r");
  REQUIRE(pipe != nullptr);
  std::string text;
  for (int c = std::fgetc(pipe); c != EOF; c = std::fgetc(pipe)) text += static_cast<char>(c);
  INFO(text);
  REQUIRE(pclose(pipe) == 0);
  return text;
}

std::string counted(const char* key, std::size_t value) {
  return std::string("\"") + key + "\": " + std::to_string(value);
}

}  // namespace

TEST_CASE("python3-rosbag reads every message of a Livox recording", "[record]") {
  const Recorded recorded;
  const std::string text = read_by_rosbag(recorded);
  CHECK_THAT(text, Contains("\"/livox/lidar\"") && Contains("\"/livox/imu\"") && Contains("\"compression\": \"lz4\""));
  CHECK_THAT(text, Contains("e4d6829bdfe657cb6c21a746c86b21a6") && Contains("6a62c6daae103f4ff57a132d6f95cec2"));
  CHECK_THAT(text, Contains(counted("count", recorded.result.packets)) &&
                       Contains(counted("count", recorded.result.imu_samples)) &&
                       Contains(counted("points", recorded.result.points)));
}

TEST_CASE("python3-rosbag reads every message of a spinning sensor's recording", "[record]") {
  SimulationOptions options;
  options.sensor = SensorKind::spin32;
  const Recorded recorded("", 1, options);
  const std::string text = read_by_rosbag(recorded);
  CHECK_THAT(text, Contains("\"/velodyne_points\"") && Contains("1158d486dd51d683ce2f1be655c3c181"));
  CHECK_THAT(text, Contains(R"("fields": ["x", "y", "z", "intensity", "ring", "time"])"));
  CHECK_THAT(
      text, Contains(counted("count", recorded.result.packets)) && Contains(counted("points", recorded.result.points)));
}
