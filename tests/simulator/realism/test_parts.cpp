/// The preset, its parts, and that each part leaves the others as they are.

#include <Eigen/Geometry>
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <set>
#include <string>
#include <vector>

#include "aslio/core/angles.hpp"
#include "mesh/roughness.hpp"
#include "simulator/box_room.hpp"
#include "simulator/record/recorded.hpp"

using namespace aslio;
using namespace aslio::simulator;
using namespace aslio::simulator::test;

namespace {

SceneFile office(const aslio::test::TemporaryFolder& folder, const std::string& more) {
  const std::string world = more.find("world:") == std::string::npos ? "world: {type: office}\n" : "";
  return load_scene(folder.write("office.yaml",
                                 "schema: aslio/scene/1\nroute: [{x: 0, y: 0}, {x: 14, y: 0}, {x: 14, y: "
                                 "9}, {x: 0, y: 9}]\n" +
                                     world + more));
}

/// Of the first 2 s of a recording.
std::string digest(const std::string& more, int threads = 1) {
  return Recorded(more, threads, {.duration = 2}).result.bag_sha256;
}

std::string part(const std::string& name) { return "realism: {preset: realistic, parts: [" + name + "]}\n"; }

}  // namespace

TEST_CASE("no realism is the recording without the key", "[realism]") {
  const std::string plain = digest("");
  CHECK(digest("realism: {preset: none}\n") == plain);
  CHECK(digest("realism: {preset: realistic, parts: []}\n") == plain);
  CHECK(digest("realism: {preset: realistic}\n") != plain);
}

TEST_CASE("each part changes the recording or its sensor file, in a way of its own", "[realism]") {
  std::set<std::string> seen{digest("")};
  // A bare room of type mesh has no glass and its own surfaces, and the mount is the sensor file's.
  for (const std::string name : {"clock", "ranging", "footprint", "gait", "imu"}) {
    CAPTURE(name);
    CHECK(seen.insert(digest(part(name))).second);
  }
  for (const std::string name : {"mount", "surface", "glass"}) {
    CAPTURE(name);
    CHECK_FALSE(seen.insert(digest(part(name))).second);
  }
}

TEST_CASE("a realistic recording is the same for any number of threads", "[realism]") {
  CHECK(digest("realism: {preset: realistic}\n") == digest("realism: {preset: realistic}\n", 3));
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

TEST_CASE("each part leaves IMU, truth, points and people of the others as they are", "[realism]") {
  const aslio::test::TemporaryFolder folder;
  const auto simulated = [&](const std::string& more) {
    return Simulation(office(folder, more + "people: {walking: 2, ahead: 1}\n"), {.duration = 4});
  };
  const auto same_imu = [](const Simulation& a, const Simulation& b) {
    return std::equal(a.imu().samples.begin(), a.imu().samples.end(), b.imu().samples.begin(), b.imu().samples.end(),
                      [](const auto& x, const auto& y) { return x.t == y.t && x.gyro == y.gyro && x.acc == y.acc; });
  };
  const auto same_points = [](const Simulation& a, const Simulation& b) {
    const auto p = a.packet(30).packet.points, q = b.packet(30).packet.points;
    return std::equal(p.begin(), p.end(), q.begin(), q.end(), [](const auto& x, const auto& y) {
      return x.t == y.t && x.x == y.x && x.y == y.y && x.z == y.z;
    });
  };
  const Simulation plain = simulated("");
  for (const std::string name : {"mount", "clock", "ranging", "footprint", "surface", "glass"}) {
    CAPTURE(name);
    CHECK(same_imu(plain, simulated(part(name))));
  }
  for (const std::string name : {"mount", "clock", "imu"}) {
    CAPTURE(name);
    CHECK(same_points(plain, simulated(part(name))));
  }
  for (const std::string name : {"ranging", "footprint", "surface", "gait"}) {
    CAPTURE(name);
    CHECK_FALSE(same_points(plain, simulated(part(name))));
  }
  CHECK_FALSE(same_imu(plain, simulated(part("imu"))));
  const Simulation walked = simulated(part("gait"));
  CHECK_FALSE(same_imu(plain, walked));
  for (std::size_t person = 0; person < plain.people().size(); ++person)
    CHECK(plain.people().position(person, 3) == walked.people().position(person, 3));
}

TEST_CASE("panes of a world become clear with the part glass", "[realism]") {
  const auto points = [&](const std::string& more) {
    const SceneFile file = load_scene(ASLIO_SOURCE_DIR "/configs/scenes/outdoor_1.yaml",
                                      {"realism.preset=realistic", "realism.parts=[glass]", "realism.glass=" + more});
    const Simulation simulation(file, {.scale = 0.2, .duration = 0.6});
    std::size_t count = 0;
    for (std::size_t k = 0; k < simulation.packet_count(); ++k) count += simulation.packet(k).packet.points.size();
    return count;
  };
  CHECK(points("0.9") != points("0"));
}

TEST_CASE("the clock of the IMU drifts and its stamps jitter, in order", "[realism]") {
  const auto errors = [](const std::string& more, std::uint64_t seed) {
    const Stamps imu = stamps(Recorded(more, 1, {.seed = seed, .duration = 4}), "/livox/imu");
    std::vector<double> us;
    for (std::size_t k = 0; k < imu.stamp.size(); ++k) {
      if (k > 0) REQUIRE(imu.stamp[k] > imu.stamp[k - 1]);
      us.push_back(1e-3 * static_cast<double>(imu.stamp[k] - imu.arrival[k]));
    }
    return us;
  };
  bool fast = false, slow = false;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    const std::vector<double> drift = errors("realism: {clock: {drift: 20}}\n", seed);
    // 1 to 20 ppm, 200 samples per second.
    const double ppm = drift.back() / (static_cast<double>(drift.size() - 1) / 200);
    CHECK(std::abs(ppm) > 0.9);
    CHECK(std::abs(ppm) < 20.1);
    fast = fast || ppm > 0;
    slow = slow || ppm < 0;
  }
  CHECK(fast);
  CHECK(slow);
  const std::vector<double> jitter = errors("realism: {clock: {jitter: 500}}\n", 1);
  double squares = 0;
  for (const double us : jitter) squares += us * us;
  const double deviation = std::sqrt(squares / static_cast<double>(jitter.size()));
  CHECK(deviation > 45);
  CHECK(deviation < 550);
}

TEST_CASE("a run saturates the accelerometer of 3 g", "[realism]") {
  const aslio::test::TemporaryFolder folder;
  const auto clipped = [&](const std::string& more) {
    const Simulation simulation(office(folder, "walk: {gait: running, speed: 2.5}\n" + more), {});
    return std::count_if(simulation.imu().samples.begin(), simulation.imu().samples.end(), [](const ImuSample& sample) {
      return sample.acc.cwiseAbs().maxCoeff() >= 3 * kStandardGravity * (1 - 1e-12);
    });
  };
  CHECK(clipped("") == 0);
  CHECK(clipped(part("gait")) > 20);
}

TEST_CASE("the world of a scene has rough surfaces, and the same ones for every seed", "[realism]") {
  const aslio::test::TemporaryFolder folder;
  const auto scene = [&](const std::string& more) { return office(folder, "lidar: {noise: false}\n" + more); };
  const Simulation flat(scene(""), {}), rough(scene(part("surface")), {}), again(scene(part("surface")), {.seed = 7});
  for (double y = 0; y < 5; y += 0.3)
    CHECK(rough.roughness().displacement({1, y, 1}, material::kPlaster) ==
          again.roughness().displacement({1, y, 1}, material::kPlaster));
  const Simulation other(scene("world: {type: office, seed: 2}\n" + part("surface")), {});
  CHECK(rough.roughness().displacement({1, 1, 1}, material::kPlaster) !=
        other.roughness().displacement({1, 1, 1}, material::kPlaster));
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
  CHECK(r.imu.filter == 1);
  CHECK_THROWS_WITH(room(folder, "realism: {parts: [mounts]}\n"),
                    Catch::Contains("mounts") && Catch::Contains("mount"));
  CHECK_THROWS_WITH(room(folder, "realism: {glass: 2}\n"), Catch::Contains("glass"));
  CHECK_THROWS_WITH(room(folder, "realism: {parts: [mount]}\n"), Catch::Contains("give preset: realistic"));
  CHECK_THROWS_WITH(room(folder, "realism: {surface: {relief: 1}}\n"), Catch::Contains("realism.surface"));
}
