#include <algorithm>
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "aslio/core/trajectory.hpp"
#include "aslio/io/source.hpp"
#include "aslio/io/writers.hpp"
#include "fixture.hpp"

using namespace aslio;
using namespace aslio::test;
using Catch::Matchers::Contains;
using Json = nlohmann::json;

namespace {

Json json(const std::filesystem::path& file) { return Json::parse(content(file)); }

}  // namespace

TEST_CASE("a run leaves its files, with the columns that are documented") {
  const Bench bench;
  const Ended ended = bench.run("out", {"--dense", "--save-map", bench / "map.ply"});
  INFO(ended.err);
  REQUIRE(ended.code == 0);
  CHECK_THAT(ended.out, Contains("status       ok"));
  const auto out = bench / "out";
  const std::string csv = content(out / "updates.csv");
  CHECK(csv.substr(0, csv.find('\n')) ==
        "t_ns,window_begin_ns,status,n_fresh,n_history,sod,layer_0,layer_1,layer_2,layer_3,layer_4,layer_5,layer_6,"
        "layer_7,seg_time,shift_time_s,echo,iterations,n_matches,eig_1,eig_2,eig_3,eig_4,eig_5,eig_6,digest,"
        "extended,partial,n_fresh_matches,n_history_matches,residual_rms_m,inserted,tracking,"
        "gyro_rms_rad_s,prior_x,prior_y,prior_z,prior_qx,prior_qy,prior_qz,prior_qw,segment,"
        "nis,matched_share,fit_rise,nis_rise,match_loss,overlap_loss,velocity_pull_mps2,turn_pull_rad_s,"
        "velocity_pull_rise,turn_pull_rise,misfit,gyro_mismatch,mount,view_change,view_jump,unexplained,alarm");
  const auto poses = io::read_tum(out / "trajectory.tum");
  const auto stamps = column(out / "updates.csv", "t_ns");
  REQUIRE(poses.size() == stamps.size());
  REQUIRE(poses.size() >= 15);
  for (std::size_t i = 0; i < poses.size(); ++i) CHECK(std::to_string(poses[i].t) == stamps[i]);
  CHECK(poses.front().T.p.norm() < 0.02);
  const auto sod = column(out / "updates.csv", "sod");
  CHECK(sod.front().empty());  // nothing to compare the first frame with
  CHECK(std::stod(sod.back()) > 0.3);
  CHECK(std::stod(sod.back()) <= 1.0);
  const auto eigenvalue = column(out / "updates.csv", "eig_1"), rms = column(out / "updates.csv", "residual_rms_m");
  CHECK(eigenvalue.front().empty());  // nothing was solved
  CHECK(rms.front().empty());
  CHECK(std::stod(eigenvalue.back()) > 0.0);
  CHECK(std::stod(rms.back()) > 0.0);
  CHECK(std::stoul(column(out / "updates.csv", "inserted").front()) > 0);
  CHECK(column(out / "updates.csv", "tracking").back() == "ok");
  const auto lidar = io::read_tum(out / "trajectory_lidar.tum");
  REQUIRE(lidar.size() == poses.size());
  CHECK((lidar[3].T.p - poses[3].T * Vec3(0.04165, 0.02326, -0.0284)).norm() < 1e-6);
  CHECK(io::read_tum(out / "trajectory_dense.tum").size() >= poses.size());
  CHECK(column(out / "timings.csv", "solve_s").size() == poses.size());
  const std::string map = content(bench / "map.ply");
  CHECK_THAT(map.substr(0, 200), Contains("element vertex"));
  CHECK(map.size() > 10000);
}

TEST_CASE("the window that starts the map is covered, whether its points enter at once or when they leave it") {
  const Bench bench;
  for (const std::string insertion : {"on_new", "on_exit"}) {
    CAPTURE(insertion);
    const Ended ended = bench.run(insertion, {"--set", "insertion={type: " + insertion + "}"});
    INFO(ended.err);
    REQUIRE(ended.code == 0);
    CHECK(json(bench / insertion / "summary.json").at("coverage").get<double>() > 0.99);
  }
}

TEST_CASE("a reference that goes on after the data is no silence of the run") {
  const Bench bench;
  write_truth(bench / "truth.tum");
  Trajectory longer(io::read_tum(bench / "truth.tum"));
  const StampedPose last = longer.samples().back();
  for (int k = 1; k <= 300; ++k) longer.append({last.t + k * kSecond / 100, last.T});
  io::write_tum(bench / "longer.tum", longer.samples());
  const Ended whole = bench.run("whole", {"--reference", bench / "longer.tum"});
  INFO(whole.err);
  REQUIRE(whole.code == 0);
  CHECK(json(bench / "whole/summary.json").at("metrics").at("failed_at").is_null());
  const Ended part = bench.run("part", {"--reference", bench / "longer.tum", "--duration", "1.25"});
  INFO(part.err);
  REQUIRE(part.code == 0);
  CHECK(json(bench / "part/summary.json").at("metrics").at("failed_at").is_null());
}

TEST_CASE("the summary tells what the run amounts to, the manifest what was run") {
  const Bench bench;
  write_truth(bench / "truth.tum");
  const Ended ended = bench.run("out", {"--reference", bench / "truth.tum", "--seed", "7", "--set", "max_speed=25"});
  INFO(ended.err);
  REQUIRE(ended.code == 0);
  const Json summary = json(bench / "out/summary.json");
  CHECK(summary.at("status") == "ok");
  CHECK(summary.at("coverage").get<double>() > 0.95);
  CHECK(summary.at("updates").get<std::size_t>() == line_count(bench / "out/trajectory.tum"));
  CHECK(summary.at("rate_hz").at("median").get<double>() == Approx(10.0).epsilon(0.05));
  CHECK(summary.at("data_s").get<double>() == Approx(2.0).epsilon(0.1));
  CHECK(summary.at("cpu_s").get<double>() > 0.0);
  CHECK(summary.at("peak_rss_mb").get<double>() > 1.0);
  CHECK(summary.at("counts").at("packets").get<int>() >= 19);
  CHECK(summary.at("counts").at("imu").get<int>() >= 390);
  CHECK(summary.at("metrics").at("ate_m").get<double>() < 0.05);
  CHECK(summary.at("metrics").at("matched").get<double>() == Approx(1.0));
  // Nobody has said that it ends where it began.
  CHECK(summary.at("metrics").at("end_to_end_m").is_null());
  const Json manifest = json(bench / "out/manifest.json");
  CHECK(manifest.at("input").at("sha256") == io::input_digest(bench / "recording.bag"));
  CHECK(manifest.at("reference").at("path") == (bench / "truth.tum").string());
  CHECK(manifest.at("reference").at("sha256") == io::input_digest(bench / "truth.tum"));
  CHECK(manifest.at("seeds").at("order") == 7);
  CHECK(manifest.at("threads") == 1);
  CHECK(manifest.at("overrides") == Json::array({"max_speed=25"}));
  CHECK_THAT(manifest.at("build").at("compiler").get<std::string>(), Contains("GNU") || Contains("Clang"));
  CHECK(manifest.at("command_line").at(1) == "run");
  const auto stages = manifest.at("stages").get<std::vector<std::string>>();
  CHECK(std::find(stages.begin(), stages.end(), "windows/fixed") != stages.end());
}

TEST_CASE("one and two threads, and a second run, give the same trajectory to the bit") {
  const Bench bench;
  REQUIRE(bench.run("one", {"--threads", "1"}).code == 0);
  REQUIRE(bench.run("two", {"--threads", "2"}).code == 0);
  REQUIRE(bench.run("again", {"--threads", "1"}).code == 0);
  const std::string digest = io::input_digest(bench / "one/trajectory.tum");
  REQUIRE(line_count(bench / "one/trajectory.tum") > 10);
  CHECK(io::input_digest(bench / "two/trajectory.tum") == digest);
  CHECK(io::input_digest(bench / "again/trajectory.tum") == digest);
  CHECK(content(bench / "two/updates.csv") == content(bench / "one/updates.csv"));
}

TEST_CASE("resolved.yaml makes the run again, overrides included") {
  const Bench bench;
  REQUIRE(bench.run("plain").code == 0);
  REQUIRE(bench.run("set", {"--set", "window.period=0.05", "--set", "samplers.1.keep_every=5"}).code == 0);
  CHECK(5 * line_count(bench / "set/trajectory.tum") > 9 * line_count(bench / "plain/trajectory.tum"));
  std::filesystem::copy_file(bench / "set/resolved.yaml", bench / "pipeline.yaml",
                             std::filesystem::copy_options::overwrite_existing);
  REQUIRE(bench.run("again").code == 0);
  CHECK(content(bench / "again/trajectory.tum") == content(bench / "set/trajectory.tum"));
  CHECK(content(bench / "again/resolved.yaml") == content(bench / "set/resolved.yaml"));
}

TEST_CASE("a section of the data is a section of the trajectory") {
  const Bench bench;
  REQUIRE(bench.run("section", {"--start", "0.5", "--duration", "1.0"}).code == 0);
  const auto poses = io::read_tum(bench / "section/trajectory.tum");
  REQUIRE(poses.size() >= 6);
  CHECK(to_seconds(poses.back().t - poses.front().t) < 1.01);
}

TEST_CASE("a second run replaces the files of the first") {
  const Bench bench;
  REQUIRE(bench.run("out", {"--dense"}).code == 0);
  REQUIRE(bench.run("out", {"--duration", "1"}).code == 0);
  CHECK_FALSE(std::filesystem::exists(bench / "out/trajectory_dense.tum"));
  CHECK(json(bench / "out/summary.json").at("updates").get<std::size_t>() == line_count(bench / "out/trajectory.tum"));
  for (const auto& entry : std::filesystem::directory_iterator(bench / "out")) {
    CHECK(entry.path().extension() != ".part");
  }
}

TEST_CASE("progress is plain lines away from a terminal, and nothing with --quiet") {
  const Bench bench;
  const Ended loud = bench.run("loud");
  CHECK_THAT(loud.err, Contains("imu acceleration: g"));
  CHECK(loud.err.find('\r') == std::string::npos);
  const Ended quiet = bench.run("quiet", {"--quiet"});
  CHECK(quiet.code == 0);
  CHECK(quiet.out.empty());
  CHECK(quiet.err.empty());
}

TEST_CASE("a run that is lost for good ends there on demand, and is judged as if it had gone on") {
  const Bench bench({.duration = 4.0});
  write_truth(bench / "truth.tum");
  auto truth = io::read_tum(bench / "truth.tum");
  for (StampedPose& sample : truth) {  // it leaves at 20 m/s when 1.2 s have passed
    sample.T.p.x() += 20 * std::max(0.0, to_seconds(sample.t - truth.front().t) - 1.2);
  }
  io::write_tum(bench / "truth.tum", truth);
  const Ended whole = bench.run("whole", {"--reference", bench / "truth.tum"});
  const Ended ended = bench.run("ended", {"--reference", bench / "truth.tum", "--stop-when-diverged"});
  INFO(ended.err);
  CHECK(whole.code == 1);
  CHECK(ended.code == whole.code);
  const Json a = json(bench / "whole/summary.json"), b = json(bench / "ended/summary.json");
  CHECK(a.at("status") == "diverged");
  CHECK(b.at("status") == "diverged");
  CHECK(b.at("reason").get<std::string>() == a.at("reason").get<std::string>() + "; the run was ended there");
  CHECK(b.at("metrics").at("failed_at") == a.at("metrics").at("failed_at"));
  CHECK(b.at("updates").get<int>() < a.at("updates").get<int>());
  CHECK(b.at("updates").get<int>() > 20);
  CHECK(bench.run("none", {"--stop-when-diverged"}).code == 0);  // without a reference
}

TEST_CASE("a run that ends early tells what speaks against its gyro_unit") {
  const Bench bench({.duration = 8.0, .blind_from = 6.0, .blind_until = 7.5});  // the first turn is at 5 s
  write_text(bench / "sensor.yaml", sensor_text("gyro_unit: deg_s\n"));
  const Ended ended = bench.run("out", {"--set", "max_gap=1", "--stop-when-diverged"});
  CHECK(ended.code == 1);
  CHECK_THAT(ended.err, Contains("warning: ") && Contains("gyro_unit is deg_s, but nothing in all that was read"));
  const Json summary = json(bench / "out/summary.json");
  CHECK(summary.at("coverage").get<double>() < 0.95);
  CHECK_THAT(summary.at("notes").dump(), Contains("gyro_unit is deg_s, but"));
}

TEST_CASE("a run that is lost says so, begins anew, and keeps the maps apart") {
  const Bench bench({.duration = 5.0, .blind_from = 2.0, .blind_until = 3.5});
  const Ended ended = bench.run("out", {"--set", "max_gap=1", "--save-map", bench / "map.ply"});
  CHECK(ended.code == 1);
  CHECK_THAT(ended.err, Contains("diverged: no points for 1.5") && Contains("longer than max_gap 1 s") &&
                            Contains("; started again 0.1") && Contains("s later with an empty map"));
  const Json summary = json(bench / "out/summary.json");
  CHECK(summary.at("status") == "diverged");
  REQUIRE(summary.at("losses").size() == 1);
  const Json loss = summary.at("losses").at(0);
  CHECK(loss.at("t_ns") == summary.at("moment_ns"));
  CHECK(loss.at("restarted_ns").get<TimeNs>() > loss.at("t_ns").get<TimeNs>());
  const auto segments = column(bench / "out/updates.csv", "segment");
  CHECK(segments.front() == "0");
  CHECK(segments.back() == "1");
  CHECK(column(bench / "out/updates.csv", "tracking").back() == "ok");
  CHECK(content(bench / "map.ply").size() > 10000);
  CHECK(content(bench / "map.segment_2.ply").size() > 10000);
  const auto poses = io::read_tum(bench / "out/trajectory.tum");
  CHECK(to_seconds(poses.back().t - poses.front().t) > 4.5);

  for (const std::vector<std::string>& ending :
       {std::vector<std::string>{"--set", "when_lost=end"}, std::vector<std::string>{"--stop-when-diverged"}}) {
    std::vector<std::string> arguments = {"--set", "max_gap=1", "--save-map", bench / "map.ply"};
    arguments.insert(arguments.end(), ending.begin(), ending.end());
    const Ended there = bench.run("out", arguments);
    CHECK(there.code == 1);
    CHECK_THAT(there.err, Contains("diverged: no points for 1.5") && !Contains("anew"));
    const auto some = io::read_tum(bench / "out/trajectory.tum");
    CHECK(to_seconds(some.back().t - some.front().t) < 2.1);
    CHECK_FALSE(std::filesystem::exists(bench / "map.segment_2.ply"));  // of the run before
  }
}
