/// Methods that are not of this program: a program of others, a finished trajectory.

#include <catch2/catch.hpp>
#include <fstream>
#include <nlohmann/json.hpp>

#include "aslio/core/errors.hpp"
#include "aslio/experiment/external_method.hpp"
#include "cli/recordings.hpp"
#include "study_files.hpp"

using namespace aslio::test;
using namespace aslio::experiment;
using Catch::Matchers::Contains;

namespace fs = std::filesystem;

namespace {

using Words = std::vector<std::string>;

/// A recording of two seconds with its truth, and scripts that stand for programs of others.
struct Bench {
  StudyFiles study;

  Bench() {
    write_bag(at("walk.bag"));
    write_truth(at("truth.tum"));
    write_text(at("sensor.yaml"), sensor_text("lidar_topic: /livox/lidar\nimu_topic: /livox/imu\nacc_unit: g\n"));
    write_text(at("walk.yaml"),
               "schema: aslio/dataset/1\ninput: walk.bag\nsensor: sensor.yaml\nreference: truth.tum\n");
    write_text(at("quick.yaml"), pipeline_text());
    script("copies.sh", "test -s \"$1\" && cp \"$(dirname \"$0\")/truth.tum\" \"$2/poses.tum\"");
  }
  fs::path at(const std::string& name) const { return study.folder / name; }
  void script(const std::string& name, const std::string& body) const {
    write_text(at(name), "#!/bin/sh\n" + body + "\n");
    fs::permissions(at(name), fs::perms::owner_all);
  }
  std::string text(const std::string& methods, const std::string& more = "") const {
    return head() + "datasets: [{dataset: walk.yaml}]\nmethods: [" + methods + "]\n" + more;
  }
  Ended run(const std::string& methods, const std::string& more = "", const Words& options = {}) const {
    write_text(at("study.yaml"), text(methods, more));
    Words arguments = {"experiment", at("study.yaml"), "--output", at("out")};
    arguments.insert(arguments.end(), options.begin(), options.end());
    return run_aslio(arguments);
  }
  Words figures(const std::string& name) const { return column(at("out/results.csv"), name); }
  nlohmann::json summary(const std::string& method) const {
    return nlohmann::json::parse(content(at("out/runs/walk/" + method + "/summary.json")));
  }
};

/// This program in place of one of others, over an input of that form.
std::string itself(const std::string& form) {
  return "{name: " + form + ", input: " + form + ", trajectory: own/trajectory_lidar.tum, frame: lidar, command: ['" +
         std::string(ASLIO_PROGRAM) +
         "', run, '{here}/quick.yaml', --input, '{bag}', --sensor, '{sensor}', --output, '{output}/own', --quiet]}";
}

}  // namespace

TEST_CASE("words of a command have their places filled in") {
  const ExternalPlaces places{.bags = {"/d/a.bag", "/d/b.bag"},
                              .imu_topic = "/imu",
                              .lidar_topic = "",
                              .output = "/out/run",
                              .sensor = "/d/s.yaml",
                              .data = "walk_3",
                              .sequence = "walk",
                              .seed = "7"};
  CHECK(filled_in(Words{"p", "{bag}", "--imu={imu_topic}"}, places) ==
        Words{"p", "/d/a.bag", "/d/b.bag", "--imu=/imu"});
  CHECK_THROWS_WITH(filled_in("--bag={bag}", places), Contains("2 files") && Contains("word of its own"));
  CHECK(filled_in("{data}/{sequence}_{seed}.tum", places) == "walk_3/walk_7.tum");
  CHECK(filled_in("{output}/a {sensor}", places) == "/out/run/a /d/s.yaml");
  CHECK(filled_in("{\"json\": 1} {{.Names}}", places) == "{\"json\": 1} {{.Names}}");
  CHECK_THROWS_WITH(filled_in("{lidar_topic}", places), Contains("lidar_topic") && Contains("input: bag"));
  CHECK(unknown_place("{bag} {outptu}") == "outptu");
  CHECK(unknown_place("{\"a\": 1} {print} {X}").empty());
  CHECK(unknown_place("{run:fast}") == "run:fast");
}

TEST_CASE("paths of a method are relative to its file, and a program without a slash is one of PATH") {
  ExternalMethod method;
  method.command = {"./p", "{here}/c.yaml", "x/y"};
  method.trajectory = "poses.tum";
  CHECK(placed_in(method, "/lab").command == Words{"/lab/p", "/lab/c.yaml", "x/y"});
  CHECK(placed_in(method, "/lab").trajectory == "poses.tum");
  method.command.front() = "p";
  CHECK(placed_in(method, "/lab").command.front() == "p");
  method.command.clear();
  CHECK(placed_in(method, "/lab").trajectory == "/lab/poses.tum");
}

TEST_CASE("a container sees the folders of the run, of its data and of the method by the same paths") {
  ExternalMethod method;
  method.command = {"p"};
  CHECK(in_container(method, {"p", "a"}, "/out", {"/d"}, "n") == Words{"p", "a"});
  method.image = "lio:1";
  method.engine = "docker";
  method.engine_options = {"--network", "none"};
  method.folder = "/lab";
  const Words docker = in_container(method, {"p", "a"}, "/lab/out", {"/d", "/d", "/lab/out"}, "n");
  CHECK(Words(docker.begin(), docker.begin() + 6) == Words{"docker", "run", "--rm", "--init", "--name", "n"});
  // A folder is mounted after the one that it lies in, which would hide it otherwise.
  CHECK(Words(docker.begin() + 8, docker.end()) == Words{"--network", "none", "-v", "/d:/d:ro", "-v", "/lab:/lab:ro",
                                                         "-v", "/lab/out:/lab/out", "-w", "/lab/out", "lio:1", "p",
                                                         "a"});
  method.engine = "apptainer";
  method.engine_options.clear();
  CHECK(in_container(method, {"p"}, "/out", {"/d"}, "n") == Words{"apptainer", "exec", "--bind", "/d:/d:ro", "--bind",
                                                                  "/lab:/lab:ro", "--bind", "/out:/out", "--pwd",
                                                                  "/out", "lio:1", "p"});
  CHECK_THROWS_WITH(in_container(method, {"p"}, "/out", {"/d:1"}, "n"), Contains("/d:1"));
}

TEST_CASE("what is wrong with a method of others is reported with its place") {
  const Bench bench;
  const auto complaint = [&](const std::string& methods, const std::string& more = "") {
    return bench.study.complaint(bench.text(methods, more));
  };
  CHECK(complaint("{name: a, command: [p, '{bag}'], trajectory: x.tum}").empty());
  CHECK_THAT(complaint("{name: a, command: [p]}"),
             Contains("study.yaml:6:") && Contains("file of poses that the command"));
  CHECK_THAT(complaint("{name: a}"), Contains("pipeline") && Contains("`command` of a program"));
  CHECK_THAT(complaint("{name: a, pipeline: quick.yaml, trajectory: x.tum}"), Contains("exclude each other"));
  CHECK_THAT(complaint("{name: a, command: [p, '{bagg}'], trajectory: x.tum}"),
             Contains("{bagg} is no place") && Contains("{imu_topic}"));
  CHECK_THAT(complaint("{name: a, trajectory: x.tum, set: {window.period: 1}}"), Contains("changes a pipeline"));
  CHECK_THAT(complaint("{name: a, trajectory: x.tum, input: bag}"), Contains("goes with `command`"));
  CHECK_THAT(complaint("{name: a, command: [p], trajectory: x.tum, engine: podman, image: i}"),
             Contains("docker, apptainer"));
  CHECK_THAT(complaint("{name: a, command: [p], trajectory: x.tum, engine: docker}"), Contains("give both or neither"));
  CHECK_THAT(complaint("{name: a, command: [p], trajectory: x.tum, exit_codes: [0.5]}"), Contains("whole numbers"));
  CHECK_THAT(complaint("{name: a, pipeline: quick.yaml}, {name: b, trajectory: x.tum}",
                       "vary: [{path: window.period, values: [0.1, 0.2]}]\n"),
             Contains("method 'b'") && Contains("methods: [..]"));
  CHECK_THAT(complaint("{name: a, command: [p], trajectory: trajectory.tum}"), Contains("that this program writes"));
  CHECK_THAT(complaint("{name: a, command: [''], trajectory: x.tum}"), Contains("name of a program"));
  CHECK_THAT(complaint("{name: a, trajectory: x.tum, trajectory_set: [colums=a]}"),
             Contains("study.yaml:6:") && Contains("colums"));
  CHECK_THAT(
      complaint("{name: a, trajectory: x.tum}, {name: b, pipeline: quick.yaml, set: {window: {type: replay, file: "
                "'{run:a}/updates.csv'}}}"),
      Contains("no file that a stage reads"));
  CHECK(complaint("{name: a, pipeline: quick.yaml}, {name: b, trajectory: x.tum}",
                  "vary: [{path: window.period, values: [0.1, 0.2], methods: [a]}]\nbaseline: b\n")
            .empty());
}

TEST_CASE(
    "programs of others and finished trajectories stand in the tables of a study, and a second call repeats none") {
  const Bench bench;
  fs::create_directories(bench.at("theirs"));
  fs::copy(bench.at("truth.tum"), bench.at("theirs/walk.tum"));
  const std::string methods =
      "{name: quick, pipeline: quick.yaml}, {name: theirs, trajectory: 'theirs/{data}.tum'}, "
      "{name: copies, command: [./copies.sh, '{bag}', '{output}'], trajectory: poses.tum}";
  const std::string more = "baseline: quick\nmetrics: [ate_m, cpu_s_per_s, peak_rss_mb]\n";
  const Ended first = bench.run(methods, more);
  INFO(first.err);
  REQUIRE(first.code == 0);
  CHECK(bench.figures("status") == Words{"ok", "ok", "ok"});
  const Words ate = bench.figures("ate_m");
  CHECK(std::stod(ate[1]) < 1e-9);
  CHECK(ate[2] == ate[1]);
  CHECK(bench.figures("coverage")[2] == "1");
  CHECK(bench.figures("cpu_s_per_s")[1].empty());  // nobody saw it
  CHECK(bench.summary("copies").at("external") == true);
  for (const char* file : {"trajectory.tum", "trajectory_lidar.tum", "program.log", "resolved.yaml", "manifest.json"}) {
    INFO(file);
    CHECK(fs::exists(bench.at("out/runs/walk/copies") / file));
  }
  const auto study = nlohmann::json::parse(content(bench.at("out/study.json")));
  CHECK(study.at("methods").at(1).at("differs") == nlohmann::json{"program"});
  CHECK(run_aslio({"report", bench.at("out"), "--format", "md,csv"}).code == 0);

  CHECK_THAT(bench.run(methods, more, {"--dry-run"}).out, Contains("0 runs to do, 3 finished"));
  bench.script("copies.sh", "cp \"$(dirname \"$0\")/truth.tum\" \"$2/poses.tum\"  # another program");
  write_text(bench.at("theirs/walk.tum"), content(bench.at("truth.tum")) + "# another result\n");
  CHECK_THAT(bench.run(methods, more, {"--dry-run"}).out, Contains("walk/theirs: to run") &&
                                                              Contains("walk/copies: to run") &&
                                                              Contains("2 runs to do, 1 finished"));
}

TEST_CASE("a program reads the recording in any form, and finds in it what this program reads") {
  const Bench bench;
  const Ended ended = bench.run("{name: quick, pipeline: quick.yaml}, " + itself("as_is") + ", " + itself("bag") +
                                ", " + itself("db3") + ", " + itself("mcap") + ", " + itself("folder"));
  INFO(ended.err << content(bench.at("out/results.csv")));
  REQUIRE(ended.code == 0);
  const Words ate = bench.figures("ate_m");
  REQUIRE(ate.size() == 6);
  for (std::size_t i = 1; i < ate.size(); ++i) CHECK(std::stod(ate[i]) == Approx(std::stod(ate[0])).epsilon(1e-9));
  // The same measurements, to the bit.
  const std::string as_is = content(bench.at("out/runs/walk/as_is/own/trajectory.tum"));
  for (const char* form : {"bag", "db3", "mcap", "folder"}) {
    INFO(form);
    CHECK(content(bench.at("out/runs/walk/" + std::string(form) + "/own/trajectory.tum")) == as_is);
    CHECK_FALSE(fs::exists(bench.at("out/runs/walk/" + std::string(form) + "/.input")));
  }
}

TEST_CASE("a copy has its own sensor file: what reading has put right is right there, also without topics") {
  const Bench bench;
  write_text(bench.at("sensor.yaml"),
             sensor_text("acc_unit: g\nimu_delay: 0.004\nlidar_stamp: end\nimu_time_offset: 2\n"
                         "lidar_time_offset: 2\ngyro_sensitivity: [0.01, 0, 0, 0, 0.01, 0, 0, 0, 0.01]\n"));
  write_text(bench.at("walk.yaml"), "schema: aslio/dataset/1\ninput: walk.bag\nsensor: sensor.yaml\n");
  const Ended ended =
      bench.run(itself("as_is") + ", " + itself("bag") + ", " + itself("mcap") + ", " + itself("folder"));
  INFO(ended.err << content(bench.at("out/results.csv")));
  const std::string as_is = content(bench.at("out/runs/walk/as_is/own/trajectory.tum"));
  REQUIRE_FALSE(as_is.empty());
  for (const char* form : {"bag", "mcap", "folder"}) {
    INFO(form);
    CHECK(content(bench.at("out/runs/walk/" + std::string(form) + "/own/trajectory.tum")) == as_is);
  }
}

TEST_CASE("a trajectory that was there before, one of another clock, and a spoilt folder are told for what they are") {
  const Bench bench;
  bench.script("once.sh",
               "test -e \"$(dirname \"$0\")/done\" || cp \"$(dirname \"$0\")/truth.tum\" poses.tum; touch \"$(dirname "
               "\"$0\")/done\"");
  write_text(bench.at("method.yaml"), "schema: aslio/external/1\ncommand: [./once.sh]\ntrajectory: poses.tum\n");
  const auto run = [&] {
    return run_aslio(
        {"external", bench.at("method.yaml"), "--dataset", bench.at("walk.yaml"), "--output", bench.at("o")});
  };
  CHECK(run().code == 0);
  const Ended second = run();
  CHECK(second.code == 1);
  CHECK_THAT(second.err, Contains("has not written it"));
  bench.script("spoils.sh",
               "cp \"$(dirname \"$0\")/truth.tum\" poses.tum; rm -rf \"$1\"; mkdir -p \"$1/manifest.json\"");
  bench.script("sparse.sh", "awk 'NR % 100 == 1' \"$(dirname \"$0\")/truth.tum\" > poses.tum");
  const Ended ended = bench.run(
      "{name: later, trajectory: truth.tum, trajectory_set: [time_offset=500]}, {name: spoils, command: [./spoils.sh, "
      "'{output}'], "
      "trajectory: poses.tum}, {name: sparse, command: [./sparse.sh], trajectory: poses.tum}");
  INFO(ended.err);
  CHECK(ended.code == 1);
  CHECK(bench.figures("status") == Words{"failed", "failed", "ok"});
  CHECK_THAT(content(bench.at("out/results.csv")), Contains("another clock or unit"));
}

TEST_CASE("a program that does not do its work is a row with its reason, and the study goes on") {
  const Bench bench;
  bench.script("fails.sh", "echo 'no map' >&2; exit 3");
  bench.script("ends_badly.sh", "cp \"$(dirname \"$0\")/truth.tum\" poses.tum; exit 3");
  bench.script("half.sh", "head -n 100 \"$(dirname \"$0\")/truth.tum\" > poses.tum");
  bench.script("off.sh", "awk '{$2 += 9 * NR / 100; print}' \"$(dirname \"$0\")/truth.tum\" > poses.tum");
  const Ended ended = bench.run(
      "{name: fails, command: [./fails.sh], trajectory: poses.tum}, "
      "{name: borne, command: [./ends_badly.sh], trajectory: poses.tum, exit_codes: [0, 3]}, "
      "{name: half, command: [./half.sh], trajectory: poses.tum}, {name: off, command: [./off.sh], trajectory: "
      "poses.tum}, "
      "{name: silent, command: ['true'], trajectory: poses.tum}, {name: absent, command: [no_such_lio], trajectory: "
      "p.tum}, "
      "{name: crashes, command: [sh, -c, 'kill -SEGV $$'], trajectory: p.tum}, {name: none, trajectory: "
      "'no/{data}.tum'}");
  CHECK(ended.code == 1);
  CHECK(bench.figures("status") == Words{"failed", "ok", "failed", "diverged", "failed", "failed", "failed", "failed"});
  const auto reason = [&](const char* method) { return bench.summary(method).at("reason").get<std::string>(); };
  CHECK_THAT(reason("fails"), Contains("exit code 3") && Contains("no map"));
  CHECK_THAT(reason("half"), Contains("% of the data, less than 95 %"));
  CHECK_THAT(content(bench.at("out/results.csv")),
             Contains("runs/walk/silent/poses.tum: the program ended well, and has"));
  CHECK_THAT(reason("absent"), Contains("no_such_lio: cannot be started") && Contains("PATH"));
  CHECK_THAT(reason("crashes"), Contains("signal 11"));
  CHECK_THAT(reason("none"), Contains("no/walk.tum"));
}

TEST_CASE("limits hold for all that a program starts, and none of it is left") {
  const Bench bench;
  const std::string mark = bench.at("alive").string();
  // The last words would be written by a process that outlives the run.
  bench.script("hangs.sh", "(sleep 12; echo still there > " + mark + ") & sleep 60");
  // Neither a session of its own nor a parent that has ended lets a process escape, or hides what it costs.
  bench.script("leaves.sh",
               "setsid sh -c 'sleep 6; echo still there > " + mark +
                   "' & (setsid python3 -c 'import time\nwhile time.process_time() < 0.5: pass' &) ; sleep 1.5; cp "
                   "\"$(dirname \"$0\")/truth.tum\" poses.tum");
  bench.script("breaks.sh", "(while :; do echo x; done) | head -n 1 && cp \"$(dirname \"$0\")/truth.tum\" poses.tum");
  bench.script("grows.sh", "setsid python3 -c 'x = bytearray(400_000_000); import time; time.sleep(60)'");
  bench.script("works.sh",
               "python3 -c 'import time\nwhile time.process_time() < 0.7: pass' && cp \"$(dirname \"$0\")/truth.tum\" "
               "poses.tum");
  const Ended ended = bench.run(
      "{name: hangs, command: [./hangs.sh], trajectory: p.tum}, {name: grows, command: [./grows.sh], trajectory: "
      "p.tum}, "
      "{name: works, command: [./works.sh], trajectory: poses.tum}, "
      "{name: leaves, command: [./leaves.sh], trajectory: poses.tum}, "
      "{name: breaks, command: [./breaks.sh], trajectory: poses.tum}",
      "time_limit: 8\nmemory_limit: 250\nmetrics: [ate_m, cpu_s_per_s]\n");
  INFO(ended.err);
  CHECK(bench.figures("status") == Words{"timeout", "memory", "ok", "ok", "ok"});
  CHECK(bench.summary("works").at("cpu_s").get<double>() == Approx(1.0).margin(0.3));
  CHECK(bench.summary("works").at("peak_rss_mb").get<double>() == Approx(10).margin(7));  // of Python
  CHECK(bench.summary("leaves").at("cpu_s").get<double>() == Approx(0.8).margin(0.3));
  ::sleep(5);
  CHECK_FALSE(fs::exists(mark));
}

TEST_CASE("aslio external: a file of a method, a section of a recording, a trajectory in another format") {
  const Bench bench;
  write_text(bench.at("method.yaml"),
             "schema: aslio/external/1\ncommand: [./copies.sh, '{bag}', '{output}']\ntrajectory: poses.tum\n");
  const auto run = [&](const std::string& dataset, const std::string& output) {
    return run_aslio(
        {"external", bench.at("method.yaml"), "--dataset", bench.at(dataset), "--output", bench.at(output)});
  };
  CHECK(run_aslio({"check", bench.at("method.yaml")}).code == 0);
  const Ended whole = run("walk.yaml", "whole");
  INFO(whole.err);
  CHECK(whole.code == 0);
  CHECK_THAT(whole.out, Contains("status       ok") && Contains("coverage 100.0 %") && Contains("cost "));
  // A part of a recording cannot be handed over as the whole.
  write_text(bench.at("part.yaml"), content(bench.at("walk.yaml")) + "duration: 1\n");
  const Ended part = run("part.yaml", "part");
  CHECK(part.code == 2);
  CHECK_THAT(part.err, Contains("part.yaml") && Contains("input: bag"));
  write_text(bench.at("method.yaml"), content(bench.at("method.yaml")) + "input: bag\n");
  CHECK(run("part.yaml", "part").code == 0);
  // Positions of the LiDAR in a table, with times in ns.
  std::ifstream truth(bench.at("truth.tum"));
  std::string table = "t,x,y,z,qx,qy,qz,qw\n";
  double t = 0;
  for (std::string rest; truth >> t && std::getline(truth, rest);) {
    std::replace(rest.begin(), rest.end(), ' ', ',');
    table += std::to_string(static_cast<long long>(t * 1e9 + 0.5)) + rest + "\n";
  }
  write_text(bench.at("theirs.csv"), table);
  write_text(bench.at("finished.yaml"),
             "schema: aslio/external/1\ntrajectory: theirs.csv\nformat: csv\nframe: lidar\n"
             "trajectory_set: ['columns=[t, x, y, z, qx, qy, qz, qw]', time_unit=ns]\n");
  const Ended finished = run_aslio(
      {"external", bench.at("finished.yaml"), "--dataset", bench.at("walk.yaml"), "--output", bench.at("finished")});
  INFO(finished.err);
  CHECK(finished.code == 0);
}
