/// Panes and mirrors.

#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <string>

#include "aslio/simulator/simulation.hpp"
#include "lidar/glass.hpp"
#include "simulator/box_room.hpp"

using namespace aslio;
using namespace aslio::simulator;

TEST_CASE("a pane mirrors what Fresnel's equations say", "[realism]") {
  const double one = std::pow((1.52 - 1) / (1.52 + 1), 2);
  CHECK(mirrored_share(1) == Approx(2 * one / (1 + one)));
  CHECK(mirrored_share(0) == Approx(1));
  // Brewster's angle: light polarised in the plane of incidence passes, so little is mirrored.
  CHECK(mirrored_share(std::cos(std::atan(1.52))) == Approx(0.14).margin(0.02));
  CHECK(mirrored_share(0.3) > mirrored_share(0.6));
}

TEST_CASE("the draw decides between return, mirror and passage by their shares", "[realism]") {
  CHECK(pane_effect(0.95, 0.9, 1) == PaneEffect::returned);
  CHECK(pane_effect(0.01, 0.9, 1) == PaneEffect::mirrored);
  CHECK(pane_effect(0.5, 0.9, 1) == PaneEffect::passed);
  CHECK(pane_effect(0, 0, 1) == PaneEffect::returned);
  CHECK(pane_effect(0.89, 0.9, 0) == PaneEffect::mirrored);
}

namespace {

/// Share of the points of a packet on a pane that hangs before the east wall, and behind it on the wall.
struct Shares {
  double pane = 0, wall = 0, beyond = 0;
};

Shares seen_through(double clear, double back = 12) {
  const aslio::test::TemporaryFolder folder;
  // A pane of material::kGlass, 1 m before the wall at x = 13.
  std::string ply =
      "ply\nformat ascii 1.0\nelement vertex 16\nproperty float x\nproperty float y\nproperty float z\n"
      "property uchar red\nproperty uchar green\nproperty uchar blue\n"
      "element face 8\nproperty list uchar int vertex_indices\nend_header\n";
  for (const char* corner : {"-3 -3 0", "13 -3 0", "13 7 0", "-3 7 0", "-3 -3 3", "13 -3 3", "13 7 3", "-3 7 3"})
    ply += fmt::format("{} 190 190 190\n", corner);
  for (const double face : {12.0, back})
    for (const char* corner : {"-3 0", "7 0", "7 3", "-3 3"}) ply += fmt::format("{} {} 12 12 12\n", face, corner);
  folder.write("pane.ply",
               ply + "4 0 1 2 3\n4 4 5 6 7\n4 0 1 5 4\n4 1 2 6 5\n4 2 3 7 6\n4 3 0 4 7\n4 8 9 10 11\n4 12 13 14 15\n");
  const SceneFile file = load_scene(folder.write(
      "pane.yaml",
      "schema: aslio/scene/1\nworld: {type: mesh, file: pane.ply}\n"
      "route: [{x: 5, y: 0}, {x: 10, y: 0}, {x: 10, y: 4}, {x: 0, y: 4}, {x: 0, y: 0}]\n"
      "walk: {standstill: 0.5, gait: smooth}\nlidar: {range_noise: 0, angle_noise: 0, mixed: 0, outliers: 0}\n" +
          fmt::format("realism: {{glass: {}}}\n", clear)));
  const Simulation simulation(file, {});
  Shares shares;
  double count = 0;
  // Straight ahead, at rest: the beams of the middle meet the pane.
  for (const TimedPoint& point : simulation.packet(0).packet.points) {
    const MotionState m = simulation.motion().at(to_seconds(point.t - simulation.begin_time()));
    const Vec3 p = Pose{m.R, m.p} * (simulation.sensor().T_imu_lidar * Vec3(point.x, point.y, point.z));
    const Vec3 direction = (p - m.p).normalized();
    if (direction.x() < 0.99) continue;
    ++count;
    shares.pane += std::abs(p.x() - 12) < 1e-3 ? 1 : 0;
    shares.wall += std::abs(p.x() - 13) < 1e-3 ? 1 : 0;
    shares.beyond += p.x() > 13.001 ? 1 : 0;
  }
  REQUIRE(count > 300);
  return {shares.pane / count, shares.wall / count, shares.beyond / count};
}

}  // namespace

TEST_CASE("the two faces of a pane of glass are one pane", "[realism]") {
  // 2 cm thick, as the worlds build them.
  const Shares shares = seen_through(0.9, 12.02);
  CHECK(shares.pane == Approx(0.1).margin(0.04));
  CHECK(shares.wall == Approx(0.9 * (1 - mirrored_share(1))).margin(0.06));
}

TEST_CASE("an opaque pane hides the wall behind it", "[realism]") {
  const Shares shares = seen_through(0);
  CHECK(shares.pane == 1);
}

TEST_CASE("a clear pane shows the wall behind it, and mirror images beyond", "[realism]") {
  const Shares shares = seen_through(0.9);
  CHECK(shares.pane == Approx(0.1).margin(0.04));
  CHECK(shares.wall == Approx(0.9 * (1 - mirrored_share(1))).margin(0.06));
  CHECK(shares.beyond == Approx(0.9 * mirrored_share(1)).margin(0.04));
}
