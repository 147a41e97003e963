/// `aslio calibrate`: from what runs have learnt of the IMU to a sensor file, and back into a run.

#include <Eigen/LU>
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <optional>

#include "aslio/config/load.hpp"
#include "aslio/core/errors.hpp"
#include "aslio/experiment/calibrated_sensor.hpp"
#include "aslio/io/source.hpp"
#include "aslio/plugin/registry.hpp"
#include "child.hpp"
#include "recordings.hpp"

using namespace aslio;
using namespace aslio::test;
using Catch::Matchers::Contains;
using Json = nlohmann::json;

namespace {

io::SensorConfig read_sensor(const std::filesystem::path& file) {
  return config::load<io::SensorConfig>(file, config::FileKind::sensor, plugin::Catalog()).value;
}

/// What a run has learnt, by its summary.
struct Learnt {
  std::string status = "ok";
  std::array<double, 9> S{};
  double S_sigma = 1e-4;
  double delay = 0, delay_sigma = 1e-5;
  bool diagonal = false;  ///< cross-axis terms are held fixed
  std::string sensor{};   ///< further lines of its sensor file
};

std::string with_input(const std::string& sha256, const std::string& sensor) {
  return Json{{"input", {{"sha256", sha256}}}, {"sensor", {{"resolved", sensor_text(sensor)}}}}.dump();
}

/// A folder that holds as much of runs as the command reads.
struct Runs {
  TemporaryFolder folder;

  std::string add(const std::string& name, const Learnt& learnt) const {
    std::filesystem::create_directories(folder / name);
    Json S = Json::array(), sigma = Json::array();
    for (std::size_t i = 0; i < 9; ++i) {
      const bool fixed = learnt.diagonal && i % 4 != 0;
      S.push_back(fixed ? Json(nullptr) : Json(learnt.S[i]));
      sigma.push_back(fixed ? Json(nullptr) : Json(learnt.S_sigma));
    }
    const Json summary = {{"status", learnt.status},
                          {"calibration",
                           {{"gyro_sensitivity", S},
                            {"gyro_sensitivity_sigma", sigma},
                            {"imu_delay_s", learnt.delay},
                            {"imu_delay_sigma_s", learnt.delay_sigma}}}};
    write_text(folder / name / "summary.json", summary.dump());
    write_text(folder / name / "manifest.json", Json{{"sensor", {{"resolved", sensor_text(learnt.sensor)}}}}.dump());
    return folder / name;
  }
  std::filesystem::path operator/(const std::string& name) const { return folder / name; }
  Ended calibrate(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), "calibrate");
    arguments.insert(arguments.end(), {"--output", folder / "new.yaml"});
    return run_aslio(arguments);
  }
};

}  // namespace

TEST_CASE("calibrate: what was known and what was learnt beyond it are taken out one after the other") {  // eq. MOT-11
  Mat3 known, learnt;
  known << 0.012, 0.004, -0.003, 0.002, -0.009, 0.001, 0.005, -0.002, 0.007;
  learnt << -0.004, 0.001, 0.002, -0.003, 0.006, 0.004, 0.001, 0.003, -0.005;
  const Mat3 S = experiment::compose_gyro_sensitivity(known, learnt), I = Mat3::Identity();
  const Vec3 measured(1.2, -3.4, 0.7);
  const Vec3 twice = (I - learnt) * ((I + known).inverse() * measured);
  CHECK(((I + S).inverse() * measured - twice).norm() < 1e-14);
  CHECK(experiment::compose_gyro_sensitivity(known, Mat3::Zero()).isApprox(known, 1e-13));
}

TEST_CASE("calibrate: the sensor file of a run with what it has learnt") {
  const Runs runs;
  const std::string run = runs.add("run", {.S = {0.01, 0.002, 0.003, 0.004, -0.005, 0.001, 0, 0.002, 0.008},
                                           .delay = 0.002,
                                           .sensor = "min_range: 1.25\n"});
  const Ended ended = runs.calibrate({run});
  INFO(ended.err);
  REQUIRE(ended.code == 0);
  const io::SensorConfig sensor = read_sensor(runs / "new.yaml");
  CHECK(sensor.gyro_sensitivity(0, 1) == Approx(0.002).epsilon(0.02));  // row by row
  CHECK(sensor.gyro_sensitivity(1, 0) == Approx(0.004).epsilon(0.02));
  CHECK(sensor.gyro_sensitivity(1, 1) == Approx(-0.005).epsilon(0.02));
  CHECK(sensor.imu_delay == 0.002);
  CHECK(sensor.model.min_range == 1.25);
  CHECK_THAT(ended.out, Contains("of 1 run,"));
  CHECK_THAT(ended.out, Contains("+1.011 +- 0.040"));
  const std::string known =
      " --set 'estimator.sigma_gyro_sensitivity=[0.0004,0.0004,0.0004,0.0004,0.0004,0.0004,0.0004,0.0004,0.0004]' "
      "--set estimator.sigma_time_offset=4e-05\n";
  CHECK_THAT(ended.out, Contains("--sensor " + (runs / "new.yaml").string() + known));
  CHECK_THAT(content(runs / "new.yaml"), Contains("#" + known));
  CHECK(runs.calibrate({run}).code == 0);  // what it wrote itself is replaced
}

TEST_CASE("calibrate: a run over what is known adds to it") {
  const Runs runs;
  const std::string run = runs.add("run", {.S = {0.001, 0, 0, 0, 0, 0, 0, 0, 0},
                                           .delay = -0.0005,
                                           .sensor = "gyro_sensitivity: [0.01, 0, 0, 0, 0.002, 0, 0, 0, 0]\n"
                                                     "imu_delay: 0.003\n"});
  REQUIRE(runs.calibrate({run}).code == 0);
  const io::SensorConfig sensor = read_sensor(runs / "new.yaml");
  CHECK(sensor.gyro_sensitivity(0, 0) == Approx(1.01 / 0.999 - 1));
  CHECK(sensor.gyro_sensitivity(1, 1) == Approx(0.002));
  CHECK(sensor.imu_delay == Approx(0.0025));
}

TEST_CASE("calibrate: several runs weigh as they claim, and know no better than they agree") {  // eq. MOT-11
  const plugin::Catalog none;
  const auto run = [](double S, double sigma) {
    experiment::RunCalibration out;
    out.sensor_resolved = sensor_text();
    out.gyro_sensitivity = {S * Mat3::Identity(), sigma * Mat3::Identity()};
    out.imu_delay = {0.0015, 0};
    return out;
  };
  const auto agree = experiment::combine({run(0.010, 0.001), run(0.012, 0.002)}, none);
  CHECK(agree.gyro_sensitivity.value(0, 0) == Approx(0.0104));  // four times the weight
  CHECK(agree.gyro_sensitivity.sigma(0, 0) == Approx(4 * 0.001 / std::sqrt(1.25)));
  CHECK(agree.gyro_sensitivity.sigma(0, 1) == 0);  // held fixed by all
  CHECK(agree.imu_delay.value == 0.0015);
  // Two runs ten of their standard deviations apart: the standard error of their mean.
  const auto differ = experiment::combine({run(0.010, 0.0002), run(0.012, 0.0002)}, none);
  CHECK(differ.gyro_sensitivity.value(2, 2) == Approx(0.011));
  CHECK(differ.gyro_sensitivity.sigma(2, 2) == Approx(0.001));
  CHECK_THROWS_AS(experiment::combine({run(0.010, 0), run(0.012, 0)}, none), DataError);  // fixed, not at one value
  CHECK_THROWS_AS(experiment::combine({run(0.3, 0.001)}, none), DataError);
  // What one of them has held fixed is that of the other.
  const auto one = experiment::combine({run(0, 0), run(0.012, 0.001)}, none);
  CHECK(one.gyro_sensitivity.value(1, 1) == Approx(0.012));
  CHECK(one.gyro_sensitivity.sigma(1, 1) == Approx(4 * 0.001));
}

TEST_CASE("calibrate: what tells nothing, or not of one sensor, is refused with a reason") {
  const Runs runs;
  const std::string good = runs.add("good", {}), lost = runs.add("lost", {.status = "diverged"}),
                    other = runs.add("other", {.sensor = "min_range: 1.25\n"});
  const auto refusal = [&](const std::vector<std::string>& arguments, int code) {
    const Ended ended = runs.calibrate(arguments);
    CHECK(ended.code == code);
    CHECK_FALSE(std::filesystem::exists(runs / "new.yaml"));
    return ended.err;
  };
  CHECK_THAT(refusal({lost}, 3), Contains("lost: the run ended diverged"));
  const std::string differs = refusal({good, other}, 3);
  CHECK_THAT(differs, Contains("not of one sensor"));
  CHECK_THAT(differs, Contains("min_range"));
  CHECK_THAT(refusal({runs / "nothing"}, 3), Contains("name the folder of a run"));
  const std::string nothing = runs.add("blind", {});
  write_text(runs / "blind/summary.json", R"({"status": "ok", "calibration": null})");
  CHECK_THAT(refusal({nothing}, 3), Contains("gyro_calibration: full"));
  write_text(runs / "good/manifest.json", with_input("a walk", ""));
  write_text(runs / "other/manifest.json", with_input("a walk", "gyro_sensitivity: [0.001, 0, 0, 0, 0, 0, 0, 0, 0]\n"));
  CHECK_THAT(refusal({good, other}, 3), Contains("good and ") && Contains("other are runs of the same recording"));
  write_text(runs / "other/manifest.json", with_input("another", "wheels: 4\n"));
  CHECK_THAT(refusal({good, other}, 3), Contains("other/manifest.json (sensor)") && Contains("wheels"));
  write_text(runs / "blind/manifest.json", "{}");
  CHECK_THAT(refusal({nothing}, 3), Contains("no sensor file in it"));
  write_text(runs / "new.yaml", "schema: aslio/sensor/1\n# a remark\n");
  const Ended ended = runs.calibrate({good});
  CHECK(ended.code == 2);
  CHECK_THAT(ended.err, Contains("was not written by this command"));
  CHECK_THAT(content(runs / "new.yaml"), Contains("a remark"));
}

TEST_CASE("calibrate: cross-axis terms that a run holds fixed stay those of its sensor file") {
  const Runs runs;
  const std::string run = runs.add("run", {.S = {0.01, 0, 0, 0, 0, 0, 0, 0, 0},
                                           .diagonal = true,
                                           .sensor = "gyro_sensitivity: [0, 0.003, 0, 0, 0, 0, 0, 0, 0]\n"});
  const Ended ended = runs.calibrate({run});
  REQUIRE(ended.code == 0);
  CHECK(read_sensor(runs / "new.yaml").gyro_sensitivity(0, 1) == Approx(0.003).epsilon(0.02));
  CHECK_THAT(ended.out, Contains("=[0.0004,0.005,0.005,0.005,0.0004,"));  // fixed: as good as any IMU
}

TEST_CASE(
    "calibrate: over the sensor file of a run the next one finds little left to learn, and one that learns nothing is "
    "served") {
  const TemporaryFolder folder;
  write_text(folder / "room.obj",
             "v -6 -6 0\nv 6 -6 0\nv 6 6 0\nv -6 6 0\nv -6 -6 3\nv 6 -6 3\nv 6 6 3\nv -6 6 3\n"
             "f 1 2 3 4\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n");
  write_text(folder / "room.yaml",
             "schema: aslio/scene/1\n"
             "world: {type: mesh, file: room.obj}\n"
             "route: [{x: -3, y: -3}, {x: 3, y: -3}, {x: 3, y: 3}, {x: -3, y: 3}, {x: -3, y: -2}]\n"
             "imu: {preset: datasheet}\n"
             "walk: {speed: 2, corner_speed: 1.5, standstill: 1}\n");
  REQUIRE(run_aslio({"simulate", folder / "room.yaml", "--output", folder / "data", "--quiet"}).code == 0);
  const auto run = [&](const std::string& output, const std::vector<std::string>& more) {
    std::vector<std::string> arguments = {"run",       ASLIO_SOURCE_DIR "/configs/pipelines/as_lio_plus.yaml",
                                          "--dataset", folder / "data",
                                          "--output",  folder / output};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Ended ended = run_aslio(arguments);
    INFO(ended.err);
    REQUIRE((ended.code == 0 || ended.code == 4));  // in a bare room some views are degenerate
    return Json::parse(content(folder / output / "summary.json"));
  };
  const std::vector<std::string> new_sensor = {"--sensor", folder / "new.yaml"},
                                 learns_nothing = {"--set", "estimator.gyro_calibration=none", "--set",
                                                   "estimator.time_offset=false"};
  const Json first = run("first", {}), blind = run("blind", learns_nothing);
  REQUIRE(run_aslio({"calibrate", folder / "first", "--output", folder / "new.yaml"}).code == 0);
  const Json second = run("second", new_sensor);
  std::vector<std::string> both = new_sensor;
  both.insert(both.end(), learns_nothing.begin(), learns_nothing.end());
  const Json served = run("served", both);
  const auto learnt = [](const Json& summary, const char* key) {
    return std::abs(summary["calibration"][key].get<double>());
  };
  const auto about_z = [](const Json& summary) {
    return std::abs(summary["calibration"]["gyro_sensitivity"][8].get<double>());
  };
  const auto ate = [](const Json& summary) { return summary["metrics"]["ate_m"].get<double>(); };
  CAPTURE(about_z(first), about_z(second), learnt(first, "imu_delay_s"), learnt(second, "imu_delay_s"));
  CAPTURE(ate(first), ate(second), ate(blind), ate(served));
  CHECK(about_z(second) < 0.2 * about_z(first));
  CHECK(learnt(second, "imu_delay_s") < 0.2 * learnt(first, "imu_delay_s"));
  CHECK(ate(served) < 0.5 * ate(blind));
  CHECK_THAT(second.dump(),
             Contains("gyro_sensitivity of the sensor file") && Contains("imu_delay of the sensor file"));
}
