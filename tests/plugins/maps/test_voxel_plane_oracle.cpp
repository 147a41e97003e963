// Planes in voxels against brute force: every voxel fitted at once from the points it was given. (eq. MAP-1)
#include <Eigen/Eigenvalues>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <optional>

#include "plugins/maps/map_fixture.hpp"

using namespace aslio;
using namespace aslio::test;

namespace {

constexpr double kEdge = 1.0, kThickness = 0.03;
constexpr std::size_t kMinPoints = 10;
const Vec3 kOffset(0.137, 0.223, 0.311);  // of the grid, in edges

using CellNumber = std::array<long, 3>;
using Points = std::vector<Vec3>;

CellNumber cell_number(const Vec3& p, double edge) {
  const Vec3 cell = ((p + kEdge * kOffset) / edge).array().floor();
  return {std::lround(cell.x()), std::lround(cell.y()), std::lround(cell.z())};
}

struct Plane {
  Vec3 mean, normal;
};

/// The plane through all points; nothing if they are none.
struct Fit {
  std::optional<Plane> plane;
  bool certain = true;
};

Fit fit(const Points& points) {
  if (points.size() < kMinPoints) return {};
  Vec3 mean = Vec3::Zero();
  for (const Vec3& p : points) mean += p;
  mean /= static_cast<double>(points.size());
  Mat3 covariance = Mat3::Zero();
  for (const Vec3& p : points) covariance += (p - mean) * (p - mean).transpose();
  const Eigen::SelfAdjointEigenSolver<Mat3> solver(covariance / static_cast<double>(points.size()));
  const Vec3& l = solver.eigenvalues();
  // Each of them positive: the condition holds.
  const std::array<double, 3> margins{1 - l[0] / (kThickness * kThickness), l[1] / (0.05 * l[2]) - 1,
                                      l[1] / (9 * std::max(l[0], 1e-6 * kEdge * kEdge)) - 1};
  Fit out;
  bool planar = true;
  for (const double margin : margins) {
    planar = planar && margin > 0;
    out.certain = out.certain && std::abs(margin) > 0.02;
  }
  if (planar) out.plane = Plane{mean, solver.eigenvectors().col(0)};
  return out;
}

/// Patches of planes in all directions, some thick, some cut by others, and clutter.
Points draw(Uniform& uniform, int patches) {
  Points points;
  for (int k = 0; k < patches; ++k) {
    const Vec3 centre = uniform.in_box(Vec3::Zero(), 3.0), normal = uniform.in_box(Vec3::Zero(), 1.0).normalized();
    const Vec3 first = normal.unitOrthogonal(), second = normal.cross(first);
    const double half = uniform(0.1, 1.0), thick = k % 5 == 0 ? 0.3 : uniform(0.0, 0.06);
    const int count = static_cast<int>(uniform(20, 300));
    for (int i = 0; i < count; ++i) {
      points.push_back(centre + uniform(-half, half) * first + uniform(-half, half) * second +
                       uniform(-thick, thick) * normal);
    }
  }
  return points;
}

struct Seen {
  std::size_t planes = 0, finer = 0, none = 0;
};

void check(const Surface& found, const Fit& expected, double edge) {
  REQUIRE(found.valid == expected.plane.has_value());
  if (!found.valid) return;
  CHECK((found.anchor - expected.plane->mean).norm() < 1e-5 * edge);
  CHECK(std::abs(found.normal.dot(expected.plane->normal)) > 1 - 1e-6);
}

}  // namespace

TEST_CASE("voxel_plane: every voxel has the plane that is fitted to all its points at once, on both levels") {
  EveryMap fixture;
  Seen seen;
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    CAPTURE(seed);
    const auto map =
        fixture.make("{type: voxel_plane, voxel: 1, levels: 2, min_points: 10, max_points: 10000, thickness: 0.03}");
    Uniform uniform(seed);
    const Points first = draw(uniform, 40);
    // Three times as many where points lay, so that every voxel is fitted again.
    Points second;
    std::map<CellNumber, Points> whole, parts;
    for (const Vec3& p : first) {
      whole[cell_number(p, kEdge)].push_back(p);
      for (int i = 0; i < 3; ++i) {
        const Vec3 near = uniform.in_box(p, 0.01);
        second.push_back(cell_number(near, kEdge) == cell_number(p, kEdge) ? near : p);
      }
    }
    // A voxel has parts once a fit has found it to be no plane; they hold what comes after.
    std::map<CellNumber, Fit> before;
    for (const auto& [cell, points] : whole) before[cell] = fit(points);
    for (const Vec3& p : second) {
      const CellNumber cell = cell_number(p, kEdge);
      const bool was_fitted = whole[cell].size() >= kMinPoints || before[cell].plane;
      if (was_fitted && !before[cell].plane) parts[cell_number(p, kEdge / 2)].push_back(p);
    }
    const auto enter = [&](const Points& points, std::uint32_t stamp) {
      std::vector<WorldPoint> batch;
      for (const Vec3& p : points) batch.push_back(at(p));
      map->insert(batch, stamp);
    };
    enter(first, 1);
    enter(second, 2);
    std::map<CellNumber, Points> all = whole;
    for (const Vec3& p : second) all[cell_number(p, kEdge)].push_back(p);
    std::vector<Surface> found(first.size());
    map->surfaces(first, MapQuery{}, found);
    for (std::size_t i = 0; i < first.size(); ++i) {
      const CellNumber cell = cell_number(first[i], kEdge);
      const Fit coarse = fit(all[cell]);
      if (!coarse.certain || !before[cell].certain) continue;
      if (coarse.plane) {
        ++seen.planes;
        check(found[i], coarse, kEdge);
        continue;
      }
      const auto part = parts.find(cell_number(first[i], kEdge / 2));
      const Fit fine = part == parts.end() ? Fit{} : fit(part->second);
      if (!fine.certain) continue;
      ++(fine.plane ? seen.finer : seen.none);
      check(found[i], fine, kEdge);
    }
  }
  CHECK(seen.planes > 1000);
  CHECK(seen.finer > 1000);
  CHECK(seen.none > 1000);
}
