// Faults 1 to 20: the IMU.
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "faults/table.hpp"

namespace aslio::test::faults {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN(), kInf = std::numeric_limits<double>::infinity();
constexpr double kAt = 6;  ///< [s] in the middle of the walk

std::function<Outcome()> with(Fault fault, How how = {}) {
  return [fault = std::move(fault), how = std::move(how)] { return run_with(fault, how); };
}

Fault set_imu(Span span, const Vec3& gyro, const Vec3& acc) {
  return alter_imu(span, [=](ImuSample& sample, std::size_t) {
    sample.gyro = gyro;
    sample.acc = acc;
  });
}

/// Where the last segment of a run ends, and whether there was more than one.
void check_begun_again(const Outcome& o) {
  const auto segments = o.updates.find("segment");
  REQUIRE(segments != o.updates.end());
  REQUIRE_FALSE(segments->second.empty());
  CHECK(segments->second.back() == "1");
  CHECK(o.tracking.back() == "ok");
}

/// What the run has learnt of the gyro's bias about the vertical axis, beyond what the clean one has [rad/s].
double learnt_bias(const Outcome& o) {
  const auto bias = [](const Outcome& run) {
    return run.summary.at("calibration").at("gyro_bias_rad_s").at(2).get<double>();
  };
  return bias(o) - bias(run_clean());
}

std::vector<Row> readings() {
  std::vector<Row> rows;
  rows.push_back(
      {.number = 1,
       .name = "nan_gyro_single",
       .injected = "one gyro sample is not a number",
       .expected = {.status = {"ok"}, .counters = {{"imu_invalid", 1}}, .ate_times = 1.01, .ate_plus = 0.001},
       .run = with(alter_imu({kAt, 0.005}, [](ImuSample& s, std::size_t) { s.gyro.y() = kNaN; }))});
  rows.push_back(
      {.number = 2,
       .name = "inf_accel_burst_20",
       .injected = "20 samples in a row with infinite acceleration",
       // In a sharp turn (5.5 and 6 s) it costs 4.4 and 5.6 mm, at eight other moments 1.4 to 2.5 mm, of all.
       .expected = {.status = {"degraded"}, .counters = {{"imu_invalid", 20}}, .ate_times = 1.1, .ate_plus = 0.006},
       .run = with(alter_imu({kAt, 0.1}, [](ImuSample& s, std::size_t) { s.acc.x() = kInf; }))});
  rows.push_back({.number = 3,
                  .name = "imu_all_zero",
                  .injected = "all readings are zero from 6 s on",
                  .expected = {.status = {"degraded", "diverged"}, .ate_plus = 0.1, .says = {"IMU"}},
                  .run = with(set_imu({kAt}, Vec3::Zero(), Vec3::Zero())),
                  .also = "noticed within 0.5 s",
                  .check = [](const Outcome& o) { check_noticed(o, kAt, 0.5); }});
  rows.push_back({.number = 4,
                  .name = "imu_stuck_value",
                  .injected = "the reading at 6 s is repeated from then on",
                  .expected = {.status = {"degraded", "diverged"}, .ate_plus = 0.1, .says = {"IMU"}},
                  .run = with(freeze_imu({kAt})),
                  .also = "noticed within 1 s",
                  .check = [](const Outcome& o) { check_noticed(o, kAt, 1.0); }});
  rows.push_back({.number = 12,
                  .name = "imu_gyro_saturated",
                  .injected = "the gyro is clipped at 2 rad/s, which the sensor file declares as `gyro_range`",
                  .expected = {.status = {"degraded"}, .ate_plus = 0.1},
                  .run = with(clip_imu({}, 2.0, kInf), {.sensor_lines = {"gyro_range: 2.0"}})});
  rows.push_back({.number = 13,
                  .name = "imu_accel_clipped_vibration",
                  .injected = "the accelerometer is clipped at 11 m/s^2, which the sensor file declares as `acc_range`",
                  .expected = {.status = {"degraded"}, .ate_plus = 0.1},
                  .run = with(clip_imu({}, kInf, 11.0), {.sensor_lines = {"acc_range: 11.0"}})});
  rows.push_back({.number = 14,
                  .name = "imu_bias_step",
                  .injected = "the gyro's bias about the vertical steps by 0.02 rad/s at 6 s",
                  .expected = {.status = {"ok", "degraded"}, .ate_times = 2, .ate_plus = 0.02},
                  .run = with(add_gyro_bias({kAt}, Vec3(0, 0, 0.02))),
                  .also = "the new bias is known to 0.004 rad/s at the end",
                  .check = [](const Outcome& o) { CHECK(std::abs(learnt_bias(o) - 0.02) < 0.004); },
                  .note = "the test checks the bias, because no output of a run holds the NEES."});
  return rows;
}

std::vector<Row> units_and_rates() {
  std::vector<Row> rows;
  rows.push_back({.number = 15,
                  .name = "imu_units_g_instead_of_mps2",
                  .injected = "acceleration in g, and the sensor file says m/s^2",
                  .expected = {.exit = {3}, .says = {"acc_unit", "9.80665"}},
                  .run = with([](Measurements&) {},
                              {.sensor_lines = {"acc_unit: mps2"}, .form = {.acc_factor = 1 / kStandardGravity}})});
  rows.push_back(
      {.number = 16,
       .name = "imu_units_deg_per_s",
       .injected = "turn rates in degrees per second, and the sensor file says rad/s",
       .expected = {.status = {"failed", "diverged", "degraded"}, .says = {"gyro_unit"}},
       .run = with([](Measurements&) {}, {.sensor_lines = {"gyro_unit: rad_s"}, .form = {.gyro_factor = 57.29578}})});
  rows.push_back({.number = 17,
                  .name = "imu_rate_halved",
                  .injected = "every second IMU sample is missing",
                  .expected = {.status = {"ok"}, .ate_times = 1.1, .ate_plus = 0.001},
                  .run = with(drop_imu({}, 2))});
  rows.push_back({.number = 18,
                  .name = "imu_rate_1kHz",
                  .injected = "1000 Hz by interpolation of the 200 Hz",
                  .expected = {.status = {"ok", "degraded"}, .ate_times = 1.1, .ate_plus = 0.001},
                  .run = with(multiply_imu_rate(5))});
  rows.push_back(
      {.number = 19,
       .name = "imu_jitter_5ms_stamps",
       .injected = "stamps of the IMU are off by 5 ms (one standard deviation), so that samples change their order",
       .expected = {.status = {"ok", "degraded"}, .ate_times = 1.1, .ate_plus = 0.005},
       .run = with(jitter_imu_stamps({}, 0.005, 101))});
  rows.push_back({.number = 20,
                  .name = "init_while_moving",
                  .injected = "the first 3 s are missing: the recording begins in a walk",
                  .expected = {.status = {"ok", "degraded"}, .ate_times = 2, .ate_plus = 0.02},
                  .run = with(keep({3})),
                  .also = "`initialisation` says \"dynamic start\"",
                  .check = [](const Outcome& o) {
                    CHECK_THAT(o.summary.at("initialisation").get<std::string>(),
                               Catch::Matchers::Contains("dynamic start"));
                  }});
  return rows;
}

std::vector<Row> stamps() {
  std::vector<Row> rows;
  rows.push_back({.number = 5,
                  .name = "imu_gap_50ms",
                  .injected = "50 ms without IMU data",
                  .expected = {.status = {"ok"}, .counters = {{"imu_gaps", 1}}, .ate_times = 1.1, .ate_plus = 0.002},
                  .run = with(drop_imu({kAt, 0.05}))});
  rows.push_back({.number = 6,
                  .name = "imu_gap_1s",
                  .injected = "1 s without IMU data",
                  .expected = {.status = {"degraded"},
                               .counters = {{"imu_gaps", 1}},
                               .ate_times = 2,
                               .ate_plus = 0.05,
                               .says = {"s without IMU data"}},
                  .run = with(drop_imu({kAt, 1.0})),
                  .also = "ok again within 2 s",
                  .check = [](const Outcome& o) { check_recovered(o, kAt + 1, 2.0); }});
  rows.push_back({.number = 7,
                  .name = "imu_gap_to_end",
                  .injected = "no IMU data from 5.5 s to the end, 6.5 s later",
                  .expected = {.status = {"diverged"}, .exit = {1}, .says = {"IMU"}},
                  .run = with(drop_imu({5.5})),
                  .also = "lost within `max_gap` (5 s) and one window",
                  .check = [](const Outcome& o) { check_lost(o, 5.5, 5.2); }});
  rows.push_back({.number = 8,
                  .name = "imu_duplicate_stamp",
                  .injected = "every IMU sample of 2 s comes twice",
                  .expected = {.status = {"ok"}, .counters = {{"imu_duplicate", 400}}},
                  .run = with(repeat_imu({kAt, 2})),
                  .also = "the clean trajectory, to the last byte",
                  .check = &check_same_as_clean});
  rows.push_back(
      {.number = 9,
       .name = "imu_out_of_order_1",
       .injected = "one IMU sample arrives after the next one",
       .expected = {.status = {"ok"}, .counters = {{"imu_reordered", 1}}, .ate_times = 1.01, .ate_plus = 0.001},
       .run = with(swap_imu({kAt, 0.01}))});
  rows.push_back({.number = 10,
                  .name = "imu_time_back_10s",
                  .injected = "both clocks jump back by 10 s at 6 s",
                  .expected = {.status = {"diverged"}, .exit = {1}, .says = {"clock"}},
                  .run = with(shift_stamps({kAt}, -10 * kSecond)),
                  .also = "a new segment that is tracked to the end",
                  .check = &check_begun_again,
                  .note =
                      "both clocks jump, as those of a host whose time is set. If the clock of the IMU jumps alone, "
                      "the two do not fit together. The run then ends with `failed` and the reason."});
  rows.push_back({.number = 11,
                  .name = "imu_time_forward_1h",
                  .injected = "both clocks jump forward by an hour at 6 s",
                  .expected = {.status = {"diverged"}, .exit = {1}, .says = {"clock"}},
                  .run = with(shift_stamps({kAt}, 3600 * kSecond)),
                  .also = "a new segment that is tracked to the end",
                  .check = &check_begun_again,
                  .note = "as row 10."});
  return rows;
}

}  // namespace

std::vector<Row> imu_rows() {
  std::vector<Row> rows = readings();
  for (auto* more : {&units_and_rates, &stamps}) {
    for (Row& row : more()) rows.push_back(std::move(row));
  }
  return rows;
}

}  // namespace aslio::test::faults
