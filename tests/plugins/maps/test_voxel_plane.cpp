// Planes in voxels: levels, closing, flatness. (eq. MAP-1)
#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <limits>

#include "aslio/core/errors.hpp"
#include "aslio/toolkit/cell_batch.hpp"
#include "plugins/maps/voxel_plane_fixture.hpp"

using namespace aslio;
using namespace aslio::test;

TEST_CASE("voxel_plane: a step that spoils the coarse voxel is told apart by the finer ones") {
  for (const int levels : {1, 2}) {
    CAPTURE(levels);
    Planes planes("{type: voxel_plane, voxel: 1.0, levels: " + std::to_string(levels) + "}");
    for (int i = 0; i < 5; ++i) {
      planes.floor(0.0, 0.5, 0.2, 60);
      planes.floor(0.5, 1.0, 0.4, 60);
    }
    const Surface low = planes.at_point({0.25, 0.25, 0.21}), high = planes.at_point({0.75, 0.25, 0.38});
    REQUIRE(low.valid == (levels == 2));
    REQUIRE(high.valid == (levels == 2));
    if (levels == 1) continue;
    CHECK(std::abs(low.anchor.z() - 0.2) < 1e-6);
    CHECK(std::abs(high.anchor.z() - 0.4) < 1e-6);
  }
}

TEST_CASE("voxel_plane: a voxel that is full is closed, so that later points do not move it") {
  Planes planes("{type: voxel_plane, voxel: 1.0, levels: 1, max_points: 100}");
  CHECK(planes.floor(0, 1, 0.2, 100) == 100);
  const Surface before = planes.at_point({0.5, 0.5, 0.2});
  REQUIRE(before.valid);
  CHECK(planes.floor(0, 1, 0.25, 500, 2) == 0);
  const Surface after = planes.at_point({0.5, 0.5, 0.2});
  CHECK(after.anchor == before.anchor);
  CHECK(after.normal == before.normal);
}

TEST_CASE("voxel_plane: a plane counts from the update that made it one") {
  Planes planes("{type: voxel_plane, voxel: 1.0, levels: 1, min_points: 20}");
  planes.floor(0, 1, 0.2, 10, 1);
  CHECK(!planes.at_point({0.5, 0.5, 0.2}).valid);
  planes.floor(0, 1, 0.2, 30, 5);
  CHECK(planes.at_point({0.5, 0.5, 0.2}, 5).valid);
  CHECK(!planes.at_point({0.5, 0.5, 0.2}, 4).valid);
}

TEST_CASE("voxel_plane: a plane counts less the fewer points it has, and beyond them") {
  const auto quality = [](double doubt, int points, const Vec3& at) {
    Planes planes("{type: voxel_plane, voxel: 1.0, levels: 1, doubt: " + std::to_string(doubt) + "}");
    planes.floor(0.0, 0.5, 0.2, points, 1, 0.01);  // half of the voxel
    const Surface found = planes.at_point(at);
    REQUIRE(found.valid);
    return found.quality;
  };
  const Vec3 inside(0.25, 0.5, 0.2), beyond(0.95, 0.5, 0.2);
  CHECK(quality(0, 20, beyond) == 1.0);
  CHECK(quality(10, 400, inside) > 0.95);
  CHECK(quality(10, 20, inside) < 0.8);
  // eq. MAP-2: the points deviate by 0.5 / sqrt(12) m in x, and `beyond` is 0.7 m from their mean.
  const double leverage = 1 + 0.7 * 0.7 / (0.25 / 12);
  CHECK(quality(10, 400, beyond) == Approx(400 / (400 + 10 * leverage)).epsilon(0.05));
}

TEST_CASE("voxel_plane: what is trimmed is forgotten, and its memory used again") {
  Planes planes("{type: voxel_plane, voxel: 0.5, levels: 3, radius: 5}", 0.5);
  planes.floor(0, 1, 0.2, 2000);
  REQUIRE(planes.at_point({0.5, 0.5, 0.2}).valid);
  const std::size_t bytes = planes.map->memory_bytes();
  planes.map->trim({20, 0, 0});
  CHECK(planes.map->size() == 0);
  CHECK(!planes.at_point({0.5, 0.5, 0.2}).valid);
  planes.floor(20, 21, 0.2, 2000);
  CHECK(planes.at_point({20.5, 0.5, 0.2}).valid);
  CHECK(!planes.at_point({0.5, 0.5, 0.2}).valid);
  CHECK(planes.map->memory_bytes() <= 2 * bytes);
}

TEST_CASE("voxel_plane: far from the origin planes are as exact, and beyond the range of voxels points are refused") {
  for (const double far : {0.0, 1e5, 5e5}) {
    CAPTURE(far);
    Planes planes("{type: voxel_plane, voxel: 0.5, levels: 1}", 0.5);
    planes.corner += Vec3(far, -far, 0);  // whole voxels
    planes.floor(0, 0.5, 0.2, 200, 1, 0.005);
    const Surface found = planes.at_point({0.25, 0.25, 0.2});
    REQUIRE(found.valid);
    CHECK(std::abs(found.anchor.z() - 0.2) < 1e-3);
    CHECK(std::abs(found.normal.z()) > 0.9995);
  }
  Planes planes("{type: voxel_plane, voxel: 0.5, levels: 1}", 0.5);
  planes.corner += Vec3(5.3e5, 0, 0);
  CHECK(planes.floor(0, 0.5, 0.2, 200) == 0);
  CHECK(planes.map->size() == 0);
  CHECK_FALSE(planes.at_point({0.25, 0.25, 0.2}).valid);
}

TEST_CASE("voxel_plane: a voxel whose levels are all closed by one insertion gives each of its blocks back once") {
  Planes planes("{type: voxel_plane, voxel: 1.0, levels: 3, min_points: 10, max_points: 500, faces: false}");
  const auto thick = [&](int count) {
    std::vector<WorldPoint> points;
    for (int i = 0; i < count; ++i) {
      const Vec3 p = planes.uniform.in_box({0.25, 0.25, 0}, 0.2);
      points.push_back(at(planes.corner + Vec3(p.x(), p.y(), 0.25 + 0.3 * p.z())));
    }
    planes.map->insert(points, 1);
  };
  for (const int count : {12, 15, 15}) thick(count);  // no plane: each level begins the one below
  planes.floor(0.01, 0.49, 0.25, 1200);               // half of them in that octant: all are closed at once
  REQUIRE(planes.at_point({0.25, 0.25, 0.25}).valid);
  // Voxels that share a block would spoil each other's planes.
  const Vec3 corner = planes.corner;
  for (int round = 0; round < 6; ++round) {
    for (int k = 1; k <= 6; ++k) {
      planes.corner = corner + Vec3(0, 0, 2 * k);
      planes.floor(0.0, 0.5, 0.1 * k, 60);
      planes.floor(0.5, 1.0, 0.1 * k + 0.15, 60);
    }
  }
  for (int k = 1; k <= 6; ++k) {
    CAPTURE(k);
    planes.corner = corner + Vec3(0, 0, 2 * k);
    for (const double x : {0.25, 0.75}) {
      const double z = 0.1 * k + (x > 0.5 ? 0.15 : 0.0);
      const Surface found = planes.at_point({x, 0.25, z});
      REQUIRE(found.valid);
      CHECK(std::abs(found.anchor.z() - z) < 1e-5);
    }
  }
}

TEST_CASE("voxel_plane: a clump or a line is no plane, whatever the rounding says of its thickness") {
  for (const Vec3& along : {Vec3(0, 0, 0), Vec3(0.3, 0.2, 0.1), Vec3(0.45, 0, 0)}) {
    CAPTURE(along.transpose());
    for (int k = 0; k < 50; ++k) {
      Planes planes("{type: voxel_plane, voxel: 0.5, levels: 1}", 0.5);
      const Vec3 begin(planes.uniform(0.01, 0.04), planes.uniform(0.01, 0.4), planes.uniform(0.01, 0.4));
      const Vec3 shift = k * Vec3(0.0003, 0.0007, 0.0005);
      std::vector<WorldPoint> points;
      for (int i = 0; i < 100; ++i) points.push_back(at(planes.corner + begin + shift + (i / 100.0) * along));
      planes.map->insert(points, 1);
      CHECK_FALSE(planes.at_point(begin + shift).valid);
    }
  }
}

TEST_CASE("voxel_plane: a clump of the most points a voxel may have is no plane, either") {
  for (const double voxel : {1.0, 3.0, 10.0}) {
    for (int trial = 0; trial < 4; ++trial) {
      CAPTURE(voxel, trial);
      Planes planes(
          fmt::format("{{type: voxel_plane, voxel: {}, levels: 1, thickness: 0.1, max_points: 10000}}", voxel), voxel);
      const Vec3 middle = voxel * Vec3(planes.uniform(0.1, 0.9), planes.uniform(0.1, 0.9), planes.uniform(0.1, 0.9));
      const auto near = [&] { return planes.uniform(-5e-5, 5e-5); };
      std::vector<WorldPoint> points;
      for (int i = 0; i < 10000; ++i) points.push_back(at(planes.corner + middle + Vec3(near(), near(), near())));
      planes.map->insert(points, 1);
      CHECK_FALSE(planes.at_point(middle).valid);
    }
  }
}

TEST_CASE("voxel_plane: sums of the most points a voxel may have are still exact enough for its plane") {
  Planes planes("{type: voxel_plane, voxel: 1.0, levels: 1, thickness: 0.003, max_points: 10000}");
  REQUIRE(planes.floor(0, 1, 0.6, 10000) == 10000);
  const Surface found = planes.at_point({0.5, 0.5, 0.6});
  REQUIRE(found.valid);
  // Less than what 2 cm of noise would leave of so many points: 2e-4 m, 7e-4 rad. One height for all of them rounds to
  // the same side every time.
  CHECK(std::abs(found.anchor.z() - 0.6) < 1e-4);
  CHECK(Vec3(found.normal.x(), found.normal.y(), 0).norm() < 6e-4);
}

TEST_CASE("voxel_plane: parameters out of range are refused") {
  EveryMap fixture;
  for (const char* wrong : {"thickness: 0", "thickness: -0.02", "doubt: -1", "min_points: 3", "voxel: -0.5",
                            "levels: 0", "radius: 0", "max_points: 5, min_points: 10", "max_points: 10001"}) {
    CAPTURE(wrong);
    CHECK_THROWS_AS(fixture.make("{type: voxel_plane, " + std::string(wrong) + "}"), ConfigError);
  }
}

TEST_CASE("cells found by the batch are those of one point at a time, at every edge and for what has none") {
  Uniform uniform(5);
  const Vec3 offset(0.137, 0.223, 0.311);
  const double inf = std::numeric_limits<double>::infinity(), nan = std::numeric_limits<double>::quiet_NaN();
  std::size_t without = 0;
  for (const double edge : {0.5, 0.3, 1.0}) {
    for (const double half : {1.0, 1e3, 1.5 * edge * kCellLimit}) {
      for (int round = 0; round < 20; ++round) {
        std::vector<Vec3> points;
        for (std::size_t i = 0; i < aslio::CellBatch::kSize; ++i) points.push_back(uniform.in_box(Vec3::Zero(), half));
        points[1].y() = nan, points[2].z() = -inf, points[3].x() = 1e300;
        const std::size_t count = round % 2 == 0 ? points.size() : 7;  // a full batch, and one after it that is not
        aslio::CellBatch batch;
        batch.find(
            count, [&](std::size_t i) -> const Vec3& { return points[i]; }, edge, offset);
        for (std::size_t i = 0; i < count; ++i) {
          const auto cell = cell_of(points[i] + edge * offset, 1.0 / edge);
          without += cell ? 0 : 1;
          REQUIRE(batch.key(i) == (cell ? pack(*cell) : aslio::CellBatch::kNoCell));
          if (!cell) continue;
          REQUIRE(batch.cell(i) == *cell);
          const Vec3 corner = edge * (Vec3(cell->x, cell->y, cell->z) - offset);
          REQUIRE((batch.inside(i) - (points[i] - corner).cast<float>()).norm() < 1e-6);
        }
      }
    }
  }
  CHECK(without > 500);
}

TEST_CASE("voxel_plane: what is too thick for the noise is a plane once more noise is known of (eq. NOI-2)") {
  Planes planes("{type: voxel_plane, voxel: 1.0, levels: 1, thickness: 0.023, max_points: 300}");
  planes.floor(0, 1, 0.5, 300, 1, 0.08);  // 0.046 r.m.s.; the voxel is closed and takes no more points
  const Vec3 middle(0.5, 0.5, 0.5);
  CHECK_FALSE(planes.at_point(middle).valid);
  planes.map->set_noise_scale(1.5);
  CHECK_FALSE(planes.at_point(middle).valid);
  planes.map->set_noise_scale(3.0);
  const Surface found = planes.at_point(middle);
  REQUIRE(found.valid);
  CHECK(std::abs(found.normal.z()) > 0.98);
  CHECK(found.anchor.z() == Approx(0.5).margin(0.015));
}

TEST_CASE("voxel_plane: factors of the noise do not multiply up, and one changes nothing (eq. NOI-2)") {
  Planes planes("{type: voxel_plane, voxel: 1.0, levels: 1, thickness: 0.023, max_points: 300}");
  planes.map->set_noise_scale(1.5);
  planes.map->set_noise_scale(1.5);
  planes.map->set_noise_scale(1.0);
  planes.floor(0, 1, 0.5, 300, 1, 0.065);  // 0.0375 r.m.s.
  CHECK_FALSE(planes.at_point({0.5, 0.5, 0.5}).valid);
  planes.map->set_noise_scale(1.5);  // 0.0345 is too little
  CHECK_FALSE(planes.at_point({0.5, 0.5, 0.5}).valid);
  planes.map->set_noise_scale(1.75);
  CHECK(planes.at_point({0.5, 0.5, 0.5}).valid);
}

TEST_CASE("voxel_plane: noise of a sixth of a voxel's edge leaves planes, and no clump is one (eq. NOI-2)") {
  Planes planes("{type: voxel_plane, voxel: 0.5, levels: 1, thickness: 0.023, max_points: 300}", 0.5);
  const auto fill = [&](double x, double half) {
    std::vector<WorldPoint> points;
    for (int i = 0; i < 300; ++i) {
      const Vec3 flat(planes.uniform(0, 0.5), planes.uniform(0, 0.5), 0.25);
      const Vec3 clump = Vec3::Constant(0.25) + planes.uniform.in_box(Vec3::Zero(), half);
      const Vec3 p = half > 0 ? clump : Vec3(flat + Vec3(0, 0, planes.uniform(-0.104, 0.104)));  // 0.06 r.m.s.
      points.push_back(at(planes.corner + p + Vec3(x, 0, 0)));
    }
    planes.map->insert(points, 1);
  };
  fill(0, 0);
  fill(0.5, 0.1);
  CHECK_FALSE(planes.at_point({0.25, 0.25, 0.25}).valid);
  planes.map->set_noise_scale(3.0);
  CHECK(planes.at_point({0.25, 0.25, 0.25}).valid);
  CHECK_FALSE(planes.at_point({0.75, 0.25, 0.25}).valid);
}
