#include <catch2/catch.hpp>

#include "aslio/core/errors.hpp"
#include "aslio/simulator/simulation.hpp"
#include "simulator/box_room.hpp"

using namespace aslio;
using namespace aslio::simulator;
using Catch::Matchers::Contains;

namespace {

std::string message(const std::string& yaml) {
  const aslio::test::TemporaryFolder folder;
  try {
    load_scene(folder.write("s.yaml", yaml));
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "no error";
}

}  // namespace

TEST_CASE("a scene file reads back to the same text", "[scene]") {
  const aslio::test::TemporaryFolder folder;
  const SceneFile file = simulator::test::room(folder, "imu: {preset: ideal, rate: 400}\nlidar: {range_noise: 0.03}\n");
  CHECK(file.scene.imu.preset == ImuPreset::ideal);
  CHECK(file.scene.imu.rate == 400);
  CHECK(file.scene.lidar.range_noise == 0.03);
  CHECK(file.scene.route.size() == 5);
  CHECK(file.scene.walk.standstill == 0.5);
  const SceneFile again = load_scene(folder.write("again.yaml", file.resolved));
  CHECK(again.resolved == file.resolved);
}

TEST_CASE("what is wrong in a scene file is named with its place", "[scene]") {
  const std::string head = "schema: aslio/scene/1\n";
  CHECK_THAT(message(head + "sensor: aviia\n"), Contains("s.yaml:2:9") && Contains("avia"));
  CHECK_THAT(message(head + "wrold: {type: office}\n"), Contains("s.yaml:2:1") && Contains("world"));
  CHECK_THAT(message(head + "world: {type: campus, corridor_width: 2}\n"),
             Contains("s.yaml:2:23") && Contains("corridor_width"));
  CHECK_THAT(message(head + "route: [{x: 0, y: zero}]\n"), Contains("s.yaml:2:19"));
  CHECK_THAT(message(head + "imu: {preset: best}\n"), Contains("s.yaml:2:15") && Contains("datasheet"));
  CHECK_THAT(message(head), Contains("route"));
  CHECK_THAT(message(head + "route: [{x: 0, y: 0}, {x: 9, y: 0}]\nfollow: {file: a.tum}\n"), Contains("route"));
  CHECK_THAT(message("schema: aslio/pipeline/1\n"), Contains("scene"));
}

TEST_CASE("overrides change a scene", "[scene]") {
  const aslio::test::TemporaryFolder folder;
  const auto path = folder.write("s.yaml", simulator::test::room_scene());
  const SceneFile file = load_scene(path, {"imu.preset=perfect", "people.walking=3", "route.1.x=9"});
  CHECK(file.scene.imu.preset == ImuPreset::perfect);
  CHECK(file.scene.people.walking == 3);
  CHECK(file.scene.route[1].x == 9);
  CHECK_THROWS_WITH(load_scene(path, {"imu.speed=1"}), Contains("imu.speed=1"));
}

TEST_CASE("a simulation says what it cannot use", "[scene]") {
  const aslio::test::TemporaryFolder folder;
  const SceneFile file = simulator::test::room(folder);
  CHECK_THROWS_WITH(Simulation(file, {.scale = 100}), Contains("scale is 100"));
  std::filesystem::remove(folder / "room.obj");
  CHECK_THROWS_WITH(Simulation(file, {}), Contains("room.obj"));
  const SceneFile follows = load_scene(folder.write("f.yaml",
                                                    "schema: aslio/scene/1\nworld: {type: mesh, file: room.obj}\n"
                                                    "follow: {file: absent.tum}\n"));
  folder.write("room.obj", simulator::test::kRoomObj);
  CHECK_THROWS_WITH(Simulation(follows, {}), Contains("absent.tum"));
  CHECK_THROWS_WITH(Simulation(follows, {.scale = 2}), Contains("no route to scale"));
}
