/// The preset, its parts, and that each part leaves the others as they are.

#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cmath>
#include <set>
#include <string>

#include "aslio/core/angles.hpp"
#include "simulator/box_room.hpp"
#include "simulator/record/recorded.hpp"

using namespace aslio;
using namespace aslio::simulator;
using namespace aslio::simulator::test;

namespace {

std::string part(const std::string& name) { return "realism: {preset: realistic, parts: [" + name + "]}\n"; }

}  // namespace

TEST_CASE("no realism is the recording without the key", "[realism]") {
  const std::string plain = Recorded().result.bag_sha256;
  CHECK(Recorded("realism: {preset: none}\n").result.bag_sha256 == plain);
  CHECK(Recorded("realism: {preset: realistic, parts: []}\n").result.bag_sha256 == plain);
  CHECK(Recorded("realism: {preset: realistic}\n").result.bag_sha256 != plain);
}

TEST_CASE("each part changes the recording or its sensor file, in a way of its own", "[realism]") {
  std::set<std::string> seen{Recorded().result.bag_sha256};
  // A bare room of type mesh has no glass and its own surfaces, and the mount is the sensor file's.
  for (const std::string name : {"clock", "ranging", "footprint", "gait", "imu"}) {
    CAPTURE(name);
    CHECK(seen.insert(Recorded(part(name)).result.bag_sha256).second);
  }
  for (const std::string name : {"mount", "surface", "glass"}) {
    CAPTURE(name);
    CHECK_FALSE(seen.insert(Recorded(part(name)).result.bag_sha256).second);
  }
}

TEST_CASE("a realistic recording is the same for any number of threads", "[realism]") {
  CHECK(Recorded("realism: {preset: realistic}\n", 1).result.bag_sha256 ==
        Recorded("realism: {preset: realistic}\n", 3).result.bag_sha256);
}

TEST_CASE("a mount is off by a tenth to half of a degree and 3 to 10 mm", "[realism]") {
  const aslio::test::TemporaryFolder folder;
  const SceneFile file = room(folder, part("mount"));
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const Simulation simulation(file, {.seed = seed});
    const Pose &truth = simulation.sensor().T_imu_lidar, &claimed = simulation.claimed_sensor().T_imu_lidar;
    const double angle = Eigen::AngleAxisd(claimed.R * truth.R.transpose()).angle() / kRadPerDeg;
    const double offset = (claimed.p - truth.p).norm();
    CHECK(angle >= 0.1);
    CHECK(angle <= 0.5);
    CHECK(offset >= 0.003);
    CHECK(offset <= 0.010);
  }
}

TEST_CASE("the world of a scene has rough surfaces, and the same ones for every seed", "[realism]") {
  const aslio::test::TemporaryFolder folder;
  const auto scene = [&](const std::string& more) {
    return load_scene(folder.write("office.yaml",
                                   "schema: aslio/scene/1\nworld: {type: office}\nroute: [{x: 0, y: 0}, {x: 12, y: 0}, "
                                   "{x: 12, y: 8}, {x: 0, y: 8}]\nlidar: {noise: false}\n" +
                                       more));
  };
  const Simulation flat(scene(""), {}), rough(scene(part("surface")), {});
  const auto &a = flat.packet(0).packet.points, &b = rough.packet(0).packet.points;
  REQUIRE(a.size() == b.size());
  double squares = 0;
  for (std::size_t k = 0; k < a.size(); ++k)
    squares += (Vec3(a[k].x, a[k].y, a[k].z) - Vec3(b[k].x, b[k].y, b[k].z)).squaredNorm();
  const double rms = std::sqrt(squares / static_cast<double>(a.size()));
  CHECK(rms > 0.001);
  CHECK(rms < 0.02);
}

TEST_CASE("a magnitude goes before the preset, and a wrong one is refused with its key", "[realism]") {
  const aslio::test::TemporaryFolder folder;
  const SceneFile file = room(folder, "realism: {preset: realistic, mount: {angle: 0}, ranging: {offset: 0.5}}\n");
  const Realism r = realism(file.scene.realism);
  CHECK(r.mount.angle == 0);
  CHECK(r.mount.offset == 0.010);
  CHECK(r.ranging.offset == 0.5);
  CHECK(r.imu.filter == 0.005);
  CHECK_THROWS_WITH(room(folder, "realism: {parts: [mounts]}\n"),
                    Catch::Contains("mounts") && Catch::Contains("mount"));
  CHECK_THROWS_WITH(room(folder, "realism: {glass: 2}\n"), Catch::Contains("glass"));
}
