// eq. FRM-6.
#include <fmt/format.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "aslio/core/angles.hpp"
#include "aslio/experiment/frame_check.hpp"
#include "aslio/experiment/truth.hpp"

using namespace aslio;
using experiment::FindingKind;
using experiment::FrameCheck;
using experiment::FrameMeasurement;

namespace {

constexpr double kSigmaTurn = 0.02 * kRadPerDeg, kSigmaShift = 0.003;

/// Fits that agree with a sensor file of the identity.
FrameMeasurement agreeing() {
  FrameMeasurement m;
  m.motion.sweep_period = 0.1;
  m.gyro_lidar.turns = 300;
  m.gyro_lidar.covariance = kSigmaTurn * kSigmaTurn * Mat3::Identity();
  m.gyro_lidar.delay = 0.002;  // of a filter
  m.gyro_lidar.sigma_delay = 0.0002;
  m.gyro_lidar.correlation = 0.99;
  m.force_lidar.pieces = 30;
  m.force_lidar.sigma_scale = Vec3::Constant(0.05);
  m.force_lidar.covariance = kSigmaShift * kSigmaShift * Mat3::Identity();
  m.rest.seconds = 3;
  m.rest.mean = Vec3(0, 0.1, 9.8);
  return m;
}

FrameCheck judged(FrameMeasurement m, const io::SensorConfig& sensor = {},
                  const std::vector<experiment::PublishedExtrinsic>& published = {}) {
  return experiment::judge_frames(std::move(m), sensor, nullptr, published);
}

/// The only contradiction there is.
experiment::Finding contradiction(const FrameCheck& check) {
  std::vector<experiment::Finding> found;
  for (const auto& f : check.findings) {
    if (f.kind == FindingKind::contradicts) found.push_back(f);
  }
  INFO(experiment::render(check));
  REQUIRE(found.size() == 1);
  CHECK(check.contradicts());
  return found.front();
}

}  // namespace

TEST_CASE("fits that agree with the files raise no alarm") {
  const FrameCheck check = judged(agreeing());
  INFO(experiment::render(check));
  CHECK_FALSE(check.contradicts());
  CHECK_THAT(experiment::render(check), Catch::Contains("nothing contradicts the files"));
  CHECK_THAT(experiment::render(check), Catch::Contains("open   reference: there is none"));
}

TEST_CASE("a delay of a sweep is the stamp at its end") {
  FrameMeasurement m = agreeing();
  m.gyro_lidar.delay = -0.0984;
  const auto found = contradiction(judged(m));
  CHECK(found.key == "lidar_stamp");
  CHECK(found.value == "end");
  CHECK_THAT(found.text, Catch::Contains("late by 98.4 +- 0.4 ms"));
}

TEST_CASE("a delay of half a sweep is the stamp in its middle") {
  FrameMeasurement m = agreeing();
  m.gyro_lidar.delay = -0.0485;
  CHECK(contradiction(judged(m)).value == "middle");
}

TEST_CASE("a file that takes the start for the end is told so") {
  FrameMeasurement m = agreeing();
  m.gyro_lidar.delay = 0.102;
  io::SensorConfig sensor;
  sensor.times.lidar_stamp = io::LidarStamp::end;
  const auto found = contradiction(judged(m, sensor));
  CHECK(found.key == "lidar_stamp");
  CHECK(found.value == "start");
}

TEST_CASE("another delay is an offset of the IMU's clock, on top of the one that is set") {
  FrameMeasurement m = agreeing();
  m.gyro_lidar.delay = 0.007;
  io::SensorConfig sensor;
  sensor.times.imu_time_offset = 0.02;
  const auto found = contradiction(judged(m, sensor));
  CHECK(found.key == "imu_time_offset");
  CHECK(found.value == "0.0130");
}

TEST_CASE("a reversed axis names the key with all its signs") {
  FrameMeasurement m = agreeing();
  m.gyro_lidar.signs = Vec3(1, -1, 1);
  io::SensorConfig sensor;
  sensor.gyro_signs = {-1, 1, 1};
  const auto gyro = contradiction(judged(m, sensor));
  CHECK(gyro.key == "gyro_signs");
  CHECK(gyro.value == "[-1, -1, 1]");
  m = agreeing();
  m.force_lidar.signs = Vec3(1, 1, -1);
  const auto acc = contradiction(judged(m));
  CHECK(acc.key == "acc_signs");
  CHECK(acc.value == "[1, 1, -1]");
}

TEST_CASE(
    "two reversed axes of gyro and accelerometer, or of a gyro that a reference finds right, are a turned LiDAR") {
  FrameMeasurement m = agreeing();
  m.gyro_lidar.signs = Vec3(1, -1, -1);
  m.gyro_lidar.R_A_B = exp_so3(Vec3(0, 0, 0.3));
  // Of the gyro alone they may be its own.
  CHECK(judged(m).findings.front().key == "gyro_signs");
  m.force_lidar.signs = Vec3(1, -1, -1);
  const auto by_force = contradiction(judged(m));
  CHECK(by_force.key == "T_imu_lidar");
  CHECK_THAT(by_force.text, Catch::Contains("off by 180 deg: the files have none"));
  m.force_lidar.signs = Vec3(1, 1, 1);
  m.has_reference = m.reference_has_rotation = true;
  m.gyro_reference.turns = 100;
  m.gyro_reference.covariance = m.gyro_lidar.covariance;
  m.lidar_reference.problem = m.force_reference.problem = "not looked at";
  const Mat3 R = Vec3(1, -1, -1).asDiagonal() * m.gyro_lidar.R_A_B.transpose();
  const experiment::Truth truth;
  const FrameCheck check = experiment::judge_frames(m, io::SensorConfig{}, &truth, {});
  const auto by_reference = contradiction(check);
  CHECK(by_reference.key == "T_imu_lidar");
  CHECK_THAT(by_reference.value, Catch::Contains(fmt::format("{:.4f}", R(0, 1)).substr(0, 5)));
  // No figure of a fit with a wrong rotation is given.
  CHECK_THAT(experiment::render(check), !Catch::Contains("measured"));
}

TEST_CASE("a delay of the IMU's filter that a reference sees, too, is no offset of the LiDAR's clock") {
  FrameMeasurement m = agreeing();
  m.gyro_lidar.delay = 0.0036;
  m.has_reference = m.reference_has_rotation = true;
  m.gyro_reference.turns = 100;
  m.gyro_reference.covariance = m.gyro_lidar.covariance;
  m.gyro_reference.delay = 0.002;
  m.gyro_reference.sigma_delay = 0.0002;
  m.lidar_reference.problem = m.force_reference.problem = "not looked at";
  const experiment::Truth truth;
  const FrameCheck right = experiment::judge_frames(m, io::SensorConfig{}, &truth, {});
  INFO(experiment::render(right));
  CHECK_FALSE(right.contradicts());
  CHECK_THAT(experiment::render(right), Catch::Contains("early by 3.6") && Catch::Contains("early by 1.6"));
  m.gyro_lidar.delay = 0.007;
  CHECK(experiment::judge_frames(m, io::SensorConfig{}, &truth, {}).contradicts());
}

TEST_CASE("a rotation is wrong when it is beyond what the axes of a gyro may be off") {
  FrameMeasurement m = agreeing();
  m.gyro_lidar.R_A_B = exp_so3(Vec3(0, 0, 0.2 * kRadPerDeg));
  CHECK_FALSE(judged(m).contradicts());
  m.gyro_lidar.R_A_B = exp_so3(Vec3(0, 0, 0.6 * kRadPerDeg));
  const auto found = contradiction(judged(m));
  CHECK(found.key == "T_imu_lidar");
  CHECK_THAT(found.text, Catch::Contains("0.60 +- 0.12 deg"));
  io::SensorConfig calibrated;
  calibrated.gyro_sensitivity(0, 0) = 0.001;
  m.gyro_lidar.R_A_B = exp_so3(Vec3(0, 0, 0.3 * kRadPerDeg));
  CHECK(judged(m, calibrated).contradicts());
}

TEST_CASE("a lever arm of 8 cm is wrong by specific force alone, and the file gets the measured one") {
  FrameMeasurement m = agreeing();
  m.force_lidar.lever = Vec3(0, 0.03, 0);
  CHECK_FALSE(judged(m).contradicts());  // single sweeps lean with the swing of the sensor: 15 mm
  m.force_lidar.lever = Vec3(0, 0.08, 0);
  const auto found = contradiction(judged(m));
  CHECK(found.key == "T_imu_lidar");
  CHECK_THAT(found.text, Catch::Contains("80 +- 15 mm"));
  CHECK_THAT(found.value, Catch::StartsWith("{translation: [0.0000, 0.0800, 0.0000]"));
}

TEST_CASE("what the data do not bind is open, not right") {
  FrameMeasurement m = agreeing();
  m.force_lidar.covariance(2, 2) = 4.0;
  m.force_lidar.lever = Vec3(0, 0, 1.5);
  m.gyro_lidar.covariance(0, 0) = 0.01;
  m.gyro_lidar.R_A_B = exp_so3(Vec3(0.05, 0, 0));
  const FrameCheck check = judged(m);
  const std::string text = experiment::render(check);
  INFO(text);
  CHECK_FALSE(check.contradicts());
  CHECK_THAT(text, Catch::Contains("lever arm along z: too little turn to tell"));
  CHECK_THAT(text, Catch::Contains("rotation about x: too little turn to tell"));
}

TEST_CASE("gravity that is missing, or in g, is named") {
  FrameMeasurement m = agreeing();
  m.rest.mean = Vec3(0.01, 0, 0.02);
  CHECK_THAT(contradiction(judged(m)).text, Catch::Contains("gravity has been taken out"));
  m.rest.mean = Vec3(0, 0, 1.0);
  CHECK(contradiction(judged(m)).key == "acc_unit");
}

TEST_CASE("the published extrinsic that fits is named") {
  const Pose near{Mat3::Identity(), Vec3(0.001, 0, 0)}, far{Mat3::Identity(), Vec3(0.134, 0, 0)};
  const FrameCheck check = judged(agreeing(), {}, {{"metadata", near}, {"a paper", far}});
  CHECK(check.published_verdict == "metadata alone fits");
  REQUIRE(check.published.size() == 2);
  CHECK(check.published[1].shift == Approx(0.134));
  CHECK(check.published[1].shift_sigmas == Approx(8.76).margin(0.05));
  const Pose also{Mat3::Identity(), Vec3(0, 0.004, 0)};
  CHECK_THAT(judged(agreeing(), {}, {{"metadata", near}, {"a paper", also}}).published_verdict,
             Catch::StartsWith("the data cannot tell these apart: metadata, a paper"));
  CHECK(judged(agreeing(), {}, {{"a paper", far}}).published_verdict == "none of them fits");
}

TEST_CASE("without a motion nothing is wrong, and the reason stands there") {
  FrameMeasurement m = agreeing();
  m.gyro_lidar = {};
  m.gyro_lidar.problem = "it hardly turns: 0.001 rad/s RMS";
  m.force_lidar = {};
  m.force_lidar.problem = "the rotation to the gyro is not known";
  const FrameCheck check = judged(m, {}, {{"a paper", Pose{}}});
  CHECK_FALSE(check.contradicts());
  CHECK_THAT(experiment::render(check), Catch::Contains("open   LiDAR against gyro: it hardly turns"));
  CHECK_THAT(check.published_verdict, Catch::Contains("no published extrinsic can be judged"));
  m.gyro_lidar.unlike = true;
  CHECK_FALSE(judged(m).contradicts());  // the registration may have failed
  m.gyro_lidar.ratio = kDegPerRad;
  CHECK(contradiction(judged(m)).value == "deg_s");
  m.gyro_lidar.ratio = 1;
  m.gyro_reference.unlike = true;
  CHECK(judged(m).contradicts());
}

TEST_CASE("the JSON of a check has findings with their keys") {
  FrameMeasurement m = agreeing();
  m.gyro_lidar.delay = -0.0984;
  const auto json = nlohmann::json::parse(experiment::to_json(judged(m)));
  CHECK(json["contradicts"] == true);
  const auto& findings = json["findings"];
  CHECK(
      std::any_of(findings.begin(), findings.end(), [](const auto& f) { return f.value("key", "") == "lidar_stamp"; }));
  CHECK(json["lidar_against_gyro"]["delay_s"] == Approx(-0.0984));
}
