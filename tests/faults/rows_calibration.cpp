// Faults 46 to 52: what the user wrote.
#include <catch2/catch.hpp>
#include <cmath>

#include "faults/table.hpp"

namespace aslio::test::faults {
namespace {

std::function<Outcome()> with_sensor(std::string line) {
  return [line = std::move(line)] { return run_with([](Measurements&) {}, {.sensor_lines = {line}}); };
}

/// configs/pipelines/as_lio_plus.yaml with one text in place of another, over half a second.
Outcome run_changed(const std::string& from, const std::string& to) {
  std::string text = content(ASLIO_SOURCE_DIR "/configs/pipelines/as_lio_plus.yaml");
  const std::size_t at = text.find(from);
  REQUIRE(at != std::string::npos);
  text.replace(at, from.size(), to);
  const TemporaryFolder folder;
  return run_with(keep({0, 0.5}), {.pipeline = folder.write("changed.yaml", text)});
}

/// Refused with the key, and the line it stands in.
void check_refused(const std::string& from, const std::string& to, const std::string& key) {
  CAPTURE(to);
  const Outcome o = run_changed(from, to);
  CHECK(o.exit_code == 2);
  CHECK_THAT(o.err, Catch::Matchers::Contains("changed.yaml:") && Catch::Matchers::Contains(key));
  CHECK(o.files.empty());
}

/// Every value of these columns of updates.csv is within the limits; an empty one counts as undefined.
void check_within(const Outcome& o, const std::string& name, double least, double most) {
  REQUIRE(o.updates.contains(name));
  for (const std::string& cell : o.updates.at(name)) {
    if (cell.empty()) continue;
    const double value = std::stod(cell);
    CHECK(std::isfinite(value));
    CHECK(value >= least);
    CHECK(value <= most);
  }
}

std::vector<Row> extrinsics() {
  std::vector<Row> rows;
  rows.push_back(
      {.number = 46,
       .name = "extrinsic_rot_90deg",
       .injected = "the sensor file turns the LiDAR by 90 deg about the vertical",
       .expected = {.status = {"diverged", "failed"}, .exit = {1}, .says = {"T_imu_lidar"}},
       .run = with_sensor(
           "T_imu_lidar: {translation: [-0.011, -0.02329, 0.04412], rotation: [0, -1, 0, 1, 0, 0, 0, 0, 1]}"),
       .also = "noticed within 5 s of the first step",
       .check = [](const Outcome& o) { check_noticed(o, 1, 5); }});
  rows.push_back(
      {.number = 47,
       .name = "extrinsic_not_orthonormal",
       .injected = "the rotation of the sensor file has a wrong digit",
       .expected = {.exit = {2}, .says = {"T_imu_lidar.rotation", "orthonormal"}},
       .run = with_sensor("T_imu_lidar: {translation: [0, 0, 0], rotation: [1, 0, 0, 0, 1, 0.1, 0, 0, 1]}")});
  rows.push_back(
      {.number = 48,
       .name = "extrinsic_trans_1m_off",
       .injected = "the sensor file puts the LiDAR 1 m to the left",
       .expected = {.status = {"degraded", "diverged", "failed"}, .says = {"T_imu_lidar"}},
       .run = with_sensor(
           "T_imu_lidar: {translation: [-0.011, 0.97671, 0.04412], rotation: [1, 0, 0, 0, 1, 0, 0, 0, 1]}")});
  return rows;
}

}  // namespace

std::vector<Row> calibration_rows() {
  std::vector<Row> rows = extrinsics();
  rows.push_back({.number = 49,
                  .name = "negative_or_zero_noise_voxel_frame_length_seg_step",
                  .injected = "`window.seg_step: 0`; and a voxel, a frame length and a noise of 0 or less",
                  .expected = {.exit = {2}, .says = {"changed.yaml:9:", "seg_step"}},
                  .run = [] { return run_changed("seg_step: 0.005", "seg_step: 0"); },
                  .also = "each is refused with its key",
                  .check =
                      [](const Outcome&) {
                        check_refused("frame_length: 0.1", "frame_length: -0.1", "frame_length");
                        check_refused("voxel: 0.5", "voxel: 0", "map.voxel");
                        check_refused("sigma: 0.02", "sigma: 0", "sigma");
                      }});
  rows.push_back({.number = 50,
                  .name = "unknown_yaml_key",
                  .injected = "`seg_stp` in place of `seg_step`",
                  .expected = {.exit = {2}, .says = {"unknown key 'window.seg_stp'", "did you mean 'seg_step'"}},
                  .run = [] { return run_changed("seg_step: 0.005", "seg_stp: 0.005"); }});
  rows.push_back({.number = 51,
                  .name = "nan_in_yaml",
                  .injected = "`sigma: .nan`",
                  .expected = {.exit = {2}, .says = {"sigma"}},
                  .run = [] { return run_changed("sigma: 0.02", "sigma: .nan"); },
                  .also = "so are `nan` and `.inf`",
                  .check =
                      [](const Outcome&) {
                        check_refused("sigma: 0.02", "sigma: nan", "sigma");
                        check_refused("sigma: 0.02", "sigma: .inf", "sigma");
                      }});
  rows.push_back(
      {.number = 52,
       .name = "overlap_denominator_zero",
       .injected = "0.5 s of messages without points",
       .expected = {.status = {"ok", "degraded"}, .counters = {{"empty_packets", 5}}, .ate_times = 2, .ate_plus = 0.01},
       .run =
           [] {
             return run_with(empty_packets({6, 0.5}));
           },
       .also = "the overlap is empty or within [0, 1], the advance of the window within [0, 0.1] s",
       .check =
           [](const Outcome& o) {
             check_within(o, "sod", 0, 1);
             check_within(o, "shift_time_s", 0, 0.1 + 1e-9);
           }});
  return rows;
}

}  // namespace aslio::test::faults
