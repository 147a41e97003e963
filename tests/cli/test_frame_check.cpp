// `aslio inspect --check`: what it refuses, and a whole recording with one thing wrong at a time.
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "fixture.hpp"

using namespace aslio::test;
using Catch::Contains;

namespace {

/// The whole walk of 20 s, simulated; its poses.
struct Walk {
  TemporaryFolder folder;
  Walk() {
    Recording recording;
    recording.duration = 20;
    write_bag(folder / "walk.bag", recording);
    write_truth(folder / "truth.tum");
  }
  Ended check(const std::string& sensor, const std::vector<std::string>& more = {}) const {
    write_text(folder / "sensor.yaml", sensor);
    std::vector<std::string> arguments{"inspect", folder / "walk.bag", "--sensor", folder / "sensor.yaml", "--check"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_aslio(arguments);
  }
};

}  // namespace

TEST_CASE("inspect --check needs a sensor file, and its options need --check") {
  const Bench bench;
  const Ended no_sensor = run_aslio({"inspect", bench / "recording.bag", "--check"});
  CHECK(no_sensor.code == 2);
  CHECK_THAT(no_sensor.err, Contains("--input needs --sensor"));
  const Ended no_check = run_aslio({"inspect", bench / "recording.bag", "--json", bench / "x.json"});
  CHECK(no_check.code == 2);
  CHECK_THAT(no_check.err, Contains("--json is an option of --check"));
  const Ended nothing = run_aslio({"inspect"});
  CHECK(nothing.code == 2);
  CHECK_THAT(nothing.err, Contains("give PATH, or --dataset"));
  const Ended draft = run_aslio({"inspect", bench / "recording.bag", "--sensor", bench / "sensor.yaml", "--check",
                                 "--write-sensor", bench / "new.yaml"});
  CHECK(draft.code == 2);
  CHECK_THAT(draft.err, Contains("--write-sensor goes without --check"));
  const Ended set = run_aslio({"inspect", bench / "recording.bag", "--sensor", bench / "sensor.yaml", "--check",
                               "--reference-set", "time_offset=1"});
  CHECK(set.code == 2);
  CHECK_THAT(set.err, Contains("there is none"));
}

TEST_CASE("inspect --check refuses a pipeline that takes the IMU") {
  const Bench bench;
  const Ended ended = run_aslio({"inspect", bench / "recording.bag", "--sensor", bench / "sensor.yaml", "--check",
                                 "--pipeline", bench / "pipeline.yaml"});
  CHECK(ended.code == 2);
  CHECK_THAT(ended.err, Contains("its estimator takes IMU data"));
}

TEST_CASE("inspect --check says when a recording is too short") {
  const Bench bench;
  const Ended ended =
      run_aslio({"inspect", bench / "recording.bag", "--sensor", bench / "sensor.yaml", "--check", "--duration", "1"});
  CHECK(ended.code == 3);
  CHECK_THAT(ended.err, Contains("no stretch of 1.5 s could be registered"));
}

TEST_CASE("inspect --check finds nothing wrong where nothing moves, and says what is open") {
  Recording still;
  still.duration = 8;
  still.slowness = 100;
  const Bench bench(still);
  const Ended ended = run_aslio({"inspect", bench / "recording.bag", "--sensor", bench / "sensor.yaml", "--check"});
  INFO(ended.out << ended.err);
  CHECK(ended.code == 0);
  CHECK_THAT(ended.out, Contains("open   LiDAR against gyro: it hardly turns"));
  CHECK_THAT(ended.out, Contains("open   reference: there is none"));
  CHECK_THAT(ended.out, Contains("ok     specific force: at rest"));
}

TEST_CASE("inspect --check agrees with right files, and names the published extrinsic that fits") {
  const Walk walk;
  write_text(walk.folder / "right.yaml", sensor_text());
  write_text(
      walk.folder / "wrong.yaml",
      "schema: aslio/sensor/1\nT_imu_lidar: {translation: [0.04165, 0.12326, -0.0284], rotation: [1, 0, 0, 0, 1, "
      "0, 0, 0, 1]}\n");
  const Ended ended =
      walk.check(sensor_text(), {"--reference", walk.folder / "truth.tum", "--extrinsic", walk.folder / "right.yaml",
                                 "--extrinsic", walk.folder / "wrong.yaml", "--json", walk.folder / "check.json"});
  INFO(ended.out << ended.err);
  CHECK(ended.code == 0);
  CHECK_THAT(ended.out, Contains("nothing contradicts the files"));
  CHECK_THAT(ended.out, Contains("right.yaml alone fits"));
  const auto json = nlohmann::json::parse(content(walk.folder / "check.json"));
  CHECK(json["contradicts"] == false);
  CHECK(std::abs(json["lidar_against_gyro"]["delay_s"].get<double>()) < 0.003);
}

TEST_CASE("inspect --check names all that is wrong in a file, each with its key") {
  const Walk walk;
  const Ended ended =
      walk.check(sensor_text("gyro_signs: [1, 1, -1]\nacc_signs: [-1, 1, 1]\nlidar_time_offset: 0.1\n"));
  INFO(ended.out << ended.err);
  CHECK(ended.code == 4);
  for (const char* key : {"set gyro_signs: [1, 1, 1]", "set acc_signs: [1, 1, 1]", "set lidar_stamp: end"}) {
    CHECK_THAT(ended.out, Contains(key));
  }
}
