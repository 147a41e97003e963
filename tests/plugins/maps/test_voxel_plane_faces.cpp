// Planes in voxels: the two faces of a wall. (eq. MAP-4)
#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cmath>

#include "plugins/maps/voxel_plane_fixture.hpp"

using namespace aslio;
using namespace aslio::test;

namespace {

/// A wall between y and z of one voxel, its faces at x = 0.3 and 0.4: which of them is met from either side?
struct ThinWall : Planes {
  explicit ThinWall(const std::string& keys)
      : Planes("{type: voxel_plane, voxel: 1.0, levels: 1, min_points: 20" + keys + "}") {}
  /// `count` points of the lower face, seen in the direction `view`, `off` from it along x, of y in [low, high].
  void look(const Vec3& view, int count, double off = 0, double low = 0, double high = 1) {
    std::vector<WorldPoint> points;
    for (int i = 0; i < count; ++i) {
      points.push_back(at(corner + Vec3(0.3 + off, uniform(low, high), uniform(0, 1))));
      points.back().view = PackedDirection(view.cast<float>());
    }
    map->insert(points, 1);
  }
  /// `count` points of a face, seen from `side` (-1: lower x), under any angle up to `slope` off its normal.
  void see(int side, int count, double slope, std::uint32_t stamp = 1) {
    std::vector<WorldPoint> points;
    for (int i = 0; i < count; ++i) {
      points.push_back(at(corner + Vec3(side < 0 ? 0.3 : 0.4, uniform(0, 1), uniform(0, 1))));
      const double y = uniform(-slope, slope), z = uniform(-slope, slope);
      points.back().view = PackedDirection(Vec3(-side, y, z).cast<float>());
    }
    map->insert(points, stamp);
  }
  Surface from(const Vec3& viewpoint, const Vec3& p) {
    MapQuery query;
    query.viewpoint = corner + viewpoint;
    std::vector<Surface> found(1);
    map->surfaces(std::vector<Vec3>{corner + p}, query, found);
    found[0].anchor -= corner;
    return found[0];
  }
};

}  // namespace

// eq. MAP-4.
TEST_CASE("voxel_plane: from either side of a thin wall its own face is met, wherever in the voxel the point lies") {
  ThinWall wall("");
  for (int i = 0; i < 10; ++i) {
    wall.see(-1, 30, i == 0 ? 0.5 : 10.0);
    wall.see(1, 30, i == 0 ? 0.5 : 10.0);
  }
  CHECK(wall.map->size() == 2);
  CHECK(contents(*wall.map).size() == 2);
  for (const double x : {0.25, 0.35, 0.45}) {
    for (const double y : {0.1, 0.9}) {
      const Surface low = wall.from({-3, 4, 1}, {x, y, 0.5}), high = wall.from({3, -5, 1}, {x, y, 0.5});
      REQUIRE(low.valid);
      REQUIRE(high.valid);
      CHECK(std::abs(low.anchor.x() - 0.3) < 1e-5);
      CHECK(std::abs(high.anchor.x() - 0.4) < 1e-5);
    }
  }
  CHECK(wall.at_point({0.35, 0.5, 0.5}).valid);
  wall.map->trim({1e3, 0, 0});
  CHECK(wall.map->size() == 0);
  CHECK(!wall.at_point({0.35, 0.5, 0.5}).valid);
  ThinWall mixed(", faces: false");
  mixed.see(-1, 300, 0.5);
  mixed.see(1, 300, 0.5);
  CHECK(mixed.map->size() == 1);
  CHECK(!mixed.from({-3, 4, 1}, {0.3, 0.5, 0.5}).valid);
}

// eq. MAP-4.
TEST_CASE("voxel_plane: a face that was never seen is not met, and the one that was stays whole under any angle") {
  ThinWall wall("");
  wall.see(-1, 100, 0.2, 1);
  wall.see(-1, 300, 10.0, 2);
  CHECK(wall.map->size() == 1);
  CHECK(wall.from({-3, 0.5, 0.5}, {0.3, 0.5, 0.5}).valid);
  CHECK(!wall.from({3, 0.5, 0.5}, {0.3, 0.5, 0.5}).valid);
  wall.see(1, 100, 0.2, 3);  // its face counts from the update that made it a plane
  MapQuery query;
  query.viewpoint = wall.corner + Vec3(3, 0.5, 0.5);
  query.max_stamp = 2;
  std::vector<Surface> found(1);
  wall.map->surfaces(std::vector<Vec3>{wall.corner + Vec3(0.4, 0.5, 0.5)}, query, found);
  CHECK(!found[0].valid);
  CHECK(wall.from({3, 0.5, 0.5}, {0.4, 0.5, 0.5}).valid);
}

// eq. MAP-4.
TEST_CASE("voxel_plane: a face that was seen from ahead and from behind before it was a plane becomes one again") {
  ThinWall wall("");
  wall.look({0.3, 1, 0}, 15, 0, 0, 0.5);
  wall.look({0.3, -1, 0}, 15, 0, 0.5, 1);
  CHECK(wall.map->size() == 2);
  CHECK_FALSE(wall.at_point({0.3, 0.5, 0.5}).valid);
  wall.look({0.3, 1, 0}, 15, 0, 0, 0.5);
  CHECK(wall.map->size() == 1);
  const Surface ahead = wall.from({-1, -3, 0.5}, {0.3, 0.5, 0.5}), behind = wall.from({-1, 4, 0.5}, {0.3, 0.5, 0.5});
  REQUIRE(ahead.valid);
  REQUIRE(behind.valid);
  CHECK(ahead.anchor == behind.anchor);
  CHECK(std::abs(ahead.anchor.y() - (30 * 0.25 + 15 * 0.75) / 45) < 0.06);  // of all, not of the first part
  CHECK(ahead.quality > 45.0 / (45 + 10 * 4));  // of all 45 points: eq. MAP-2 at the mean of the face, and a margin
  wall.look({0.3, -1, 0}, 15);
  CHECK(wall.map->size() == 1);
}

// eq. MAP-4.
TEST_CASE("voxel_plane: what is of another face, or of another surface before this one, stays apart") {
  ThinWall board("");  // 1 cm thick: less than the thickness of a plane
  board.look({1, 0, 0}, 30);
  board.look({-1, 0, 0}, 30, 0.01);
  board.look({1, 0, 0}, 30);
  CHECK(board.map->size() == 2);
  ThinWall frame("");  // 8 cm in front of the wall, seen under another angle
  frame.look({0.3, 1, 0}, 15);
  frame.look({0.3, -1, 0}, 15, -0.08);
  frame.look({0.3, 1, 0}, 15);
  CHECK(frame.map->size() == 2);
}

// eq. MAP-4.
TEST_CASE("voxel_plane: the side of a plane is known however many points have been seen straight on") {
  for (const double side : {-1.0, 1.0}) {
    ThinWall wall("");
    for (int i = 0; i < 30; ++i) {
      wall.look({side, 0, 0}, 20);
      CAPTURE(side, i);
      REQUIRE(wall.from({-3 * side, 0.5, 0.5}, {0.3, 0.5, 0.5}).valid);
      REQUIRE_FALSE(wall.from({3 * side, 0.5, 0.5}, {0.3, 0.5, 0.5}).valid);
    }
    CHECK(wall.map->size() == 1);
  }
}

// eq. MAP-4.
TEST_CASE("voxel_plane: the other face is no part of this one, though it was seen along the wall") {
  ThinWall wall("");
  wall.look({1, 0, 0}, 30);
  wall.look({-0.03, 1, 0}, 30);  // within the error of its normal
  CHECK(wall.map->size() == 1);
  wall.look({-0.03, 1, 0}, 30, 0.12);
  CHECK(wall.map->size() == 2);
  // Who looks along the wall meets what there is; who looks at its back does not.
  CHECK(wall.from({0.31, -9, 0.5}, {0.3, 0.5, 0.5}).valid);
  ThinWall one_face("");
  one_face.look({1, 0, 0}, 30);
  CHECK(one_face.from({0.5, -9, 0.5}, {0.3, 0.5, 0.5}).valid);
  CHECK_FALSE(one_face.from({3, -3, 0.5}, {0.3, 0.5, 0.5}).valid);
}

// eq. MAP-4.
TEST_CASE("voxel_plane: a corner that was seen on the way out is met on the way back") {
  Planes planes("{type: voxel_plane, voxel: 1.0, levels: 2, min_points: 20}");
  // A wall x = 0.8 over y in [0, 1] and a floor z = 0.2, seen from lower x: no plane together.
  const auto see = [&](double along) {
    std::vector<WorldPoint> points;
    for (int i = 0; i < 400; ++i) {
      const double a = planes.uniform(0, 1), b = planes.uniform(0, 1);
      points.push_back(at(planes.corner + (i % 2 == 0 ? Vec3(0.8, a, 0.2 + 0.8 * b) : Vec3(0.8 * a, b, 0.2))));
      points.back().view = PackedDirection(Vec3(0.4, along, -0.3).cast<float>());
    }
    planes.map->insert(points, 1);
  };
  const auto from = [&](const Vec3& viewpoint, const Vec3& p) {
    MapQuery query;
    query.viewpoint = planes.corner + viewpoint;
    std::vector<Surface> found(1);
    planes.map->surfaces(std::vector<Vec3>{planes.corner + p}, query, found);
    return found[0];
  };
  for (int i = 0; i < 3; ++i) see(1);
  for (const double y : {0.2, 0.8}) {
    for (const double back : {-5.0, 6.0}) {
      CAPTURE(y, back);
      CHECK(from({-3, back, 2}, {0.8, y, 0.8}).valid);
      CHECK(from({-3, back, 2}, {0.2, y, 0.2}).valid);
      CHECK_FALSE(from({4, back, 0.8}, {0.8, y, 0.8}).valid);
      CHECK_FALSE(from({-3, back, -2}, {0.2, y, 0.2}).valid);
    }
  }
  // What is seen on the way back is of the same planes: they count for more.
  const Surface before = from({-3, 6, 2}, {0.8, 0.2, 0.8});
  for (int i = 0; i < 3; ++i) see(-1);
  const Surface after = from({-3, -5, 2}, {0.8, 0.2, 0.8});
  REQUIRE(before.valid);
  REQUIRE(after.valid);
  CHECK(after.quality > before.quality);
  CHECK(std::abs(after.anchor.x() - (planes.corner.x() + 0.8)) < 1e-5);
}

namespace {

/// A thin wall anywhere: its two faces are `thick` apart, and seen under at most 45 deg off their normals.
struct AnyWall {
  AnyWall(Uniform& uniform, const Vec3& centre_W)
      : centre(centre_W),
        normal(uniform.in_box(Vec3::Zero(), 1.0).normalized()),
        first(normal.unitOrthogonal()),
        second(normal.cross(first)),
        thick(uniform(0.1, 0.25)) {}
  Vec3 direction(Uniform& uniform, double side) const {
    const double angle = uniform(-3.14, 3.14), slope = uniform(0, 0.99);
    return side * normal + slope * (std::cos(angle) * first + std::sin(angle) * second);
  }
  Vec3 on_face(Uniform& uniform, double side) const {
    return centre + 1.5 * uniform(-1, 1) * first + 1.5 * uniform(-1, 1) * second - side * thick / 2 * normal;
  }
  Vec3 centre, normal, first, second;
  double thick;
};

}  // namespace

// eq. MAP-4: of random walls, seen from both sides by turns, whoever looks meets the face that looks at him.
TEST_CASE("voxel_plane: no plane is of both faces of a wall, or met from behind, on any level, after any trim") {
  EveryMap fixture;
  for (const int levels : {1, 2, 3}) {
    CAPTURE(levels);
    const auto map = fixture.make("{type: voxel_plane, voxel: 0.5, levels: " + std::to_string(levels) +
                                  ", min_points: 10, max_points: 400, radius: 10}");
    Uniform uniform(static_cast<std::uint64_t>(levels));
    std::size_t met = 0, asked = 0;
    for (int w = 0; w < 60; ++w) {
      CAPTURE(w);
      const AnyWall wall(uniform, uniform.in_box(Vec3(30.0 * w, 0, 0), 1.0));
      map->trim(wall.centre);  // the one before is forgotten: its voxels are used again
      for (std::uint32_t stamp = 1; stamp <= 30; ++stamp) {
        const double side = uniform(-1, 1) < 0 ? -1 : 1;
        std::vector<WorldPoint> points;
        for (int i = 0; i < 200; ++i) {
          points.push_back(at(wall.on_face(uniform, side)));
          points.back().view = PackedDirection(wall.direction(uniform, side).cast<float>());
        }
        map->insert(points, stamp);
      }
      for (const double side : {-1.0, 1.0}) {
        const Vec3 eye = wall.centre - 20 * wall.direction(uniform, side);
        MapQuery query;
        query.viewpoint = eye;
        std::vector<Vec3> queries(200);
        for (Vec3& q : queries) q = wall.on_face(uniform, side) + uniform(-0.05, 0.05) * wall.normal;
        std::vector<Surface> found(queries.size());
        map->surfaces(queries, query, found);
        for (const Surface& surface : found) {
          ++asked;
          if (!surface.valid) continue;
          ++met;
          REQUIRE(std::abs((surface.anchor - wall.centre).dot(wall.normal) + side * wall.thick / 2) < 1e-4);
          REQUIRE(-side * surface.normal.dot(wall.normal) > 1 - 1e-4);  // to the viewer
        }
      }
    }
    CHECK(met > asked * 9 / 10);
    map->trim({-1e4, 0, 0});
    CHECK(map->size() == 0);
  }
}

TEST_CASE("voxel_plane: a closed plane takes no further point of its own side, but those of the other face") {
  EveryMap fixture;
  const auto map = fixture.make("{type: voxel_plane, voxel: 1, max_points: 100}");
  Uniform uniform(6);
  const auto seen = [&](double height, const Vec3& direction, int count) {
    std::vector<WorldPoint> points;
    for (int i = 0; i < count; ++i) {
      points.push_back(at({uniform(0.0, 0.6), uniform(0.0, 0.6), height}));
      points.back().view = PackedDirection(direction.cast<float>());
    }
    return points;
  };
  const Vec3 down(0.1, 0.2, -1), up(0.1, 0.2, 1);
  CHECK(map->insert(seen(0.10, down, 100), 1).inserted == 100);
  CHECK(map->insert(seen(0.10, down, 50), 2).inserted == 0);
  CHECK(map->insert(seen(0.04, up, 50), 3).inserted == 50);
  CHECK(map->insert(seen(0.10, down, 50), 4).inserted == 0);
}

TEST_CASE("voxel_plane: a closed voxel that is no plane goes on until its parts are closed, and has another face") {
  EveryMap fixture;
  const auto map = fixture.make("{type: voxel_plane, voxel: 1, levels: 2, max_points: 100}");
  Uniform uniform(7);
  // Two steps of a stair in one voxel, seen from above; each in a voxel of 0.5 m of its own.
  const Vec3 low = Vec3(1, 1, 1) - Vec3(0.137, 0.223, 0.311);
  const auto stair = [&](double below, const Vec3& direction, int count) {
    std::vector<WorldPoint> points;
    for (int i = 0; i < count; ++i) {
      const double step = i % 2 == 0 ? 0.2 : 0.7;
      points.push_back(at(low + Vec3(uniform(0.01, 0.49), uniform(0.01, 0.49), step - below)));
      points.back().view = PackedDirection(direction.cast<float>());
    }
    return points;
  };
  const Vec3 down(0.1, 0.2, -1), up(0.1, 0.2, 1);
  CHECK(map->insert(stair(0, down, 100), 1).inserted == 100);
  CHECK(map->insert(stair(0, down, 100), 2).inserted == 100);  // into both parts
  CHECK(map->insert(stair(0, down, 100), 3).inserted == 100);  // which hold what came after the first fit
  CHECK(map->insert(stair(0, down, 100), 4).inserted == 0);
  CHECK(map->size() == 1);
  CHECK(map->insert(stair(0.1, up, 50), 5).inserted == 50);
  CHECK(map->size() == 2);
}
