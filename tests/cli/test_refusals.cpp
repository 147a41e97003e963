/// What the command line does not do: overwrite its inputs, keep stale results, or take options that make no sense.

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "fixture.hpp"

using namespace aslio::test;
using Catch::Matchers::Contains;

TEST_CASE("a run refuses to overwrite what it reads") {
  const Bench bench(Recording{.duration = 0.5});
  std::filesystem::create_directories(bench / "out");
  write_truth(bench / "out/trajectory.tum");
  const std::string truth = content(bench / "out/trajectory.tum");
  std::filesystem::create_directory_symlink(bench / "out", bench / "link");
  for (const char* output : {"out", "out/../out", "link"}) {
    const Ended ended = bench.run(output, {"--reference", bench / "out/trajectory.tum"});
    INFO(output);
    CHECK(ended.code == 2);
    CHECK_THAT(ended.err, Contains("--output") && Contains("trajectory.tum would be overwritten") &&
                              Contains("--reference reads it"));
    CHECK(content(bench / "out/trajectory.tum") == truth);
  }
  std::filesystem::copy_file(bench / "pipeline.yaml", bench / "out/resolved.yaml");
  auto arguments = bench.arguments("out");
  arguments[1] = bench / "out/resolved.yaml";
  const Ended pipeline = run_aslio(arguments);
  CHECK(pipeline.code == 2);
  CHECK_THAT(pipeline.err, Contains("resolved.yaml would be overwritten"));
  CHECK(content(bench / "out/resolved.yaml") == pipeline_text());
}

TEST_CASE("a run that cannot read its input leaves no results of an earlier one") {
  const Bench bench(Recording{.duration = 1.5});
  REQUIRE(bench.run("out", {"--dense"}).code == 0);
  REQUIRE(std::filesystem::exists(bench / "out/trajectory.tum"));
  write_text(bench / "recording.bag", "");
  const Ended ended = bench.run("out");
  CHECK(ended.code == 3);
  for (const char* name : {"trajectory.tum", "trajectory_lidar.tum", "trajectory_dense.tum", "updates.csv",
                           "timings.csv", "manifest.json"}) {
    INFO(name);
    CHECK_FALSE(std::filesystem::exists(bench / "out" / name));
  }
  const auto summary = nlohmann::json::parse(content(bench / "out/summary.json"));
  CHECK(summary.at("status") == "failed");
  CHECK_THAT(summary.at("reason").get<std::string>(), Contains("recording.bag"));
}

TEST_CASE("samplers that leave no point: the run is not ok") {
  const Bench bench;
  const Ended ended = bench.run("out", {"--set", "samplers=[{type: range, min: 90, max: 100}]"});
  CHECK(ended.code == 1);
  CHECK_THAT(ended.err, Contains("no point passed the samplers"));
  CHECK(nlohmann::json::parse(content(bench / "out/summary.json")).at("coverage").get<double>() < 0.5);
}

TEST_CASE("a reference that is elsewhere makes the run diverged, with moment and reason") {
  const Bench bench;
  write_truth(bench / "truth.tum");
  const std::string truth = content(bench / "truth.tum");
  const double begin = std::stod(truth);
  std::string lines;  // 20 m/s and a bend: nothing that the recording does
  for (int i = 0; i <= 100; ++i) {
    char line[128];
    const double s = 0.4 * i;
    std::snprintf(line, sizeof line, "%.9f %.6f %.6f 0 0 0 0 1\n", begin + 0.02 * i, s, s * s / 20);
    lines += line;
  }
  write_text(bench / "wrong.tum", lines);
  const Ended ended = bench.run("out", {"--reference", bench / "wrong.tum"});
  CHECK(ended.code == 1);
  CHECK_THAT(ended.err, Contains("diverged") && Contains("m from the reference after"));
  const auto summary = nlohmann::json::parse(content(bench / "out/summary.json"));
  CHECK(summary.at("status") == "diverged");
  const auto moment = std::to_string(summary.at("moment_ns").get<long>());
  CHECK_THAT(ended.out,
             Contains("(at " + moment.substr(0, moment.size() - 9) + "." + moment.substr(moment.size() - 9)));
}

TEST_CASE("numbers that make no sense are refused with what would") {
  struct Case {
    const char *option, *value, *message;
  };
  const Case cases[] = {{"--start", "abc", "'abc' is not a number"},
                        {"--start", "-1", "'-1' is negative; give seconds from 0"},
                        {"--start", "nan", "'nan' is not a finite number"},
                        {"--start", "1e10", "'1e10' is out of range; give at most 1e+09 seconds"},
                        {"--duration", "0", "'0' is no duration; give seconds above 0"},
                        {"--duration", "inf", "'inf' is not a finite number"},
                        {"--duration", "1e999", "'1e999' is out of range"},
                        {"--duration", "1s", "'1s' is not a number"},
                        {"--seed", "-3", "'-3' is negative; give a whole number from 0"},
                        {"--seed", "1.5", "'1.5' is not a whole number"},
                        {"--seed", "18446744073709551616", "is out of range"},
                        {"--threads", "0", "'0' is out of range; give a whole number from 1 to 256"},
                        {"--threads", "two", "'two' is not a number"}};
  const Bench bench(Recording{.duration = 0.1});
  for (const Case& c : cases) {
    const Ended ended = bench.run("out", {c.option, c.value});
    INFO(c.option << " " << c.value);
    CHECK(ended.code == 2);
    CHECK_THAT(ended.err, Contains(std::string(c.option) + ": ") && Contains(c.message));
    CHECK_FALSE(std::filesystem::exists(bench / "out"));
  }
}

TEST_CASE("an unknown command is named, with the nearest") {
  const Ended near = run_aslio({"rnu"});
  CHECK(near.code == 2);
  CHECK_THAT(near.err, Contains("unknown command 'rnu' (did you mean 'run'?)") && Contains("evaluate"));
  const Ended far = run_aslio({"frobnicate"});
  CHECK(far.code == 2);
  CHECK_THAT(far.err, Contains("unknown command 'frobnicate'; there are: run"));
}

TEST_CASE("an unknown option is named, with the nearest, before what is missing") {
  const Ended near = run_aslio({"run", ASLIO_SOURCE_DIR "/configs/pipelines/as_lio.yaml", "--ouput", "out"});
  CHECK(near.code == 2);
  CHECK_THAT(near.err, Contains("unknown option '--ouput' (did you mean '--output'?)") && Contains("aslio run --help"));
  CHECK_THAT(run_aslio({"report", ".", "--frobnicate"}).err, Contains("unknown option '--frobnicate';"));
}

TEST_CASE("a pipeline that does not exist is answered by those that do") {
  const Ended ended = run_aslio({"run", "as_loi"});
  CHECK(ended.code == 2);
  CHECK_THAT(ended.err, Contains("as_loi: no such file (did you mean ") &&
                            Contains("configs/pipelines/as_lio.yaml?)") && Contains("as_lio_plus_fast, "));
  CHECK_THAT(run_aslio({"run", "frobnicate.yaml"}).err, Contains("frobnicate.yaml: no such file; pipelines in "));
}

TEST_CASE("what comes with the program is known by its name, and as it lies in a clone") {
  const Bench bench;
  for (const char* pipeline : {"fixed_window", "configs/pipelines/fixed_window.yaml"}) {
    INFO(pipeline);
    const Ended ended =
        run_aslio({"run", pipeline, "--input", bench / "none.bag", "--sensor", "livox_avia", "--output", bench / "o"});
    CHECK(ended.code == 2);
    CHECK_THAT(ended.err, Contains("none.bag") && !Contains("no such file;") && !Contains("fixed_window"));
  }
  CHECK(run_aslio({"simulate", "quickstart", "--duration", "3", "--output", bench / "walk"}).code == 0);
  CHECK(run_aslio({"run", "fixed_window", "--dataset", bench / "walk", "--output", bench / "run", "--quiet"}).code !=
        2);
  CHECK_THAT(run_aslio({"simulate", "quikstart", "--output", bench / "o"}).err,
             Contains("did you mean ") && Contains("configs/scenes/quickstart.yaml?)"));
  write_text(bench / "some.bag", "no bag");
  CHECK_THAT(
      run_aslio({"run", "as_lio", "--input", bench / "some.bag", "--sensor", "livox_avai", "--output", bench / "o"})
          .err,
      Contains("configs/sensors/livox_avia.yaml?)"));
}

TEST_CASE("a trajectory.tum that is not of a run is not replaced") {
  const Bench bench;
  std::filesystem::create_directories(bench / "out");
  write_text(bench / "out/trajectory.tum", "0 0 0 0 0 0 0 1\n");
  const Ended ended = bench.run("out");
  CHECK(ended.code == 2);
  CHECK_THAT(ended.err, Contains("trajectory.tum is not from a run of this program"));
  CHECK(content(bench / "out/trajectory.tum") == "0 0 0 0 0 0 0 1\n");
  std::filesystem::remove(bench / "out/trajectory.tum");
  REQUIRE(bench.run("out").code == 0);
  CHECK(bench.run("out").code == 0);  // one of its own is
}

TEST_CASE("an empty argument is refused, and told where it stands") {
  const Ended path = run_aslio({"report", ""});
  CHECK(path.code == 2);
  CHECK_THAT(path.err,
             Contains("the argument after 'report' is empty: give a value (a shell variable that is not set"));
  const Ended option = run_aslio({"report", ".", "--output", "", "--format", "md"});
  CHECK(option.code == 2);
  CHECK_THAT(option.err, Contains("the argument after '--output' is empty"));
  const Ended joined = run_aslio({"report", ".", "--output="});
  CHECK(joined.code == 2);
  CHECK_THAT(joined.err, Contains("the value of '--output' is empty"));
  const Ended other = run_aslio({"report", "no_such=folder=", "--output=a="});
  CHECK_THAT(other.err, Contains("no_such=folder=") && !Contains("is empty"));
}

TEST_CASE("results that stdout does not take are a failure") {
  for (const char* command : {"version", "--version", "list", "--help"}) {
    const Ended ended = run_aslio_to("/dev/full", {command});
    INFO(command);
    CHECK(ended.code == 3);
    CHECK_THAT(ended.err, Contains("stdout cannot be written: No space left on device"));
  }
}

TEST_CASE("where a standard stream is closed, nothing of what is printed ends up in the results") {
  const Bench bench(Recording{.duration = 1.5});
  REQUIRE(bench.run("open").code == 0);
  for (const std::vector<int>& closed : {std::vector<int>{2}, {0, 2}, {0, 1, 2}}) {
    const std::string output = "closed_" + std::to_string(closed.size());
    run_aslio_without(closed, bench.arguments(output));
    for (const char* file : {"trajectory.tum", "trajectory_lidar.tum", "updates.csv"}) {
      INFO(file);
      CHECK(content(bench / output / file) == content(bench / "open" / file));
    }
  }
}

TEST_CASE("two runs do not write into one folder") {
  const Bench bench(Recording{.duration = 1.5});
  std::filesystem::create_directory(bench / "out");
  const int other = ::open((bench / "out").c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  REQUIRE(::flock(other, LOCK_EX | LOCK_NB) == 0);
  const Ended refused = bench.run("out");
  CHECK(refused.code == 2);
  CHECK_THAT(refused.err, Contains("another `aslio run` is at work there; wait for it, or name another folder"));
  CHECK(std::filesystem::is_empty(bench / "out"));
  ::close(other);
  CHECK(bench.run("out").code == 0);
}

TEST_CASE("a summary says ok only where all else of the run has been written") {
  const Bench bench(Recording{.duration = 1.5});
  std::filesystem::create_directories(bench / "out/manifest.json/x");
  const Ended ended = bench.run("out");
  CHECK(ended.code == 3);
  CHECK_THAT(ended.err, Contains("manifest.json"));
  const auto summary = nlohmann::json::parse(content(bench / "out/summary.json"));
  CHECK(summary.at("status") == "failed");
  CHECK_THAT(summary.at("reason").get<std::string>(), Contains("manifest.json"));
}

TEST_CASE("a report replaces what a report may have written, and no result or input") {
  const Bench bench(Recording{.duration = 1.5});
  REQUIRE(bench.run("out").code == 0);
  const auto report = [&](const char* format, const std::filesystem::path& to) {
    return run_aslio({"report", bench / "out", "--format", format, "--output", to});
  };
  for (const auto& [format, name] :
       {std::pair{"md", "recording.bag"}, {"csv", "out/updates.csv"}, {"csv", "out/summary.json"}}) {
    INFO(name);
    const std::string before = content(bench / name);
    const Ended ended = report(format, bench / name);
    CHECK(ended.code == 2);
    CHECK_THAT(ended.err, Contains("is not overwritten") && Contains("Name another file"));
    CHECK(content(bench / name) == before);
  }
  for (int k = 0; k < 2; ++k) CHECK(report("md", bench / "mine.md").code == 0);
}
