/// References of `aslio run`, `aslio evaluate` and datasets: what they are read from, and the keys that say what they
/// are.

#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "aslio/core/trajectory.hpp"
#include "aslio/io/writers.hpp"
#include "fixture.hpp"

using namespace aslio::test;
using aslio::Vec3;
using Catch::Matchers::Contains;

namespace {

nlohmann::json json(const std::filesystem::path& file) { return nlohmann::json::parse(content(file)); }

/// The true motion as `t x y z` of a point of the IMU frame, from an origin far away.
void write_point(const std::filesystem::path& tum, const std::filesystem::path& csv, const Vec3& point) {
  std::string text = "stamp_us,east,north,up\n";
  for (const aslio::StampedPose& pose : aslio::io::read_tum(tum)) {
    const Vec3 p = pose.T * point + Vec3(744073.25, 2553112.5, 10);
    text += fmt::format("{},{:.9f},{:.9f},{:.9f}\n", pose.t / 1000, p.x(), p.y(), p.z());
  }
  write_text(csv, text);
}

}  // namespace

TEST_CASE("evaluate reads a table of a point, with its unit, columns and lever arm") {
  const TemporaryFolder folder;
  write_truth(folder / "truth.tum");
  write_point(folder / "truth.tum", folder / "point.csv", Vec3(0.3, -0.2, 0.5));
  std::vector<std::string> command = {"evaluate",        folder / "truth.tum",
                                      "--reference",     folder / "point.csv",
                                      "--reference-set", "lever_arm=[0.3, -0.2, 0.5]",
                                      "--reference-set", "columns=[t=stamp_us, x=east, y=north, z=up]"};
  const Ended text = run_aslio(command);
  INFO(text.err);
  REQUIRE(text.code == 0);
  CHECK_THAT(text.out, Contains("reference: positions only (there is no orientation): no rotation error is measured") &&
                           Contains("reference: stamps are in us (by their size)") &&
                           Contains("reference: positions from the first on, which is (74"));
  command.emplace_back("--json");
  const auto found = nlohmann::json::parse(run_aslio(command).out);
  CHECK(found.at("ate_m").get<double>() < 1e-3);
  CHECK(found.at("ate_deg").is_null());
  command[5] = "lever_arm=[0, 0, 0]";
  CHECK(nlohmann::json::parse(run_aslio(command).out).at("ate_m").get<double>() > found.at("ate_m").get<double>());
  command[5] = "lever_arm=[0, 0]";
  const Ended wrong = run_aslio(command);
  CHECK(wrong.code == 2);
  CHECK_THAT(wrong.err, Contains("must be 3 numbers"));
}

TEST_CASE("a reference file, a block of a dataset and options say the same") {
  const Bench bench;
  write_truth(bench / "truth.tum");
  write_point(bench / "truth.tum", bench / "point.csv", Vec3(0.3, -0.2, 0.5));
  const std::string keys =
      "columns: [t=stamp_us, x=east, y=north, z=up]\nframe: prism\n"
      "transforms: [{parent: imu, child: prism, translation: [0.3, -0.2, 0.5]}]\n";
  write_text(bench / "reference.yaml", "schema: aslio/reference/1\nfile: point.csv\n" + keys);
  CHECK(run_aslio({"check", bench / "reference.yaml"}).code == 0);
  const Ended by_file = bench.run("by_file", {"--reference", bench / "reference.yaml"});
  INFO(by_file.err);
  REQUIRE(by_file.code == 0);
  CHECK_THAT(by_file.out,
             Contains("no rotation;") && Contains("reference    reference point at (0.3000, -0.2000, 0.5000)"));
  const auto metrics = json(bench / "by_file/summary.json").at("metrics");
  CHECK(metrics.at("ate_m").is_number());
  CHECK(metrics.at("ate_deg").is_null());
  std::string block;
  for (const std::string& line :
       {std::string("file: point.csv"), std::string("columns: [t=stamp_us, x=east, y=north, z=up]"),
        std::string("lever_arm: [0.3, -0.2, 0.5]")}) {
    block += "  " + line + "\n";
  }
  write_text(bench / "data.yaml",
             "schema: aslio/dataset/1\ninput: recording.bag\nsensor: sensor.yaml\nreference:\n" + block);
  CHECK(run_aslio({"check", bench / "data.yaml"}).code == 0);
  const Ended by_block =
      run_aslio({"run", bench / "pipeline.yaml", "--dataset", bench / "data.yaml", "--output", bench / "by_block"});
  INFO(by_block.err);
  REQUIRE(by_block.code == 0);
  CHECK(json(bench / "by_block/summary.json").at("metrics").at("ate_m").get<double>() ==
        Approx(metrics.at("ate_m").get<double>()).epsilon(1e-9));
  // The manifest holds all that is needed to read it again.
  const auto reference = json(bench / "by_file/manifest.json").at("reference");
  CHECK_THAT(reference.at("resolved").get<std::string>(), Contains("T_imu_reference") && Contains("0.3, -0.2, 0.5"));
  const Ended later = run_aslio({"run", bench / "pipeline.yaml", "--dataset", bench / "data.yaml", "--output",
                                 bench / "later", "--reference-set", "time_offset=1000"});
  CHECK(later.code == 3);
  CHECK_THAT(later.err, Contains("no time in common") && Contains("`time_offset`"));
}

TEST_CASE("keys of a reference that is not there are refused, and a frame that is not known") {
  const Bench bench;
  write_truth(bench / "truth.tum");
  const Ended none = bench.run("out", {"--reference-set", "time_unit=ns"});
  CHECK(none.code == 2);
  CHECK_THAT(none.err, Contains("--reference-set changes a reference, and there is none"));
  const Ended frame = bench.run("out", {"--reference", bench / "truth.tum", "--reference-set", "frame=base"});
  CHECK(frame.code == 2);
  CHECK_THAT(frame.err, Contains("no transform leads from frame 'imu' to 'base'; there are: imu, lidar"));
  const Ended unknown = run_aslio(
      {"evaluate", bench / "truth.tum", "--reference", bench / "truth.tum", "--reference-set", "frame=lidar"});
  CHECK(unknown.code == 2);
  CHECK_THAT(unknown.err, Contains("there are: none"));
  const Ended lidar = run_aslio({"evaluate", bench / "truth.tum", "--reference", bench / "truth.tum", "--reference-set",
                                 "frame=lidar", "--sensor", bench / "sensor.yaml", "--json"});
  REQUIRE(lidar.code == 0);
  CHECK(nlohmann::json::parse(lidar.out).at("ate_m").get<double>() > 1e-4);
}
