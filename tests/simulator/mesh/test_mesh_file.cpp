#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <string>

#include "aslio/core/errors.hpp"
#include "aslio/simulator/caster.hpp"
#include "aslio/simulator/mesh_file.hpp"
#include "temporary_folder.hpp"

using namespace aslio;
using namespace aslio::simulator;

namespace {

/// A wall at x = 2 as one quadrilateral, 2 m wide and 1 m high, in text.
const std::string kWallPly =
    "ply\nformat ascii 1.0\ncomment a wall\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
    "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
    "2 -1 0\n2 1 0\n2 1 1\n2 -1 1\n4 0 1 2 3\n";
const std::string kWallObj =
    "# a wall\no wall\nv 2 -1 0\nv 2 1 0\nv 2 1 1\nv 2 -1 1\nvn -1 0 0\nf 1//1 2//1 3//1 4//1\n";

std::string replaced(std::string text, const std::string& what, const std::string& by) {
  const std::size_t at = text.find(what);
  REQUIRE(at != std::string::npos);
  return text.replace(at, what.size(), by);
}

template <class T>
void put(std::string& out, T value, bool big_endian) {
  std::string bytes(sizeof(T), '\0');
  std::memcpy(bytes.data(), &value, sizeof(T));
  if (big_endian) bytes.assign(bytes.rbegin(), bytes.rend());
  out += bytes;
}

/// The wall with colours, in binary.
std::string binary_wall(bool big_endian) {
  std::string ply = std::string("ply\nformat binary_") + (big_endian ? "big" : "little") +
                    "_endian 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
                    "property uchar red\nproperty uchar green\nproperty uchar blue\n"
                    "element face 2\nproperty list uchar int vertex_indices\nend_header\n";
  const float corners[4][3] = {{2, -1, 0}, {2, 1, 0}, {2, 1, 1}, {2, -1, 1}};
  for (const auto& corner : corners) {
    for (const float x : corner) put(ply, x, big_endian);
    for (int channel = 0; channel < 3; ++channel) put(ply, std::uint8_t{51}, big_endian);
  }
  for (const std::int32_t second : {1, 2}) {
    put(ply, std::uint8_t{3}, big_endian);
    for (const std::int32_t index : {0, second, second + 1}) put(ply, index, big_endian);
  }
  return ply;
}

World load(const std::filesystem::path& path, double unit = 1) {
  return load_mesh_world(path, {.file = path.filename().string(), .unit = unit});
}

/// Where a ray from the origin of a 2 m x 1 m wall at x = 2 meets what was read.
void check_wall(const World& world, double unit, double reflectivity) {
  CHECK(world.mesh.triangles.size() == 2);
  CHECK(world.mesh.reflectivity.size() == 2);
  const Caster caster{Mesh(world.mesh)};
  for (const double y : {-0.9, 0.0, 0.9}) {
    const Vec3 origin(0, unit * y, unit * 0.5);
    const SurfaceHit hit = caster.cast(origin, Vec3::UnitX(), 1e5);
    CHECK(hit.range == Approx(2 * unit));
    CHECK(hit.cos_incidence == Approx(1));
    CHECK(hit.reflectivity == Approx(reflectivity).margin(0.5 / 255));
  }
  CHECK(std::isinf(caster.cast(Vec3(0, unit * 1.01, unit * 0.5), Vec3::UnitX(), 1e5).range));
  CHECK(std::isinf(caster.cast(Vec3(0, 0, unit * 1.01), Vec3::UnitX(), 1e5).range));
  CHECK(world.ground.height(3, 4) == 0);
}

std::string refusal(const std::filesystem::path& path, double unit = 1) {
  try {
    load(path, unit);
  } catch (const DataError& error) {
    const std::string what = error.what();
    CHECK(what.rfind(path.string(), 0) == 0);
    return what;
  }
  return "accepted";
}

}  // namespace

TEST_CASE("a wall is the same from text and binary files in either format") {
  const aslio::test::TemporaryFolder folder;
  check_wall(load(folder.write("wall.ply", kWallPly)), 1, 0.4);
  check_wall(load(folder.write("wall.PLY", kWallPly)), 1, 0.4);
  check_wall(load(folder.write("wall.obj", kWallObj)), 1, 0.4);
  check_wall(load(folder.write("little.ply", binary_wall(false))), 1, 0.2);
  check_wall(load(folder.write("big.ply", binary_wall(true))), 1, 0.2);
}

TEST_CASE("units and reflectivity of a mesh file are as given") {
  const aslio::test::TemporaryFolder folder;
  const auto path = folder.write("wall.obj", kWallObj);
  check_wall(load(path, 0.001), 0.001, 0.4);
  check_wall(load(path, 25.4), 25.4, 0.4);
  const World bright = load_mesh_world(path, {.file = "wall.obj", .unit = 1, .reflectivity = 0.8});
  check_wall(bright, 1, 0.8);
}

TEST_CASE("brightness of vertex colours is the reflectivity") {
  const aslio::test::TemporaryFolder folder;
  std::string ply = replaced(kWallPly, "property float z\n",
                             "property float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n");
  for (const char* corner : {"\n2 -1 0", "\n2 1 0", "\n2 1 1", "\n2 -1 1"})
    ply = replaced(ply, fmt::format("{}\n", corner), fmt::format("{} 0 255 0\n", corner));
  check_wall(load(folder.write("green.ply", ply)), 1, 0.7152);
}

TEST_CASE("parts, lines and points of a file: all faces are read, nothing else") {
  const aslio::test::TemporaryFolder folder;
  const std::string two = kWallObj + "o floor\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 5 6 7\nl 5 6\np 7\n";
  const World world = load(folder.write("two.obj", two));
  CHECK(world.mesh.triangles.size() == 3);
  CHECK(Caster{Mesh(world.mesh)}.cast({0.2, 0.2, 1}, -Vec3::UnitZ(), 10).range == Approx(1));
}

TEST_CASE("mesh files that are not there or not meshes are refused by name and with a remedy") {
  const aslio::test::TemporaryFolder folder;
  CHECK_THAT(refusal(folder / "none.ply"), Catch::Contains("does not exist"));
  CHECK_THAT(refusal(folder.path()), Catch::Contains("is a directory") && Catch::Contains("name the .ply or .obj"));
  CHECK_THAT(refusal(folder.write("empty.ply", "")), Catch::Contains("is empty"));
  CHECK_THAT(refusal(folder.write("wall.stl", "solid\n")), Catch::Contains("convert it to .ply or .obj"));
  CHECK_THAT(refusal(folder.write("wall", kWallPly)), Catch::Contains("with that extension"));
  CHECK_THAT(refusal(folder.write("text.obj", "hello\n")), Catch::Contains("text.obj"));
  const std::string cloud = kWallPly.substr(0, kWallPly.find("4 0 1 2 3"));
  CHECK_THAT(refusal(folder.write("cloud.ply", replaced(cloud, "element face 1", "element face 0"))),
             Catch::Contains("4 points but no faces") && Catch::Contains("Reconstruct a surface"));
  CHECK_THAT(refusal(folder.write("cloud.obj", kWallObj.substr(0, kWallObj.find("f 1//1")))),
             !Catch::Equals("accepted"));
}

TEST_CASE("damaged PLY headers are refused with the line") {
  const aslio::test::TemporaryFolder folder;
  const auto of = [&](const std::string& text) { return refusal(folder.write("bad.ply", text)); };
  CHECK_THAT(of(replaced(kWallPly, "ply", "PLY1")), Catch::Contains("its first line is not \"ply\""));
  CHECK_THAT(of(kWallPly.substr(0, 60)), Catch::Contains("no \"end_header\""));
  CHECK_THAT(of(std::string(100'000, 'x')), Catch::Contains("not a PLY file"));
  CHECK_THAT(of(fmt::format("ply\n{:x>100000}", "")), Catch::Contains("no \"end_header\""));
  for (const char* count : {"4000000000", "99999999999999999999999999", "-4", "four", "4e9"})
    CHECK_THAT(of(replaced(kWallPly, "element vertex 4", fmt::format("element vertex {}", count))),
               Catch::Contains(fmt::format("bad.ply:4: \"element vertex {}\" does not fit a file of", count)));
  CHECK_THAT(of(replaced(kWallPly, "element face 1", "element face 1000000000")), Catch::Contains("bad.ply:8:"));
  CHECK_THAT(of(replaced(kWallPly, "format ascii 1.0", "format braille 1.0")), !Catch::Equals("accepted"));
}

TEST_CASE("damaged contents of a mesh file are refused") {
  const aslio::test::TemporaryFolder folder;
  const auto of = [&](const std::string& text) { return refusal(folder.write("bad.ply", text)); };
  CHECK_THAT(of(replaced(kWallPly, "2 1 1\n", "2 nan 1\n")), Catch::Contains("not finite"));
  CHECK_THAT(of(replaced(kWallPly, "2 1 1\n", "2 inf 1\n")), !Catch::Equals("accepted"));
  CHECK_THAT(of(replaced(kWallPly, "2 1 1\n", "2 1e7 1\n")),
             Catch::Contains("more than 100 km from the origin") && Catch::Contains("correct unit"));
  CHECK_THAT(of(replaced(kWallPly, "4 0 1 2 3", "4 0 1 2 9")), Catch::Contains("vertex 9 of 4"));
  CHECK_THAT(of(replaced(kWallPly, "4 0 1 2 3", "4 0 1 2 -1")), !Catch::Equals("accepted"));
  CHECK_THAT(of(replaced(kWallPly, "element face 1", "element face 2")),
             Catch::Contains("6 elements are announced, 5 lines are there"));
  CHECK_THAT(of(replaced(kWallPly, "element vertex 4", "element vertex 5")),
             Catch::Contains("6 elements are announced"));
  CHECK_THAT(of(replaced(kWallPly, "4 0 1 2 3\n", "4 0 1 2")),
             Catch::Contains("cut off: its last line \"4 0 1 2\" lists 3 of 4 values"));
  for (const std::size_t lost : {1U, 9U, 14U, 30U, 60U}) {
    CAPTURE(lost);
    const std::string whole = binary_wall(false);
    CHECK_THAT(of(whole.substr(0, whole.size() - lost)), !Catch::Equals("accepted"));
  }
  CHECK_THAT(refusal(folder.write("bad.obj", replaced(kWallObj, "4//1\n", "9//1\n"))), !Catch::Equals("accepted"));
  CHECK_THAT(refusal(folder.write("far.obj", kWallObj), 1e5), Catch::Contains("correct unit"));
  std::string nan = binary_wall(false);
  const std::size_t first = nan.find("end_header\n") + 11;
  const std::uint32_t bits = 0x7fc00000;
  std::memcpy(nan.data() + first, &bits, sizeof bits);
  CHECK_THAT(of(nan), Catch::Contains("not finite: repair the mesh"));
}

TEST_CASE("a mesh that is written is read back with the same surfaces") {
  const test::TemporaryFolder folder;
  Mesh mesh;
  mesh.vertices = {{0, 0, 0}, {4, 0, 0.5F}, {4, 3, 0}, {0, 3, 1}, {1, 1, 2.5F}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}, {1, 2, 4}};
  mesh.reflectivity = {100, 100, 100};
  const std::filesystem::path path = folder / "world.ply";
  write_mesh(mesh, path);
  const World world = load_mesh_world(path, {});
  REQUIRE(world.mesh.triangles.size() == mesh.triangles.size());
  // Vertices may be merged and renumbered, corners stay where they were.
  for (std::size_t k = 0; k < mesh.triangles.size(); ++k) {
    const auto &a = mesh.triangles[k], &b = world.mesh.triangles[k];
    CHECK(world.mesh.vertices[b.a] == mesh.vertices[a.a]);
    CHECK(world.mesh.vertices[b.b] == mesh.vertices[a.b]);
    CHECK(world.mesh.vertices[b.c] == mesh.vertices[a.c]);
  }
  CHECK_THROWS_AS(write_mesh(mesh, path / "no" / "such.ply"), DataError);
}
