/// aslio overlap: a metric by itself, at given poses.

#include <catch2/catch.hpp>
#include <sstream>

#include "fixture.hpp"

using namespace aslio::test;
using Catch::Matchers::Contains;

namespace {

using Row = std::vector<double>;  ///< an empty cell is -1

std::vector<Row> rows(const std::filesystem::path& csv) {
  std::istringstream lines(content(csv));
  std::string line;
  std::getline(lines, line);
  CHECK(line == "t_ns,points,sod,layer_0,layer_1,layer_2,layer_3,layer_4,layer_5,layer_6,layer_7,sod_moved");
  std::vector<Row> out;
  while (std::getline(lines, line)) {
    line += ',';
    Row row;
    std::size_t begin = 0;
    for (std::size_t end = line.find(','); end != std::string::npos; end = line.find(',', begin)) {
      row.push_back(end == begin ? -1.0 : std::stod(line.substr(begin, end - begin)));
      begin = end + 1;
    }
    REQUIRE(row.size() == 12);
    out.push_back(row);
  }
  return out;
}

struct Scored : Bench {
  explicit Scored(const Recording& recording = {}) : Bench(recording) { write_truth(folder / "truth.tum"); }
  std::vector<std::string> arguments(const std::string& output, const std::vector<std::string>& more) const {
    std::vector<std::string> all = {"overlap",  folder / "pipeline.yaml", "--input",      folder / "recording.bag",
                                    "--sensor", folder / "sensor.yaml",   "--trajectory", folder / "truth.tum",
                                    "--output", folder / output};
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }
  Ended overlap(const std::string& output, const std::vector<std::string>& more = {}) const {
    return run_aslio(arguments(output, more));
  }
};

}  // namespace

TEST_CASE("overlap scores every frame at the poses of a trajectory, and beside them") {
  const Scored bench;
  const std::vector<std::string> off = {"--position-error", "0.02", "--rotation-error", "0.3"};
  const Ended ended = bench.overlap("soft.csv", off);
  INFO(ended.err);
  REQUIRE(ended.code == 0);
  CHECK_THAT(ended.out, Contains("20 of 0.1 s") && Contains("changed by"));
  const auto soft = rows(bench / "soft.csv");
  REQUIRE(soft.size() == 20);
  CHECK(soft.front()[2] == -1.0);  // nothing is known yet
  double moved = 0;
  for (std::size_t i = 2; i < soft.size(); ++i) {
    const Row& row = soft[i];
    CHECK(row[0] - soft[i - 1][0] == Approx(1e8).margin(300));  // as far as a double tells
    CHECK(row[2] == Approx((row[3] + 0.75 * row[4] + 0.5 * row[5] + 0.25 * row[6]) / row[1]).epsilon(1e-12));
    CHECK(row[11] >= 0.0);
    moved += std::abs(row[11] - row[2]);
  }
  CHECK(moved > 0.0);
  CHECK(soft.back()[2] > 0.9);

  CHECK(bench.overlap("again.csv", off).code == 0);
  CHECK(content(bench / "again.csv") == content(bench / "soft.csv"));
  CHECK(bench.overlap("other.csv", {"--position-error", "0.02", "--rotation-error", "0.3", "--seed", "1"}).code == 0);
  CHECK(content(bench / "other.csv") != content(bench / "soft.csv"));

  CHECK(bench.overlap("none.csv", {"--period", "0.05", "--quiet"}).code == 0);
  const auto halves = rows(bench / "none.csv");
  CHECK(halves.size() == 40);
  CHECK(halves.back()[11] == -1.0);
}

TEST_CASE("overlap: a soft margin changes less with the pose than none") {
  const Scored bench;
  const auto change = [&](const std::string& type) {
    const Ended ended = bench.overlap(type + ".csv", {"--set", "overlap={type: " + type + ", voxel: 0.1}",
                                                      "--position-error", "0.05", "--rotation-error", "0.5"});
    INFO(ended.err);
    REQUIRE(ended.code == 0);
    double sum = 0;
    for (const Row& row : rows(bench / (type + ".csv"))) sum += row[2] < 0 ? 0 : std::abs(row[11] - row[2]);
    return sum;
  };
  CHECK(change("hard_voxel") > 1.5 * change("soft_voxel"));
}

TEST_CASE("overlap refuses what it cannot use, and leaves no file") {
  const Scored bench;
  const Ended no_poses = run_aslio({"overlap", bench / "pipeline.yaml", "--input", bench / "recording.bag", "--sensor",
                                    bench / "sensor.yaml", "--output", bench / "out.csv"});
  CHECK(no_poses.code == 2);
  CHECK_THAT(no_poses.err, Contains("--trajectory"));
  const Ended itself = bench.overlap("truth.tum");
  CHECK(itself.code == 2);
  CHECK_THAT(itself.err, Contains("truth.tum") && Contains("is read"));
  write_text(bench / "elsewhere.tum", "1.0 0 0 0 0 0 0 1\n2.0 0 0 0 0 0 0 1\n");
  const Ended other =
      run_aslio({"overlap", bench / "pipeline.yaml", "--input", bench / "recording.bag", "--sensor",
                 bench / "sensor.yaml", "--trajectory", bench / "elsewhere.tum", "--output", bench / "out.csv"});
  CHECK(other.code == 3);
  CHECK_THAT(other.err, Contains("elsewhere.tum") && Contains("no pose"));
  CHECK_FALSE(std::filesystem::exists(bench / "out.csv"));
  const Ended wrong = bench.overlap("out.csv", {"--set", "overlap.voxle=0.2"});
  CHECK(wrong.code == 2);
  CHECK_THAT(wrong.err, Contains("voxle"));
  CHECK(bench.overlap("out.csv", {"--period", "0"}).code == 2);
}

TEST_CASE("overlap: a disk that fills up leaves no file that ends in the middle") {
  const Scored bench;
  const Ended ended = run_aslio_with_file_limit(bench.arguments("sod.csv", {"--period", "0.001"}), 20'000);
  INFO(ended.err);
  CHECK(ended.code == 3);
  CHECK_THAT(ended.err, Contains("sod.csv: cannot write: File too large") && !Contains("frames before"));
  CHECK_FALSE(std::filesystem::exists(bench / "sod.csv"));
}

TEST_CASE("overlap: a metric that throws ends it, and the frames before stand") {
  const Scored bench;
  const Ended ended = bench.overlap(
      "sod.csv", {"--plugin", ASLIO_FAULTY_PLUGIN, "--set", "overlap={type: faulty, frames: 7}", "--quiet"});
  INFO(ended.err);
  CHECK(ended.code == 1);
  CHECK_THAT(ended.err, Contains("knows no more frames; ") && Contains("sod.csv has the 7 frames before"));
  CHECK(rows(bench / "sod.csv").size() == 7);
  const Ended at_once = bench.overlap(
      "none.csv", {"--plugin", ASLIO_FAULTY_PLUGIN, "--set", "overlap={type: faulty, frames: 0}", "--quiet"});
  CHECK(at_once.code == 1);
  CHECK_THAT(at_once.err, Contains("knows no more frames") && !Contains("frames before"));
  CHECK_FALSE(std::filesystem::exists(bench / "none.csv"));
}

TEST_CASE("overlap: an input that is damaged on the way ends it, and the frames before are those of the whole") {
  const Scored bench(Recording{.duration = 8.0});
  REQUIRE(bench.overlap("whole.csv").code == 0);
  // The record header of a message behind the 5 s that are looked at when the bag is opened; not the first after that
  // place, before which the header of its chunk may stand: all of those are met then.
  std::string bag = content(bench / "recording.bag");
  const std::size_t message = bag.find("time=", bag.find("time=", bag.size() / 10 * 9) + 1);
  REQUIRE(message != std::string::npos);
  bag.replace(message - 40, 50, 50, '\xff');
  write_text(bench / "recording.bag", bag);
  const Ended ended = bench.overlap("sod.csv");
  INFO(ended.err);
  CHECK(ended.code == 3);
  CHECK_THAT(ended.err, Contains("recording.bag: damaged") && Contains("sod.csv has the "));
  const std::string whole = content(bench / "whole.csv"), kept = content(bench / "sod.csv");
  CHECK(line_count(bench / "sod.csv") > 50);
  CHECK(line_count(bench / "sod.csv") < 80);
  CHECK(whole.starts_with(kept));
}
