#include <Eigen/Geometry>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "aslio/simulator/caster.hpp"
#include "aslio/simulator/mesh.hpp"
#include "simulator/mesh/rays.hpp"

using namespace aslio;
using namespace aslio::simulator;
using aslio::test::any_direction;

namespace {

Vec3 corner(const Mesh& mesh, std::uint32_t index) { return mesh.vertices[index].cast<double>(); }

double area(const Mesh& mesh) {
  double sum = 0;
  for (const Mesh::Triangle& t : mesh.triangles) {
    const Vec3 a = corner(mesh, t.a), b = corner(mesh, t.b), c = corner(mesh, t.c);
    sum += 0.5 * (b - a).cross(c - a).norm();
  }
  return sum;
}

/// By the divergence theorem: positive when all normals point out.
double volume(const Mesh& mesh) {
  double sum = 0;
  for (const Mesh::Triangle& t : mesh.triangles)
    sum += corner(mesh, t.a).cross(corner(mesh, t.b)).dot(corner(mesh, t.c)) / 6;
  return sum;
}

struct Solid {
  std::string name;
  Mesh mesh;
  Vec3 inside;  ///< a point that sees the whole surface
  double area, volume;
};

/// Each stands turned and away from the origin, where no corner is a round number.
std::vector<Solid> solids() {
  const Placement placement{{7.3, -4.1, 0.37}, 0.77};
  std::vector<Solid> all;
  const auto add = [&](const std::string& name, const Vec3& inside, double area, double volume, const auto& build) {
    MeshBuilder builder;
    const auto placed = builder.place(placement);
    build(builder);
    const Vec3 turned = Eigen::AngleAxisd(placement.yaw, Vec3::UnitZ()) * inside + placement.origin;
    all.push_back({name, builder.take(), turned, area, volume});
  };
  add("box", {0.5, 1.0, 2.0}, 2 * (2 + 3 + 6), 6, [](MeshBuilder& b) { b.box({0, 0, 0.5}, {1, 2, 3.5}, 10); });
  const int n = 12;
  const double wedge = std::numbers::pi / n, sector = n * std::sin(wedge) * std::cos(wedge);  // area / radius^2
  const double slant = std::hypot(2.0, (0.5 - 0.2) * std::cos(wedge));
  add("frustum", {0, 0, 1}, sector * (0.25 + 0.04) + n * std::sin(wedge) * (0.5 + 0.2) * slant,
      2.0 / 3 * sector * (0.25 + 0.1 + 0.04), [](MeshBuilder& b) {
        b.frustum({0, 0, 0}, 0.5, 0.2, 2, n, 10);
      });
  add("extrusion", {0.3, 1, 0.3}, 3 * (2 + std::sqrt(2.0)) + 1, 1.5, [](MeshBuilder& b) {
    const std::array<Vec2, 3> profile{Vec2(0, 0), Vec2(0, 1), Vec2(1, 0)};
    b.extrude(profile, 0, 3, 10);
  });
  return all;
}

Mesh ellipsoid(int rings) {
  MeshBuilder builder;
  const auto placed = builder.place({{3, 2, 1}, 0.4});
  builder.ellipsoid({0.5, 0, 0}, {1, 2, 3}, rings, 10);
  return builder.take();
}

void check_closed(const Solid& solid) {
  INFO(solid.name);
  const Caster caster{Mesh(solid.mesh)};
  RandomStream random(9, 0);
  std::vector<Vec3> corners, targets;
  for (const Mesh::Triangle& t : solid.mesh.triangles) {
    const Vec3 a = corner(solid.mesh, t.a), b = corner(solid.mesh, t.b), c = corner(solid.mesh, t.c);
    corners.push_back(a);
    targets.insert(targets.end(), {0.5 * (a + b), 0.3 * b + 0.7 * c, 0.9 * c + 0.1 * a, (a + b + c) / 3});
  }
  int missed_inside = 0, missed_outside = 0;
  const auto probe_inside = [&](const Vec3& direction) {
    missed_inside += std::isinf(caster.cast(solid.inside, direction, 100).range);
  };
  const auto probe = [&](const Vec3& direction) {
    probe_inside(direction);
    // From outside towards a point within: the surface is in between.
    missed_outside += caster.cast(solid.inside - 40 * direction, direction, 100).range > 40;
  };
  // Not from far outside: see the note on corners of Caster::cast().
  for (const Vec3& at : corners) probe_inside((at - solid.inside).normalized());
  for (const Vec3& target : targets) probe((target - solid.inside).normalized());
  for (int i = 0; i < 5000; ++i) probe(any_direction(random));
  CHECK(missed_inside == 0);
  CHECK(missed_outside == 0);
}

}  // namespace

TEST_CASE("area and volume of solids are those of the closed form") {
  for (const Solid& solid : solids()) {
    INFO(solid.name);
    CHECK(area(solid.mesh) == Approx(solid.area).epsilon(1e-5));
    CHECK(volume(solid.mesh) == Approx(solid.volume).epsilon(1e-4));
  }
}

TEST_CASE("an ellipsoid approaches its volume with the square of the step") {
  const double exact = 4.0 / 3 * std::numbers::pi * 6;
  const double coarse = exact - volume(ellipsoid(8)), fine = exact - volume(ellipsoid(16));
  CHECK(coarse > 0);
  CHECK(coarse / fine == Approx(4).epsilon(0.1));
}

TEST_CASE("no ray passes between the faces of a solid") {
  for (const Solid& solid : solids()) check_closed(solid);
  check_closed(
      {"ellipsoid", ellipsoid(9), Eigen::AngleAxisd(0.4, Vec3::UnitZ()) * Vec3(0.5, 0, 0) + Vec3(3, 2, 1), 0, 0});
}

TEST_CASE("placements nest and end with their scope") {
  MeshBuilder builder;
  const auto upright = [](const Placement& p) {
    return Eigen::Translation3d(p.origin) * Eigen::AngleAxisd(p.yaw, Vec3::UnitZ());
  };
  const Placement outer{{1, 2, 3}, 0.5}, inner{{-4, 0.5, 0.25}, -1.2};
  const Vec3 p(0.3, 0.7, 0.9), q(1, 0, 0), r(0, 1, 0);
  {
    const auto first = builder.place(outer);
    {
      const auto second = builder.place(inner);
      builder.triangle(p, q, r, 1);
    }
    builder.triangle(p, q, r, 2);
  }
  builder.triangle(p, q, r, 3);
  const Mesh mesh = builder.take();
  REQUIRE(mesh.vertices.size() == 9);
  CHECK((corner(mesh, 0) - upright(outer) * (upright(inner) * p)).norm() < 1e-6);
  CHECK((corner(mesh, 3) - upright(outer) * p).norm() < 1e-6);
  CHECK((corner(mesh, 6) - p).norm() < 1e-6);
  CHECK(mesh.reflectivity == std::vector<std::uint8_t>{1, 2, 3});
}

TEST_CASE("terrain has the given height at its grid and is no steeper between") {
  const auto height = [](double x, double y) { return 0.4 * std::sin(0.3 * x) + 0.02 * x * y; };
  MeshBuilder builder;
  builder.terrain({-10, -6}, {10, 7}, 0.7, 10, height);
  const Mesh mesh = builder.take();
  const int nx = 29, ny = 19;  // steps of at most 0.7 m
  REQUIRE(mesh.triangles.size() == static_cast<std::size_t>(2 * nx * ny));
  const Caster caster{Mesh(mesh)};
  RandomStream random(4, 0);
  double worst = 0;
  for (int i = 0; i < 2000; ++i) {
    const double x = random.uniform(-9.99, 9.99), y = random.uniform(-5.99, 6.99);
    const SurfaceHit hit = caster.cast({x, y, 50}, -Vec3::UnitZ(), 100);
    worst = std::max(worst, std::abs(50 - hit.range - height(x, y)));
  }
  CHECK(worst < 0.7 * 0.7 / 8 * (0.4 * 0.09 + 2 * 0.02));  // error of linear interpolation
  for (const Eigen::Vector3f& v : mesh.vertices) {
    const Vec3 p = v.cast<double>();
    CHECK(std::abs(p.z() - height(p.x(), p.y())) < 1e-6);
  }
}

TEST_CASE("an appended mesh keeps its triangles") {
  MeshBuilder first, second;
  first.slab({0, 0}, {1, 1}, 0, 20);
  second.box({2, 2, 2}, {3, 3, 3}, 30);
  Mesh both = first.take();
  both.append(second.mesh());
  CHECK(both.triangles.size() == 14);
  CHECK(both.reflectivity.size() == 14);
  CHECK(area(both) == Approx(7));
  CHECK(both.reflectivity[1] == 20);
  CHECK(both.reflectivity[2] == 30);
}
