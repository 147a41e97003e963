#include <algorithm>
#include <catch2/catch.hpp>
#include <fstream>

#include "aslio/config/load.hpp"
#include "aslio/core/errors.hpp"
#include "aslio/io/inspect.hpp"
#include "aslio/io/sensor_file.hpp"
#include "io/bag_fixture.hpp"

namespace aslio::io::test {
namespace {

class NoStages final : public config::StageLookup {
 public:
  const config::StageEntry* find(std::string_view, std::string_view) const override { return nullptr; }
  std::vector<std::string> families() const override { return {}; }
  std::vector<std::string> types(std::string_view) const override { return {}; }
};

SensorConfig parse(const std::string& text) {
  return config::parse<SensorConfig>("schema: aslio/sensor/1\n" + text, "s.yaml", config::FileKind::sensor, NoStages())
      .value;
}

std::string error(const std::string& text) {
  try {
    parse(text);
  } catch (const ConfigError& e) {
    return e.what();
  }
  return {};
}

}  // namespace

TEST_CASE("every shipped sensor file loads, and its dump reads back equal") {
  std::size_t files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(ASLIO_SOURCE_DIR "/configs/sensors")) {
    const std::filesystem::path& path = entry.path();
    INFO(path);
    ++files;
    const auto loaded = config::load<SensorConfig>(path, config::FileKind::sensor, NoStages());
    const Mat3& R = loaded.value.model.T_imu_lidar.R;
    // What deviates by less was not cut by hand, and is kept to the bit.
    CHECK((R.transpose() * R - Mat3::Identity()).cwiseAbs().maxCoeff() < 1e-12);
    const auto again = config::parse<SensorConfig>(loaded.resolved, "dump", config::FileKind::sensor, NoStages());
    CHECK(again.value.model.T_imu_lidar.R == R);
    CHECK(again.value.model.T_imu_lidar.p == loaded.value.model.T_imu_lidar.p);
    CHECK(again.resolved == loaded.resolved);
  }
  CHECK(files >= 6);
}

TEST_CASE("of the shipped sensor files, those of a LiDAR without an IMU alone have a placeholder") {
  std::vector<std::string> marked;
  for (const auto& entry : std::filesystem::directory_iterator(ASLIO_SOURCE_DIR "/configs/sensors")) {
    const SensorConfig sensor = load_sensor(entry.path(), NoStages()).value;
    INFO(entry.path());
    CHECK(sensor.placeholder_warning.empty() != sensor.extrinsic_placeholder);
    if (sensor.extrinsic_placeholder) marked.push_back(entry.path().stem().string());
  }
  std::sort(marked.begin(), marked.end());
  CHECK(marked == std::vector<std::string>{"hesai_xt32", "velodyne_vlp16"});
}

TEST_CASE("a drafted extrinsic warns, with its line and the remedy, until the mark is deleted") {
  TemporaryFolder folder;
  Recording().write(folder / "a.bag");
  std::string text = draft_sensor(inspect(folder / "a.bag"));
  const std::filesystem::path file = folder / "sensor.yaml";
  std::ofstream(file) << text;
  const auto drafted = load_sensor(file, NoStages());
  CHECK(drafted.value.model.T_imu_lidar.R == Mat3::Identity());
  for (const char* part : {"sensor.yaml:11:16: T_imu_lidar is still a placeholder", "translation [0, 0, 0] m",
                           "rotation [1, 0, 0, 0, 1, 0, 0, 0, 1]", "delete this line", "docs/howto_check_frames.md"}) {
    INFO(drafted.value.placeholder_warning);
    CHECK(contains(drafted.value.placeholder_warning, part));
  }
  // Once where it is read, and once in what is found of the recording.
  const auto warnings = open_source(folder / "a.bag", drafted.value)->notes().warnings;
  CHECK(std::count(warnings.begin(), warnings.end(), drafted.value.placeholder_warning) == 1);
  const auto inspected = inspect(folder / "a.bag", drafted.value).warnings;
  CHECK(std::count(inspected.begin(), inspected.end(), drafted.value.placeholder_warning) == 1);
  // What states every value keeps the mark.
  CHECK(config::parse<SensorConfig>(drafted.resolved, "dump", config::FileKind::sensor, NoStages())
            .value.extrinsic_placeholder);

  const std::string mark = "  placeholder: true";
  const std::size_t begin = text.find(mark);
  REQUIRE(begin != std::string::npos);
  text.erase(begin, text.find('\n', begin) + 1 - begin);
  std::ofstream(file) << text;  // the identity is meant
  const SensorConfig meant = load_sensor(file, NoStages()).value;
  CHECK(meant.placeholder_warning.empty());
  CHECK(meant.model.T_imu_lidar.R == Mat3::Identity());
  for (const std::string& warning : open_source(folder / "a.bag", meant)->notes().warnings) {
    CHECK_FALSE(contains(warning, "placeholder"));
  }
}

TEST_CASE("values of a sensor file") {
  const SensorConfig sensor = parse(
      "imu_topic: /imu\nacc_unit: g\ngyro_unit: deg_s\nlivox_tag_filter: false\nscan_lines: 4\n"
      "T_imu_lidar: {translation: [1, 2, 3], rotation: [0, -1, 0, 1, 0, 0, 0, 0, 1]}\n");
  CHECK(sensor.imu_topic == "/imu");
  CHECK(sensor.acc_unit == AccUnit::g);
  CHECK(sensor.gyro_unit == GyroUnit::deg_s);
  CHECK_FALSE(sensor.livox_tag_filter);
  CHECK(sensor.model.scan_lines == 4);
  CHECK((sensor.model.T_imu_lidar * Vec3(1, 0, 0)).isApprox(Vec3(1, 3, 3)));
}

TEST_CASE("the calibration of the IMU in a sensor file: row by row, and small") {
  const std::string text = "gyro_sensitivity: [0.01, 0.002, 0, 0, 0, 0, 0, 0, -0.005]\nimu_delay: 0.0015\n";
  const SensorConfig sensor = parse(text);
  CHECK(sensor.gyro_sensitivity(0, 1) == 0.002);
  CHECK(sensor.gyro_sensitivity(1, 0) == 0);
  CHECK(sensor.gyro_sensitivity(2, 2) == -0.005);
  CHECK(sensor.imu_delay == 0.0015);
  CHECK(parse("").gyro_sensitivity.isZero(0));
  const auto dump =
      config::parse<SensorConfig>("schema: aslio/sensor/1\n" + text, "s.yaml", config::FileKind::sensor, NoStages())
          .resolved;
  CHECK(config::parse<SensorConfig>(dump, "dump", config::FileKind::sensor, NoStages()).value.gyro_sensitivity ==
        sensor.gyro_sensitivity);
  // Calibrations are given as I + S, too.
  CHECK(contains(error("gyro_sensitivity: [1.01, 0, 0, 0, 1, 0, 0, 0, 1]\n"), "gyro_sensitivity"));
  CHECK_FALSE(error("gyro_sensitivity: [0.01, 0.01, 0.01]\n").empty());
  CHECK(contains(error("imu_delay: 2\n"), "imu_delay"));
}

TEST_CASE("an extrinsic that is no rotation is refused at its place") {
  const std::string skewed = error("T_imu_lidar:\n  rotation: [1, 0.1, 0, 0, 1, 0, 0, 0, 1]\n");
  CHECK(contains(skewed, "s.yaml:3:"));
  CHECK(contains(skewed, "not orthonormal"));
  CHECK(contains(error("T_imu_lidar:\n  rotation: [1, 0, 0, 0, 1, 0, 0, 0, -1]\n"), "determinant -1"));
  CHECK_FALSE(error("T_imu_lidar:\n  rotation: [1, 0, 0]\n").empty());
  CHECK_FALSE(error("acc_noise: 0\n").empty());
  CHECK(contains(error("min_range: 5\nmax_range: 4\n"), "max_range"));
  CHECK_FALSE(error("acc_unit: feet\n").empty());
}

}  // namespace aslio::io::test
