#include <catch2/catch.hpp>

#include "fixture.hpp"

using namespace aslio::test;
using Catch::Matchers::Contains;

TEST_CASE("describe gives every parameter with its default, unit and meaning") {
  const Ended ended = run_aslio({"describe", "windows/fixed"});
  CHECK(ended.code == 0);
  CHECK_THAT(ended.out, Contains("period") && Contains("0.1") && Contains("time between updates"));
  const Ended wrong = run_aslio({"describe", "windows/fixd"});
  CHECK(wrong.code == 2);
  CHECK_THAT(wrong.err, Contains("fixd") && Contains("fixed"));
}

TEST_CASE("describe lists the types of a family") {
  const Ended ended = run_aslio({"describe", "windows"});
  CHECK(ended.code == 0);
  CHECK_THAT(ended.out, Contains("\n  sod_adaptive ") && Contains("aslio describe windows/TYPE"));
}

TEST_CASE("describe explains the keys of files") {
  const Ended pipeline = run_aslio({"describe", "pipeline"});
  CHECK(pipeline.code == 0);
  CHECK_THAT(pipeline.out, Contains("schema: aslio/pipeline/1") && Contains("max_speed: number") &&
                               Contains("default 60") && Contains("windows: ") && Contains("sod_adaptive"));
  const Ended sensor = run_aslio({"describe", "sensor"});
  CHECK(sensor.code == 0);
  CHECK_THAT(sensor.out, Contains("schema: aslio/sensor/1") && Contains("acc_unit: ") && Contains("T_imu_lidar"));
}

TEST_CASE("describe tells the keys of a scene, with those of every type of world") {
  const Ended text = run_aslio({"describe", "scene"});
  CHECK(text.code == 0);
  CHECK_THAT(text.out, Contains("schema: aslio/scene/1") && Contains("walk.glances.N.angle: number") &&
                           Contains("lidar.noise: true|false") && Contains("stress.packet_loss"));
  const std::string types =
      "office|garage|library|campus|approach|doorway|stairwell|old_town|tunnel|forest|escalator_hall|street|mesh";
  std::string joined = text.out;  // the list is broken over two lines
  for (std::size_t at = joined.find("\n  |"); at != std::string::npos; at = joined.find("\n  |")) joined.erase(at, 3);
  CHECK_THAT(joined, Contains("world.type: one of " + types + ","));
  std::size_t from = 0;
  for (const char* type : {"office", "garage", "library", "campus", "approach", "doorway", "stairwell", "old_town",
                           "tunnel", "forest", "escalator_hall", "street", "mesh"}) {
    INFO(type);
    const std::size_t at = text.out.find(std::string("\nworld of type ") + type + "\n\n  world.", from);
    REQUIRE(at != std::string::npos);
    from = at;
  }
  CHECK_THAT(text.out, Contains("\nmotion: drive\n") && Contains("drive.start_speed: number") &&
                           Contains("cars.oncoming: integer"));
  const std::size_t office = text.out.find("world of type office");
  CHECK(text.out.find("world.corridor_width") > office);
  CHECK(text.out.find("world.file: text") > text.out.find("world of type mesh"));
}

TEST_CASE("describe gives the keys of any file as Markdown") {
  for (const char* file : {"pipeline", "sensor", "dataset", "scene", "study"}) {
    const Ended ended = run_aslio({"describe", file, "--markdown"});
    INFO(file);
    CHECK(ended.code == 0);
    CHECK_THAT(ended.out, Contains(std::string("# ") + file + " file\n\nBegins with `schema: aslio/" + file + "/1`") &&
                              Contains("| key | type | unit | range | default | meaning |\n|---|"));
  }
  CHECK_THAT(run_aslio({"describe", "scene", "--markdown"}).out, Contains("\n## world of type garage\n\n| key |"));
  const Ended wrong = run_aslio({"describe", "scenery"});
  CHECK(wrong.code == 2);
  CHECK_THAT(wrong.err, Contains("'study' or 'external'"));
}
