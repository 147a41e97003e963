/// What a run has learnt of its IMU, as its summary tells it.

#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <limits>
#include <nlohmann/json.hpp>

#include "aslio/experiment/calibration.hpp"
#include "aslio/experiment/summary.hpp"

using namespace aslio;
using experiment::Calibration;
using experiment::calibration_of;
using Json = nlohmann::json;

namespace {

/// Accepted, of an estimator that estimates all of it. No two numbers are the same.
Update learnt() {
  Update update;
  update.accepted = true;
  update.state.t = 17;
  update.state.b_w = Vec3(0.01, 0.02, 0.03);
  update.state.b_a = Vec3(0.1, 0.2, 0.3);
  update.state.S_w << 0.0062, 0.0011, 0.0012,  //
      -0.0041, -0.0031, 0.0013,                //
      0.0014, 0.0015, 0.0088;
  update.state.imu_delay = 0.00203;
  for (int i = block::b_w; i < kStateDim; ++i) update.P(i, i) = 1e-6 * (i + 1) * (i + 1);
  return update;
}

Json summary_of(const std::optional<Calibration>& calibration) {
  experiment::Summary summary;
  summary.calibration = calibration;
  return Json::parse(experiment::to_json(summary))["calibration"];
}

void clear(Update& update, int at, int count) { update.P.diagonal().segment(at, count).setZero(); }

}  // namespace

TEST_CASE("calibration: the summary tells every part, S row by row") {
  const Json out = summary_of(calibration_of(learnt()));
  CHECK(out["t_ns"] == 17);
  CHECK(out["text"] == to_text(calibration_of(learnt()).value()));
  CHECK(out["gyro_bias_rad_s"] == Json({0.01, 0.02, 0.03}));
  CHECK(out["acc_bias_mps2"] == Json({0.1, 0.2, 0.3}));
  CHECK(out["gyro_sensitivity"] == Json({0.0062, 0.0011, 0.0012, -0.0041, -0.0031, 0.0013, 0.0014, 0.0015, 0.0088}));
  CHECK(out["imu_delay_s"] == 0.00203);
  const auto sigma = [&](const char* key, std::size_t i) { return out[key][i].get<double>(); };
  CHECK(sigma("gyro_bias_sigma_rad_s", 0) == Approx(1e-3 * (block::b_w + 1)));
  CHECK(sigma("acc_bias_sigma_mps2", 2) == Approx(1e-3 * (block::b_a + 3)));
  CHECK(sigma("gyro_sensitivity_sigma", 1) == Approx(1e-3 * (block::s + 4)));  // row 0, column 1: of a state by columns
  CHECK(sigma("gyro_sensitivity_sigma", 3) == Approx(1e-3 * (block::s + 2)));
  CHECK(out["imu_delay_sigma_s"].get<double>() == Approx(1e-3 * (block::d + 1)));
}

TEST_CASE("calibration: what is not estimated is null, and all of it where nothing is") {
  Update update = learnt();
  clear(update, block::s, 9);
  Json out = summary_of(calibration_of(update));
  CHECK(out["gyro_sensitivity"].is_null());
  CHECK(out["gyro_sensitivity_sigma"].is_null());
  CHECK(out["imu_delay_s"] == 0.00203);
  clear(update, block::d, 1);
  out = summary_of(calibration_of(update));
  CHECK(out["imu_delay_s"].is_null());
  CHECK(out["gyro_bias_rad_s"].is_array());
  clear(update, block::b_w, 6);
  CHECK(summary_of(calibration_of(update)).is_null());
}

TEST_CASE("calibration: of updates that are accepted and finite, and go on from what was known") {
  Update refused = learnt(), not_finite = learnt();
  refused.accepted = false;
  not_finite.state.S_w(1, 2) = std::numeric_limits<double>::quiet_NaN();
  Update begun_anew = learnt();  // a start in motion that finds its velocity: P is that of the start again
  begun_anew.restart_map = true;
  CHECK_FALSE(calibration_of(begun_anew).has_value());
  CHECK_FALSE(calibration_of(refused).has_value());
  CHECK_FALSE(calibration_of(not_finite).has_value());
  Update no_claim = learnt();
  no_claim.P(block::d, block::d) = std::numeric_limits<double>::quiet_NaN();
  CHECK_FALSE(calibration_of(no_claim).has_value());
}

TEST_CASE("calibration: in words, with what is claimed to be known") {
  const auto words = [](const Update& update) { return to_text(calibration_of(update).value()); };
  Update update = learnt();
  const std::string scale = "gyro scale +0.62 +- 1.90, -0.31 +- 2.30, +0.88 +- 2.70 %";
  CHECK(words(update) == scale + ", cross-axis up to 0.41 +- 2.00 %, IMU delay 2.03 +- 28.00 ms");
  for (const int k : {1, 2, 3, 5, 6, 7}) clear(update, block::s + k, 1);  // gyro_calibration: diagonal
  CHECK(words(update) == scale + ", IMU delay 2.03 +- 28.00 ms");
  const Json S = summary_of(calibration_of(update))["gyro_sensitivity"];
  CHECK(S[0] == 0.0062);
  CHECK(S[1].is_null());
  CHECK(S[8] == 0.0088);
  clear(update, block::s, 9);
  CHECK(words(update) == "IMU delay 2.03 +- 28.00 ms");
  clear(update, block::d, 1);
  CHECK(words(update).empty());
}

TEST_CASE("calibration: the last accepted update of a run tells it") {
  experiment::SummaryCollector collector;
  const auto next = [&](const Update& update, TimeNs end,
                        pipeline::TrackingStatus tracking = pipeline::TrackingStatus::ok) {
    pipeline::UpdateRecord record;
    record.plan.fresh_begin = end - kSecond;
    record.plan.end = end;
    record.status = update.accepted ? UpdateStatus::ok : UpdateStatus::few_matches;
    record.tracking = tracking;
    record.state = update.state;
    record.update = &update;
    collector.on_update(record);
  };
  Update update = learnt();
  next(update, 1 * kSecond);
  update.state.imu_delay = 0.004;
  next(update, 2 * kSecond);
  update.state.imu_delay = 0.1;
  next(update, 3 * kSecond, pipeline::TrackingStatus::lost);
  update.accepted = false;
  next(update, 4 * kSecond);
  experiment::Summary summary;
  collector.fill(summary, stream::MeasurementStream{}, std::nullopt, kSecond);
  REQUIRE(summary.calibration.has_value());
  CHECK(summary.calibration->imu_delay->value == 0.004);
}
