/// Every bad input: the exit code, what the message says, and what is left behind.

#include <signal.h>
#include <sys/stat.h>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "fixture.hpp"

using namespace aslio;
using namespace aslio::test;
using Catch::Matchers::Contains;
using Json = nlohmann::json;

namespace {

Json summary(const std::filesystem::path& folder) { return Json::parse(content(folder / "summary.json")); }

}  // namespace

TEST_CASE("unknown keys and wrong types are all told, with their places") {
  const Bench bench;
  write_text(bench / "pipeline.yaml", pipeline_text("max_sped: 30\nmax_silence: soon\n"));
  const Ended ended = bench.run("out");
  CHECK(ended.code == 2);
  CHECK_THAT(ended.err, Contains("pipeline.yaml:9:1") && Contains("unknown key 'max_sped'") &&
                            Contains("did you mean 'max_speed'"));
  CHECK_THAT(ended.err, Contains("pipeline.yaml:10:") && Contains("max_silence") && Contains("soon"));
  CHECK_FALSE(std::filesystem::exists(bench / "out"));
}

TEST_CASE("an override names itself where it is wrong") {
  const Bench bench;
  const Ended ended = bench.run("out", {"--set", "window.perod=0.1"});
  CHECK(ended.code == 2);
  CHECK_THAT(ended.err, Contains("--set window.perod=0.1") && Contains("did you mean 'period'"));
}

TEST_CASE("an unknown stage names those there are") {
  const Bench bench;
  const Ended ended = bench.run("out", {"--set", "window={type: fixd}"});
  CHECK(ended.code == 2);
  CHECK_THAT(ended.err, Contains("fixd") && Contains("fixed"));
}

TEST_CASE("missing files and wrong options are wrong usage") {
  const Bench bench;
  CHECK(run_aslio({}).code == 2);
  CHECK(run_aslio({"rnu"}).code == 2);
  const Ended threads = bench.run("out", {"--threads", "0"});
  CHECK(threads.code == 2);
  CHECK_THAT(threads.err, Contains("--threads"));
  std::filesystem::remove(bench / "recording.bag");
  const Ended input = bench.run("out");
  CHECK(input.code == 2);
  CHECK_THAT(input.err, Contains("--input") && Contains("recording.bag"));
}

TEST_CASE("a bag without the topic: the message lists those it has") {
  const Bench bench(Recording{.duration = 0.5, .lidar_topic = "/points"});
  write_text(bench / "sensor.yaml", sensor_text("lidar_topic: /livox/lidar\n"));
  const Ended ended = bench.run("out");
  CHECK(ended.code == 3);
  CHECK_THAT(ended.err, Contains("recording.bag") && Contains("no LiDAR topic '/livox/lidar'") && Contains("/points"));
}

TEST_CASE("a bag without IMU data") {
  const Bench bench(Recording{.duration = 0.5, .imu = false});
  const Ended ended = bench.run("out");
  CHECK(ended.code == 3);
  CHECK_THAT(ended.err, Contains("no IMU topic") && Contains("imu_topic"));
}

TEST_CASE("a truncated bag: what is whole is used, and the run says so") {
  const Bench bench;
  const auto bag = bench / "recording.bag";
  std::filesystem::resize_file(bag, std::filesystem::file_size(bag) * 7 / 10);
  const Ended ended = bench.run("out");
  CHECK(ended.code == 3);
  CHECK_THAT(ended.err, Contains("truncated"));
  CHECK(summary(bench / "out").at("status") == "truncated");
  CHECK(summary(bench / "out").at("updates").get<int>() >= 8);
  CHECK(line_count(bench / "out/trajectory.tum") >= 8);
  CHECK(std::filesystem::exists(bench / "out/manifest.json"));
}

TEST_CASE("a file that is no bag") {
  const Bench bench;
  write_text(bench / "recording.bag", "this is not a bag");
  const Ended ended = bench.run("out");
  CHECK(ended.code == 3);
  CHECK_THAT(ended.err, Contains("recording.bag"));
  CHECK(summary(bench / "out").at("status") == "failed");
}

TEST_CASE("point times filled with zeros are refused, and the remedy is named") {
  const Bench bench(Recording{.duration = 0.5, .point_cloud = true, .zero_times = true});
  const Ended ended = bench.run("out");
  CHECK(ended.code == 3);
  CHECK_THAT(ended.err, Contains("time") && Contains("require_point_times"));
}

TEST_CASE("point clouds with times run") {
  const Bench bench(Recording{.duration = 1.5, .point_cloud = true});
  const Ended ended = bench.run("out");
  INFO(ended.err);
  CHECK(ended.code == 0);
}

TEST_CASE("a LiDAR that falls silent before the IMU does is no run that covers its data") {
  const Bench bench(Recording{.blind_from = 0.8, .blind_until = 9});
  const Ended soon = bench.run("soon", {});  // 1.2 s: what a recorder leaves at its end
  INFO(soon.err);
  CHECK(soon.code == 4);
  const Json told = summary(bench / "soon");
  CHECK(told.at("status") == "degraded");
  CHECK_THAT(told.at("reason").get<std::string>(), Contains("s without points"));
  CHECK(told.at("longest_lidar_gap_s").get<double>() == Approx(1.2).margin(0.15));
  CHECK(told.at("coverage") == 1.0);
  const Ended lost = bench.run("lost", {"--set", "max_gap=0.5"});
  CHECK(lost.code == 1);
  CHECK_THAT(lost.err, Contains("of the data, less than 95 %"));
}

TEST_CASE("points that are not numbers are dropped and counted") {
  const Bench bench(Recording{.nan_every = 2});
  const Ended ended = bench.run("out");
  INFO(ended.err);
  CHECK(ended.code == 0);
  const Json counts = summary(bench / "out").at("counts");
  const auto invalid = counts.at("points_invalid").get<double>(), kept = counts.at("points").get<double>();
  CHECK(invalid == Approx(kept).epsilon(0.01));
}

TEST_CASE("acceleration in g that is declared m/s^2 is refused with the factor") {
  const Bench bench;
  write_text(bench / "sensor.yaml", sensor_text("acc_unit: mps2\n"));
  const Ended ended = bench.run("out");
  CHECK(ended.code == 3);
  CHECK_THAT(ended.err, Contains("acc_unit") && Contains("9.80665"));
}

TEST_CASE("an output folder that cannot be is found before the data is read") {
  const Bench bench;
  write_text(bench / "file", "");
  write_text(bench / "recording.bag", "not read");
  for (const char* output : {"file", "file/below"}) {
    const Ended ended = bench.run(output);
    CHECK(ended.code == 2);
    CHECK_THAT(ended.err, Contains("--output") && Contains("file") && !Contains("bag"));
  }
  auto arguments = bench.arguments("out");
  arguments[7] = "/proc";
  const Ended ended = run_aslio(arguments);
  CHECK(ended.code == 2);
  CHECK_THAT(ended.err, Contains("--output /proc"));
}

TEST_CASE("a disk that fills up leaves no half-written file under a final name") {
  const Bench bench;
  const Ended ended = run_aslio_with_file_limit(bench.arguments("out", {"--save-map", bench / "map.ply"}), 100'000);
  CHECK(ended.code == 3);
  CHECK_THAT(ended.err, Contains("map.ply") && Contains("File too large"));
  CHECK_FALSE(std::filesystem::exists(bench / "map.ply"));
  CHECK(summary(bench / "out").at("status") == "failed");
}

TEST_CASE("a run that loses its way says diverged, when and why") {
  const Bench bench;
  const Ended ended = bench.run("out", {"--set", "max_speed=0.001"});
  CHECK(ended.code == 1);
  CHECK_THAT(ended.err, Contains("diverged") && Contains("max_speed"));
  const Json out = summary(bench / "out");
  CHECK(out.at("status") == "diverged");
  CHECK(out.at("moment_ns").get<long>() > 1'000'000'000'000'000'000);
  CHECK(out.at("coverage").get<double>() < 0.95);
  CHECK(line_count(bench / "out/trajectory.tum") == line_count(bench / "out/updates.csv") - 1);
}

TEST_CASE("pipes, devices and folders in the place of files are refused by name, before they are read") {
  const Bench bench;
  const std::string pipe = bench / "pipe";
  REQUIRE(::mkfifo(pipe.c_str(), 0600) == 0);
  std::filesystem::create_directory(bench / "folder");
  const auto refused = [&](std::size_t at, const std::string& given, int code) {
    auto arguments = bench.arguments("out", {"--reference", bench / "truth.tum"});
    write_truth(bench / "truth.tum");
    arguments.at(at) = given;
    CAPTURE(arguments.at(at - 1), given);
    // Nobody writes into the pipe: a program that opens it waits for ever.
    const Ended ended = run_aslio(arguments, [waited = 0](pid_t child, const std::string&) mutable {
      if (++waited < 4000) return false;
      ::kill(child, SIGKILL);
      return true;
    });
    CHECK(ended.code == code);
    CHECK_THAT(ended.err, Contains(given));
  };
  constexpr std::size_t kPipeline = 1, kInput = 3, kSensor = 5, kReference = 9;
  for (const std::string& given : {pipe, std::string("/dev/zero")}) {
    refused(kPipeline, given, 2);
    refused(kSensor, given, 2);
    refused(kInput, given, 3);
    refused(kReference, given, 3);
  }
  refused(kReference, (bench / "folder").string(), 3);  // a folder may hold a recording; this one does not
  const std::string schedule = "window={type: replay, file: '" + pipe + "'}";
  const Ended replay =
      run_aslio(bench.arguments("out", {"--set", schedule}), [waited = 0](pid_t child, const std::string&) mutable {
        if (++waited < 4000) return false;
        ::kill(child, SIGKILL);
        return true;
      });
  CHECK(replay.code == 2);
  CHECK_THAT(replay.err, Contains(pipe) && Contains("pipe or device"));
}

TEST_CASE("a trajectory of more than a gigabyte is refused before it is read") {
  const Bench bench;
  write_text(bench / "long.tum", "# poses\n");
  std::filesystem::resize_file(bench / "long.tum", std::uintmax_t{5} << 30U);  // nothing but a hole
  const Ended ended = bench.run("out", {"--reference", bench / "long.tum"});
  CHECK(ended.code == 3);
  CHECK_THAT(ended.err, Contains("long.tum") && Contains("is it the right file?"));
}

TEST_CASE("whatever a stage of others throws ends the run with a message and exit code 1") {
  const Bench bench;
  const auto run = [&](const std::string& fault) {
    return bench.run("out", {"--plugin", ASLIO_FAULTY_PLUGIN, "--set", "window={type: faulty, fault: " + fault + "}"});
  };
  const Ended number = run("throws_int");
  CHECK(number.code == 1);
  CHECK_THAT(number.err, Contains("a stage failed") && Contains("of type 'int'"));
  CHECK(summary(bench / "out").at("status") == "failed");
  const Ended exception = run("throws");
  CHECK(exception.code == 1);
  CHECK_THAT(exception.err, Contains("a stage failed: on purpose"));
  const Ended made = run("made_throws_int");
  CHECK(made.code == 2);
  CHECK_THAT(made.err, Contains("window") && Contains("'faulty' cannot be made") && Contains("of type 'int'"));
  const Ended nowhere = run("throws_where_none_may");
  CHECK(nowhere.code == 1);
  CHECK_THAT(nowhere.err, Contains("unexpected, where nothing can catch it") && Contains("of type 'int'"));
}
