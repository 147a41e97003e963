/// `aslio simulate`, over a bare room that is quick to cast rays in.

#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>

#include "child.hpp"
#include "recordings.hpp"

using namespace aslio::test;
using Catch::Matchers::Contains;

namespace {

namespace fs = std::filesystem;

/// A room of 12 x 12 x 3 m about the origin.
constexpr const char* kRoom =
    "v -6 -6 0\nv 6 -6 0\nv 6 6 0\nv -6 6 0\nv -6 -6 3\nv 6 -6 3\nv 6 6 3\nv -6 6 3\n"
    "f 1 2 3 4\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";

/// A scene in that room; `more` are further lines of its block `walk`.
struct Stage {
  TemporaryFolder folder;

  explicit Stage(const std::string& more = "") {
    write_text(folder / "room.obj", kRoom);
    write_text(folder / "small.yaml",
               "schema: aslio/scene/1\n"
               "world: {type: mesh, file: room.obj}\n"
               "route: [{x: -1, y: -1}, {x: 1, y: -1}, {x: 1, y: 1}, {x: -1, y: 1}]\n"
               "imu: {preset: ideal}\n"
               "walk:\n"
               "  speed: 3\n"
               "  corner_speed: 2\n"
               "  standstill: 0.5\n" +
                   more);
  }
  fs::path operator/(const std::string& name) const { return folder / name; }
  std::vector<std::string> arguments(const std::vector<std::string>& more = {}) const {
    std::vector<std::string> all = {"simulate", folder / "small.yaml", "--output", folder / "out"};
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }
  Ended run(const std::vector<std::string>& more = {}) const { return run_aslio(arguments(more)); }
};

const std::vector<std::string> kFiles = {"dataset.yaml", "overlap.csv", "preview.svg", "scene.yaml",
                                         "sensor.yaml",  "small.bag",   "truth.csv",   "truth.tum"};

std::vector<std::string> names_in(const fs::path& folder) {
  std::vector<std::string> names;
  if (!fs::exists(folder)) return names;
  for (const auto& entry : fs::directory_iterator(folder)) names.push_back(entry.path().filename());
  std::sort(names.begin(), names.end());
  return names;
}

/// Nothing half-written: no temporary file, and neither the bag nor the file that says that the others are whole.
void check_nothing_half_written(const fs::path& folder) {
  for (const std::string& name : names_in(folder)) {
    INFO(name);
    CHECK(std::find(kFiles.begin(), kFiles.end(), name) != kFiles.end());
    CHECK(name != "small.bag");
    CHECK(name != "dataset.yaml");
  }
}

}  // namespace

TEST_CASE("a simulation leaves a dataset that a run takes") {
  const Stage stage;
  const Ended ended = stage.run({"--threads", "2"});
  INFO(ended.err);
  REQUIRE(ended.code == 0);
  CHECK(names_in(stage / "out") == kFiles);
  CHECK_THAT(ended.out, Contains("path ") && Contains("of the LiDAR") && Contains("rays returned") &&
                            Contains("million rays/s") && Contains("small.bag") && Contains("--dataset"));
  CHECK_THAT(ended.err, Contains("x real time") && Contains(" %"));
  const Ended check =
      run_aslio({"check", stage / "out/dataset.yaml", stage / "out/scene.yaml", stage / "out/sensor.yaml"});
  INFO(check.err);
  CHECK(check.code == 0);
  write_text(stage / "pipeline.yaml", pipeline_text());
  const Ended run = run_aslio({"run", stage / "pipeline.yaml", "--dataset", stage / "out", "--output", stage / "run",
                               "--set", "estimator.time_offset=true"});
  INFO(run.err);
  CHECK(run.code == 0);
  CHECK_THAT(run.out, Contains("accuracy     ATE") && Contains("calibration  IMU delay "));
  CHECK_THAT(content(stage / "run/summary.json"), Contains("\"imu_delay_s\": ") && !Contains("\"imu_delay_s\": null"));
}

TEST_CASE("a seed makes the same bag for any number of threads, another seed another one") {
  const Stage stage;
  std::vector<std::string> bags;
  for (const auto& [seed, threads] : {std::pair("7", "1"), std::pair("7", "2"), std::pair("8", "2")}) {
    REQUIRE(stage.run({"--seed", seed, "--threads", threads, "--quiet", "--set", "walk.standstill=0"}).code == 0);
    bags.push_back(content(stage / "out/small.bag"));
  }
  CHECK(bags[0].size() > 100'000);
  CHECK(bags[0] == bags[1]);
  CHECK(bags[0] != bags[2]);
}

TEST_CASE("quiet is quiet, and options change what is simulated") {
  const Stage stage;
  const Ended ended = stage.run({"--quiet", "--sensor", "spin16", "--set", "imu.rate=100", "--no-compression"});
  INFO(ended.err);
  REQUIRE(ended.code == 0);
  CHECK(ended.out.empty());
  CHECK(ended.err.empty());
  CHECK_THAT(content(stage / "out/scene.yaml"), Contains("rate: 100"));
  const Ended inspected = run_aslio({"inspect", stage / "out/small.bag", "--sensor", stage / "out/sensor.yaml"});
  CHECK(inspected.code == 0);
  CHECK_THAT(inspected.out, Contains("PointCloud2"));
}

TEST_CASE("what is wrong with a scene is told with its place") {
  const Stage stage("  spede: 1\n");
  const Ended key = stage.run();
  CHECK(key.code == 2);
  CHECK_THAT(key.err, Contains("small.yaml:9:3: ") && Contains("'walk.spede'") && Contains("did you mean 'speed'"));
  const Ended value = stage.run({"--set", "walk.speed=-1"});
  CHECK(value.code == 2);
  CHECK_THAT(value.err, Contains("--set walk.speed=-1"));
  const Ended gone = run_aslio({"simulate", stage / "gone.yaml", "--output", stage / "out"});
  CHECK(gone.code == 2);
  CHECK_THAT(gone.err, Contains("SCENE") && Contains("gone.yaml"));
  CHECK_FALSE(fs::exists(stage / "out"));
}

TEST_CASE("arguments of a simulation that make no sense are refused with what would") {
  struct Case {
    const char *option, *value, *message;
  };
  const Case cases[] = {{"--sensor", "avai", "unknown sensor 'avai' (did you mean 'avia'?); there are: avia, mid360"},
                        {"--sensor", "camera", "unknown sensor 'camera'; there are: avia, mid360, spin16"},
                        {"--scale", "0.01", "'0.01' is out of range; give a number from 0.1 to 3"},
                        {"--scale", "big", "'big' is not a number"},
                        {"--scale", "nan", "'nan' is out of range"},
                        {"--threads", "0", "'0' is out of range; give a whole number from 1 to 256"},
                        {"--seed", "-1", "'-1' is negative"}};
  const Stage stage;
  for (const Case& c : cases) {
    const Ended ended = stage.run({c.option, c.value});
    INFO(c.option << " " << c.value);
    CHECK(ended.code == 2);
    CHECK_THAT(ended.err, Contains(std::string(c.option) + ": ") && Contains(c.message));
    CHECK_FALSE(fs::exists(stage / "out"));
  }
}

TEST_CASE("a scene may have a lower limit of the scale of its own, as docs/cli.md says") {
  const TemporaryFolder folder;
  const std::string scene = std::string(ASLIO_SOURCE_DIR) + "/configs/scenes/quickstart.yaml";
  const Ended ended = run_aslio({"simulate", scene, "--scale", "0.19", "--output", folder / "out"});
  CHECK(ended.code == 2);
  CHECK_THAT(ended.err, Contains("must be at least 1 m") && Contains("a larger scale") && Contains("(at scale 0.19)"));
  CHECK_FALSE(fs::exists(folder / "out"));
  CHECK_THAT(content(std::string(ASLIO_SOURCE_DIR) + "/docs/cli.md"), Contains("`quickstart` needs 0.2"));
}

TEST_CASE("a mesh that is not there is named, and nothing is written") {
  const Stage stage;
  fs::remove(stage / "room.obj");
  const Ended ended = stage.run();
  CHECK(ended.code == 3);
  CHECK_THAT(ended.err, Contains("room.obj"));
  CHECK_FALSE(fs::exists(stage / "out"));
}

TEST_CASE("a simulation does not overwrite what it reads") {
  const Stage stage;
  fs::create_directories(stage / "out");
  fs::copy_file(stage / "small.yaml", stage / "out/scene.yaml");
  fs::copy_file(stage / "room.obj", stage / "out/room.obj");
  const std::string before = content(stage / "out/scene.yaml");
  const Ended ended = run_aslio({"simulate", stage / "out/scene.yaml", "--output", stage / "out"});
  CHECK(ended.code == 2);
  CHECK_THAT(ended.err, Contains("scene.yaml would be overwritten"));
  CHECK(content(stage / "out/scene.yaml") == before);
  write_text(stage / "file", "");
  const Ended no_folder = run_aslio({"simulate", stage / "small.yaml", "--output", stage / "file"});
  CHECK(no_folder.code == 2);
  CHECK_THAT(no_folder.err, Contains("--output") && Contains("name a folder that exists or can be created"));
}

TEST_CASE("a folder that cannot be written is found before anything is simulated") {
  const Stage stage;
  const fs::path closed = stage / "closed";
  fs::create_directories(closed);
  write_text(closed / "dataset.yaml", "kept");
  fs::permissions(closed, fs::perms::owner_read | fs::perms::owner_exec);
  std::vector<std::string> folders = {"/proc"};              // which nobody can write
  if (::geteuid() != 0) folders.push_back(closed.string());  // root can write all others
  for (const std::string& folder : folders) {
    const Ended ended = run_aslio({"simulate", stage / "small.yaml", "--output", folder});
    INFO(folder << ": " << ended.err);
    CHECK(ended.code == 2);
    CHECK_THAT(ended.err, Contains("--output " + folder + ": ") && Contains("name a folder that can be written") &&
                              !Contains("real time"));
  }
  fs::permissions(closed, fs::perms::owner_all);
  CHECK(names_in(closed) == std::vector<std::string>{"dataset.yaml"});
  CHECK(content(closed / "dataset.yaml") == "kept");
}

TEST_CASE("a description may hold any character, and the dataset says it as the scene does") {
  const Stage stage;
  // YAML's own escapes: of the scene file, so that the character itself is in the value.
  const Ended ended = stage.run({"--quiet", "--set", "description=\"a\\x01b\\t\\\"c\\\" d\\\\e \\u00e4\""});
  INFO(ended.err);
  REQUIRE(ended.code == 0);
  const Ended check = run_aslio({"check", stage / "out/dataset.yaml", stage / "out/scene.yaml"});
  INFO(check.err);
  CHECK(check.code == 0);
  const auto description = [](const std::string& text) {
    const std::size_t begin = text.find("description: ");
    return text.substr(begin, text.find('\n', begin) - begin);
  };
  CHECK_THAT(content(stage / "out/dataset.yaml"), Contains("a\\x01b"));
  CHECK(description(content(stage / "out/dataset.yaml")) == description(content(stage / "out/scene.yaml")));
}

TEST_CASE("an interrupted simulation exits with 130 and leaves nothing half-written") {
  const Stage stage("  laps: 40\n");
  const auto arguments = stage.arguments({"--threads", "1"});
  const Ended ended = run_aslio(arguments, [](pid_t child, const std::string& err) {
    if (err.find("real time") == std::string::npos) return false;  // the first line of progress
    ::kill(child, SIGINT);
    return true;
  });
  INFO(ended.err);
  CHECK(ended.code == 130);
  CHECK_THAT(ended.err, Contains("interrupted"));
  check_nothing_half_written(stage / "out");
}

TEST_CASE("the surfaces of the world are written, and make the same world again") {
  const Stage stage;
  const Ended ended = stage.run({"--quiet", "--save-world", stage / "world.ply"});
  INFO(ended.err);
  REQUIRE(ended.code == 0);
  CHECK(content(stage / "world.ply").starts_with("ply\n"));
  const std::string truth = content(stage / "out/truth.tum"), overlap = content(stage / "out/overlap.csv");
  const Ended again = stage.run({"--quiet", "--set", "world.file=world.ply"});
  INFO(again.err);
  REQUIRE(again.code == 0);
  CHECK(content(stage / "out/truth.tum") == truth);
  CHECK(content(stage / "out/overlap.csv") == overlap);
  const Ended own = stage.run({"--save-world", stage / "room.obj"});
  CHECK(own.code == 2);
  CHECK_THAT(own.err, Contains("--save-world") && Contains("room.obj would be overwritten"));
}

TEST_CASE("a full disk ends a simulation with 3, names the file and leaves nothing half-written") {
  const Stage stage;
  const Ended ended = run_aslio_with_file_limit(stage.arguments(), 100'000);
  INFO(ended.err);
  CHECK(ended.code == 3);
  CHECK_THAT(ended.err, Contains("small.bag"));
  check_nothing_half_written(stage / "out");
}
