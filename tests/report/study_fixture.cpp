#include "study_fixture.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <numbers>
#include <vector>

#include "aslio/io/writers.hpp"

namespace aslio::test {

namespace {

namespace fs = std::filesystem;

constexpr TimeNs kBegin = 1'700'000'000 * kSecond;
constexpr double kRadius = 5, kPeriod = 60;
constexpr double kLoop = 60, kTurn = 45;  // [s] of the recordings

/// On the round at `t` seconds, with a position error that grows and sways.
StampedPose pose_at(double t, double error) {
  const double angle = 2 * std::numbers::pi * t / kPeriod;
  Pose T{Eigen::AngleAxisd(angle, Vec3::UnitZ()).toRotationMatrix(),
         {kRadius * std::cos(angle), kRadius * std::sin(angle), 1.4 + 0.2 * std::sin(3 * angle)}};
  T.p += error * Vec3(std::sin(5 * angle), std::cos(7 * angle), 0.3 * std::sin(angle));
  return {kBegin + to_ns(t), T};
}

std::vector<StampedPose> poses(double duration, double rate, double error) {
  std::vector<StampedPose> out;
  for (int i = 0; i <= static_cast<int>(duration * rate); ++i) out.push_back(pose_at(i / rate, error));
  return out;
}

std::string telemetry(double duration, double rate) {
  std::string text = "t_ns,status,sod,iterations,n_matches,eig_1,residual_rms_m,tracking,gyro_rms_rad_s,alarm\n";
  const auto out = std::back_inserter(text);
  for (int i = 0; i <= static_cast<int>(duration * rate); ++i) {
    const double t = i / rate;
    fmt::format_to(out, "{},{},{},{},{},{},{},{},{},{}\n", kBegin + to_ns(t),
                   i == 0        ? "initialising"
                   : i % 400 < 5 ? "degenerate"
                                 : "ok",
                   i == 0 ? "" : fmt::format("{:.4f}", 0.8 + 0.15 * std::sin(t)), 2 + i % 3, 900 + i % 50,
                   100 + 50 * std::cos(t), 0.02 + 0.001 * std::sin(9 * t), i >= 610 && i < 640 ? "lost" : "ok",
                   0.1 + 0.05 * std::sin(2 * t), i == 610 ? 1 : 0);
  }
  return text;
}

std::string timings(double duration, double rate) {
  std::string text = "t_ns,predict_s,associate_s,solve_s\n";
  for (int i = 0; i <= static_cast<int>(duration * rate); ++i) {
    text += fmt::format("{},{},{},{}\n", kBegin + to_ns(i / rate), 1e-4, 1.5e-3 + 1e-5 * (i % 7), 5e-4);
  }
  return text;
}

void write_run(const fs::path& folder, double duration, double rate, double error, const std::string& window) {
  fs::create_directories(folder);
  io::write_tum(folder / "trajectory.tum", poses(duration, rate, error));
  write_text(folder / "updates.csv", telemetry(duration, rate));
  write_text(folder / "timings.csv", timings(duration, rate));
  write_text(folder / "resolved.yaml", fmt::format("schema: aslio/pipeline/1\nwindow:\n{}samplers:\n  - type: voxel\n  "
                                                   "  leaf: 0.05\nmap: {{type: voxel_plane}}\n",
                                                   window));
  write_text(
      folder / "manifest.json",
      fmt::format("{{\"aslio\": \"0.1.0\", \"build\": {{\"flags\": \"-O3\"}}, \"input\": {{\"path\": \"{}.bag\"}}}}\n",
                  folder.parent_path().filename().string()));
  write_text(folder / "summary.json",
             R"({"status": "ok", "initialisation": "static start", "notes": ["imu rate: 200 Hz"], )"
             R"("calibration": {"text": "IMU delay 2.03 ms"}})"
             "\n");
}

void write_map(const fs::path& file, int points = 4000) {
  const auto writer = io::open_map_writer(file);
  for (int i = 0; i < points; ++i) {
    const double angle = 0.01 * i;
    writer->add(Eigen::Vector3d(8 * std::cos(angle), 8 * std::sin(angle), 0.001 * i).cast<float>(), 1);
  }
  writer->close();
}

}  // namespace

void write_text(const fs::path& path, const std::string& text) { std::ofstream(path, std::ios::binary) << text; }

void write_study(const fs::path& folder) {
  const std::string bad = kHostile, quoted = "\"<img src=x onerror=fail()>&\"\"'\"";
  const nlohmann::ordered_json study = {
      {"schema", "aslio/study_results/1"},
      {"name", "fixture"},
      {"question", std::string("Which is better? ") + kHostileText},
      {"prediction", "The second."},
      {"rule", "At most 0 of 45 runs. Lower median."},
      {"planned", 12},
      {"done", 11},
      {"metrics", {"ate_m", "ate_deg"}},
      {"methods",
       {{{"name", "fixed_10"}, {"label", "10 Hz, fixed"}, {"baseline", nullptr}},
        {{"name", "as_lio_plus"}, {"label", nullptr}, {"baseline", "fixed_10"}}}},
      {"expectation",
       {{"overall", "not decided"},
        {"rules",
         {{{"text", "it pays"}, {"verdict", "does not hold"}, {"open", ""}},
          {{"text", kHostileText}, {"verdict", "not decided"}, {"open", "1 run is missing"}}}}}},
      {"identical", nlohmann::ordered_json::array({"a and b do not differ"})}};
  // Names in another encoding are replaced, as `aslio experiment` does.
  write_text(folder / "study.json", study.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace));
  write_text(folder / "verdict.md", fmt::format("# Verdict: fixture\n\n- lower median: **holds**\n- {}: **not "
                                                "decided**\n\n| a | b |\n|---|---|\n| 1 | `2` |\n",
                                                kHostileText));
  std::string csv = "data,sequence,seed,order_seed,method,status,reason,ate_m,ate_deg,rate_hz,cpu_s_per_s\n";
  for (const char* data : {"loop_1", "loop_2", "turn_1", "turn_2"}) {
    const std::string name = data, sequence = name.substr(0, 4), seed = name.substr(5);
    const double extra = seed == "2" ? 0.01 : 0, duration = sequence == "loop" ? kLoop : kTurn;
    fs::create_directories(folder / "data" / name);
    io::write_tum(folder / "data" / name / "truth.tum", poses(duration, 200, 0));
    write_text(folder / "data" / name / "overlap.csv",
               "t,static_rays,true_overlap\n1700000001.0,9,0.5\n1700000030.0,9,0.9\n1700000059.0,9,0.4\n");
    csv += fmt::format("{},{},{},0,fixed_10,ok,,{},0.2,10,0.05\n", name, sequence, seed, 0.05 + extra);
    csv += fmt::format("{},{},{},0,as_lio_plus,degraded,few points,{},0.1,20,0.08\n", name, sequence, seed,
                       (sequence == "loop" ? 0.02 : 0.09) + extra);
    write_run(folder / "runs" / name / "fixed_10", duration, 10, 0.05 + extra, "  type: fixed\n  period: 0.1\n");
    write_run(folder / "runs" / name / "as_lio_plus", duration, 20, 0.02 + extra,
              "  type: sod_adaptive\n  seg_step: 0.05\n");
  }
  write_map(folder / "runs/loop_1/as_lio_plus/map.ply");
  csv += fmt::format("loop_1,loop,1,0,{},ok,,0.4,0.5,10,0.2\n", quoted);
  csv += fmt::format("loop_2,loop,2,0,{},diverged,\"off by 9 m, {}\",9,0.5,10,0.2\n", quoted, "</script>");
  csv += fmt::format("turn_1,turn,1,0,{},crashed,=cmd(),,,,\n", quoted);
  write_run(folder / "runs/loop_1" / bad, kLoop, 10, 0.4, "  type: fixed\n  period: 0.1\n");
  write_run(folder / "runs/loop_2" / bad, kLoop, 10, 2, "  type: fixed\n  period: 0.1\n");
  write_text(folder / "results.csv", csv);
  write_text(
      folder / "statistics.csv",
      "metric,sequence,method,baseline,low,high,effect,p,p_holm,p_sequences\nate_m,loop,as_lio_plus,,0.02,0.03,,,,\n"
      "ate_m,,as_lio_plus,fixed_10,0.4,inf,-0.5,0.0004,0.125,0.25\n");
}

void write_long_study(const fs::path& folder) {
  constexpr double kDuration = 500;
  write_text(
      folder / "study.json",
      R"({"schema": "aslio/study_results/1", "name": "long", "question": "Does it load?", "prediction": "Yes.", )"
      R"("rule": "In time.", "planned": 20, "done": 20, "metrics": ["ate_m"]})");
  std::string csv = "data,sequence,seed,order_seed,method,status,reason,ate_m,ate_deg,rate_hz,cpu_s_per_s\n";
  for (const char* data : {"way_1", "way_2"}) {
    fs::create_directories(folder / "data" / data);
    io::write_tum(folder / "data" / data / "truth.tum", poses(kDuration, 200, 0));
    for (int m = 0; m < 10; ++m) {
      const std::string method = fmt::format("m{}", m);
      csv += fmt::format("{},way,{},0,{},ok,,{},0.1,20,0.05\n", data, data[4], method, 0.01 * (m + 1));
      write_run(folder / "runs" / data / method, kDuration, 20, 0.01 * (m + 1), "  type: fixed\n  period: 0.05\n");
      write_map(folder / "runs" / data / method / "map.ply", 200'000);
    }
  }
  write_text(folder / "results.csv", csv);
  write_text(folder / "statistics.csv", "metric,sequence,method,baseline,low,high,effect,p,p_holm\n");
}

}  // namespace aslio::test
