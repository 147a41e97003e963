// Surfels of voxels and of their cells beyond the contract. (eq. MAP-7)
#include <Eigen/Eigenvalues>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <optional>

#include "maps/surfel.hpp"
#include "plugins/build_environment.hpp"
#include "plugins/maps/map_fixture.hpp"

using namespace aslio;
using namespace aslio::test;
using plugins::Surfel;

namespace {

using Key = std::array<int, 3>;
const Vec3 kCorner = -1.5 * plugins::kGridOffset;  // of a voxel of the default size

Key cell(const Vec3& p, double edge) {
  const Eigen::Vector3i c = (p / edge).array().floor().cast<int>();
  return {c.x(), c.y(), c.z()};
}

Surface ask(const Map& map, const Vec3& p, std::uint32_t max_stamp = 0xffffffff) {
  MapQuery query;
  query.max_stamp = max_stamp;
  std::vector<Surface> found(1);
  map.surfaces(std::vector<Vec3>{p}, query, found);
  return found[0];
}

/// Points of z = height(x, y) over [low, high]^2 about the corner of a voxel, `noise` either way.
template <class Height>
std::vector<WorldPoint> sheet(Uniform& uniform, double low, double high, int count, double noise, const Height& height,
                              const Vec3& corner = kCorner) {
  std::vector<WorldPoint> points;
  for (int i = 0; i < count; ++i) {
    const double x = uniform(low, high), y = uniform(low, high);
    points.push_back(at(corner + Vec3(x, y, height(x, y) + uniform(-noise, noise))));
  }
  return points;
}

/// The surfels in plain words, of points that came in one insertion.
class Plain {
 public:
  explicit Plain(const Surfel::Params& params) : params_(params) {}
  void insert(const std::vector<WorldPoint>& points) {
    for (const WorldPoint& point : points) {
      auto& held = cells_[cell(point.p_W - kCorner, params_.cell)];
      if (held.size() < static_cast<std::size_t>(params_.max_points)) held.push_back(point.p_W);
    }
  }
  struct Plane {
    Vec3 mean, normal;
  };
  std::optional<Plane> of_cell(const Vec3& p) const {
    const auto found = cells_.find(cell(p - kCorner, params_.cell));
    if (found == cells_.end() || found->second.size() < static_cast<std::size_t>(params_.min_points)) return {};
    return plane(found->second, params_.cell, Mat3::Zero(), 1.0);
  }
  std::optional<Plane> of_voxel(const Vec3& p) const {
    const double edge = params_.cell * static_cast<double>(params_.cells);
    const Key voxel = cell(p - kCorner, edge);
    std::vector<Vec3> means;
    Mat3 within = Mat3::Zero();
    for (const auto& [key, points] : cells_) {
      const Vec3 middle = kCorner + params_.cell * Vec3(key[0] + 0.5, key[1] + 0.5, key[2] + 0.5);
      if (cell(middle - kCorner, edge) != voxel || points.size() < static_cast<std::size_t>(params_.cell_points))
        continue;
      means.push_back(mean_of(points));
      within += covariance_of(points);
    }
    if (means.size() < static_cast<std::size_t>(params_.min_cells)) return {};
    return plane(means, edge, within / static_cast<double>(means.size()), params_.planarity);
  }

 private:
  static Vec3 mean_of(const std::vector<Vec3>& points) {
    Vec3 sum = Vec3::Zero();
    for (const Vec3& p : points) sum += p;
    return sum / static_cast<double>(points.size());
  }
  static Mat3 covariance_of(const std::vector<Vec3>& points) {
    const Vec3 mean = mean_of(points);
    Mat3 sum = Mat3::Zero();
    for (const Vec3& p : points) sum += (p - mean) * (p - mean).transpose();
    return sum / static_cast<double>(points.size());
  }
  std::optional<Plane> plane(const std::vector<Vec3>& points, double edge, const Mat3& within, double ratio) const {
    const Eigen::SelfAdjointEigenSolver<Mat3> solver(covariance_of(points));
    const Vec3 l = solver.eigenvalues(), normal = solver.eigenvectors().col(0);
    const double across = l[0] + normal.dot(within * normal), limit = params_.thickness * params_.thickness;
    // What is this near to a limit may fall on either side of it by rounding; no case here is.
    const auto below = [](double a, double b) {
      REQUIRE(std::abs(a - b) > 1e-9);
      return a < b;
    };
    const bool planar = below(across, limit) && below(0.05 * l[2], l[1]) &&
                        below(9 * std::max(l[0], 1e-6 * edge * edge), l[1]) && (ratio == 1.0 || l[0] < ratio * l[2]);
    if (!planar) return {};
    return Plane{mean_of(points), normal};
  }

  Surfel::Params params_;
  std::map<Key, std::vector<Vec3>> cells_;
};

/// Two walls and a floor that are rough, a ball, and stray points, with as many points as it takes.
std::vector<WorldPoint> scene(Uniform& uniform, int count) {
  std::vector<WorldPoint> points;
  for (int i = 0; i < count; ++i) {
    const Vec3 p = uniform.in_box(Vec3(1, 1, 1), 3.0), noise = uniform.in_box(Vec3::Zero(), 0.02);
    if (i % 5 == 0) points.push_back(at(Vec3(p.x(), p.y(), 0.3) + noise));
    if (i % 5 == 1) points.push_back(at(Vec3(2.1, p.y(), p.z()) + noise));
    if (i % 5 == 2) points.push_back(at(Vec3(p.x(), 0.4 * p.x() - 2.0, p.z()) + noise));
    if (i % 5 == 3) points.push_back(at(Vec3(0, 2, 2) + 1.2 * (p - Vec3(1, 1, 1)).normalized() + noise));
    if (i % 50 == 4) points.push_back(at(p));
  }
  return points;
}

void check_is(const Surface& found, const Plain::Plane& plane) {
  REQUIRE(found.valid);
  REQUIRE((found.anchor - plane.mean).norm() < 1e-5);
  REQUIRE(found.normal.cross(plane.normal).norm() < 1e-4);
}

}  // namespace

TEST_CASE("surfel: those of voxels and cells are those of brute force over a rough room with a ball in it") {
  BuildEnvironment environment;
  std::size_t of_voxel = 0, of_cell = 0, none = 0;
  for (const auto first : {Surfel::First::voxel, Surfel::First::cell}) {
    for (const int count : {2000, 20000}) {
      const Surfel::Params params{.first = first};
      Surfel map(params, environment.context());
      Plain plain(params);
      Uniform uniform(static_cast<std::uint64_t>(count));
      const auto points = scene(uniform, count);
      map.insert(points, 1);
      plain.insert(points);
      for (std::size_t i = 0; i < 400; ++i) {
        const Vec3 query = points[i].p_W + uniform.in_box(Vec3::Zero(), 0.1);
        const auto voxel = plain.of_voxel(query), own = plain.of_cell(query);
        const Surface found = ask(map, query);
        if (!voxel && !own) {
          REQUIRE(!found.valid);
          ++none;
        } else if (voxel && (first == Surfel::First::voxel || !own)) {
          check_is(found, *voxel);
          ++of_voxel;
        } else {
          check_is(found, *own);
          ++of_cell;
        }
      }
    }
  }
  CHECK(of_voxel > 100);
  CHECK(of_cell > 100);
  CHECK(none > 100);
}

TEST_CASE("surfel: cells of a voxel count alike, however many points they have") {
  BuildEnvironment environment;
  Surfel map({.max_points = 2000}, environment.context());
  Uniform uniform(2);
  const auto slope = [](double x, double) { return 0.2 + 0.1 * x; };
  map.insert(sheet(uniform, 0.01, 1.49, 4000, 0.005, slope), 1);
  map.insert(sheet(uniform, 0.01, 0.49, 1500, 0.005, slope), 2);  // one cell has a quarter of all points
  const Surface found = ask(map, kCorner + Vec3(0.75, 0.75, 0.27));
  REQUIRE(found.valid);
  CHECK((found.anchor - (kCorner + Vec3(0.75, 0.75, 0.275))).norm() < 0.02);
  CHECK(std::abs(found.normal.dot(Vec3(-0.1, 0, 1).normalized())) > 0.9999);
}

TEST_CASE("surfel: in a corner, where a voxel has none, cells have those of the walls") {
  BuildEnvironment environment;
  Surfel map({}, environment.context());
  Uniform uniform(3);
  std::vector<WorldPoint> points;
  for (const WorldPoint& of_floor : sheet(uniform, 0.01, 1.49, 3000, 0.01, [](double, double) { return 0.25; })) {
    points.push_back(of_floor);
    points.push_back(at(kCorner + Vec3(0.25 + uniform(-0.01, 0.01), uniform(0.01, 1.49), uniform(0.01, 1.49))));
  }
  map.insert(points, 1);
  const Surface floor = ask(map, kCorner + Vec3(1.2, 0.7, 0.26)), wall = ask(map, kCorner + Vec3(0.24, 0.7, 1.2));
  REQUIRE((floor.valid && wall.valid));
  CHECK(std::abs(floor.normal.z()) > 0.999);
  CHECK(std::abs(wall.normal.x()) > 0.999);
  CHECK(!ask(map, kCorner + Vec3(0.25, 0.7, 0.25)).valid);  // the edge itself
}

TEST_CASE("surfel: one layer of cells full of clutter is none, though their means are flat") {
  BuildEnvironment environment;
  Surfel map({.max_points = 1000}, environment.context());
  Uniform uniform(4);
  map.insert(sheet(uniform, 0.01, 1.49, 9000, 0.2, [](double, double) { return 0.25; }), 1);
  for (int i = 0; i < 100; ++i) {
    REQUIRE(!ask(map, kCorner + Vec3(uniform(0.1, 1.4), uniform(0.1, 1.4), 0.25)).valid);
  }
}

TEST_CASE("surfel: on a ball of about the size of a voxel, cells have the tangent planes and the voxel has none") {
  BuildEnvironment environment;
  Surfel map({}, environment.context());
  Uniform uniform(10);
  const Vec3 centre = kCorner + Vec3(0.75, 0.75, 0.75);
  constexpr double radius = 1.1;
  std::vector<Vec3> on_ball;
  std::vector<WorldPoint> points;
  while (points.size() < 20000) {
    const Vec3 p = uniform.in_box(Vec3::Zero(), 1.0);
    if (p.norm() > 1.0 || p.norm() < 0.1) continue;
    on_ball.push_back(centre + radius * p.normalized());
    points.push_back(at(on_ball.back()));
  }
  map.insert(points, 1);
  std::size_t found = 0;
  for (std::size_t i = 0; i < 300; ++i) {
    const Surface surface = ask(map, on_ball[i]);
    if (!surface.valid) continue;
    ++found;
    const Vec3 radial = (on_ball[i] - centre).normalized();
    REQUIRE(std::abs(surface.normal.dot(radial)) > std::cos(0.45));  // a cell's diagonal is 0.79 rad of the ball
    REQUIRE(std::abs((surface.anchor - centre).norm() - radius) < 0.1);
  }
  CHECK(found > 200);
}

TEST_CASE("surfel: `nearby` takes that of the nearest cell beside, in the next voxel too, and of its time only") {
  BuildEnvironment environment;
  for (const int nearby : {0, 6}) {
    Surfel map({.nearby = nearby}, environment.context());
    Uniform uniform(5);
    const auto flat = [](double height) { return [height](double, double) { return height; }; };
    // Two cells of one column of a voxel, and one in the voxel below: 0.5 m apart each.
    map.insert(sheet(uniform, 0.02, 0.48, 300, 0.005, flat(0.4)), 3);
    map.insert(sheet(uniform, 0.02, 0.48, 300, 0.005, flat(1.1)), 4);
    map.insert(sheet(uniform, 0.02, 0.48, 300, 0.005, flat(-0.9)), 5);
    const auto height = [&](double z, std::uint32_t max_stamp = 9) -> std::optional<double> {
      const Surface found = ask(map, kCorner + Vec3(0.25, 0.25, z), max_stamp);
      if (!found.valid) return {};
      return std::round(10.0 * (found.anchor.z() - kCorner.z())) / 10.0;
    };
    CHECK(height(0.2) == 0.4);
    CHECK(height(1.2) == 1.1);
    if (nearby == 0) {
      CHECK(!height(0.6));
      CHECK(!height(-0.2));
      continue;
    }
    CHECK(height(0.6) == 0.4);     // 0.1 m from the face of that cell
    CHECK(height(0.9) == 1.1);     // 0.1 m from that of the other
    CHECK(height(0.9, 3) == 0.4);  // which was not there yet
    CHECK(!height(0.9, 2));
    CHECK(height(-0.1) == 0.4);  // across the face between two voxels
    CHECK(height(-0.4) == -0.9);
    CHECK(!height(-1.7));  // two cells away
  }
}

TEST_CASE("surfel: one counts from the update that made it one, and a cell that is full is closed") {
  BuildEnvironment environment;
  Surfel map({.min_points = 20, .max_points = 60}, environment.context());
  Uniform uniform(6);
  const auto flat = [](double, double) { return 0.2; };
  map.insert(sheet(uniform, 0.02, 0.48, 19, 0.005, flat), 1);
  CHECK(!ask(map, kCorner + Vec3(0.25, 0.25, 0.2)).valid);
  CHECK(map.insert(sheet(uniform, 0.02, 0.48, 41, 0.005, flat), 5).inserted == 41);
  CHECK(!ask(map, kCorner + Vec3(0.25, 0.25, 0.2), 4).valid);
  const Surface before = ask(map, kCorner + Vec3(0.25, 0.25, 0.2), 5);
  REQUIRE(before.valid);
  CHECK(map.insert(sheet(uniform, 0.02, 0.48, 500, 0.005, [](double, double) { return 0.3; }), 6).inserted == 0);
  const Surface after = ask(map, kCorner + Vec3(0.25, 0.25, 0.2));
  CHECK(after.anchor == before.anchor);
  CHECK(after.normal == before.normal);
}

TEST_CASE("surfel: far from the origin they are as exact, and what is trimmed is forgotten") {
  BuildEnvironment environment;
  for (const double far : {0.0, 3e5}) {
    CAPTURE(far);
    Surfel map({.radius = 10.0}, environment.context());
    Uniform uniform(7);
    std::size_t bytes = 0;
    for (int place = 0; place < 8; ++place) {
      const Vec3 corner = kCorner + Vec3(far + 60.0 * place, -far, 0);  // whole voxels
      map.trim(corner);
      REQUIRE(map.size() == 0);
      map.insert(sheet(
                     uniform, -3.0, 4.5, 20000, 0.01, [](double x, double) { return 0.2 + 0.05 * x; }, corner),
                 1);
      const Surface found = ask(map, corner + Vec3(0.7, 0.8, 0.23));
      REQUIRE(found.valid);
      CHECK(std::abs(found.normal.dot(Vec3(-0.05, 0, 1).normalized())) > 0.99995);
      CHECK(std::abs(found.normal.dot(found.anchor - corner - Vec3(0, 0, 0.2))) < 2e-3);
      CHECK(!ask(map, corner + Vec3(0.7 - 60.0, 0.8, 0.23)).valid);
      if (place == 0) bytes = map.memory_bytes();
    }
    CHECK(map.memory_bytes() <= bytes + bytes / 4);
  }
}

TEST_CASE("surfel: where points are noisier than the file says, thicker ones count, of what was there before, too") {
  BuildEnvironment environment;
  Surfel map({.thickness = 0.02}, environment.context());
  Uniform uniform(8);
  map.insert(sheet(uniform, 0.01, 1.49, 4000, 0.05, [](double, double) { return 0.2; }), 1);  // deviation 0.029 m
  const Vec3 query = kCorner + Vec3(0.7, 0.7, 0.2);
  CHECK(!ask(map, query).valid);
  map.set_noise_scale(2.0);
  CHECK(ask(map, query).valid);
}

TEST_CASE("surfel: copies without end and infinite noise make none, and do not spoil what is near") {
  BuildEnvironment environment;
  Surfel map({.max_points = 10000}, environment.context());
  Uniform uniform(9);
  map.insert(std::vector<WorldPoint>(20000, at(kCorner + Vec3(2.2, 0.2, 0.2))), 1);
  CHECK(!ask(map, kCorner + Vec3(2.2, 0.2, 0.2)).valid);
  std::vector<WorldPoint> points = sheet(uniform, 0.01, 1.49, 4000, 0.005, [](double, double) { return 0.2; });
  for (std::size_t i = 0; i < points.size(); i += 3) {
    points[i].p_W[static_cast<int>(i % 3)] = i % 2 == 0 ? std::nan("") : HUGE_VAL;
  }
  const InsertCount count = map.insert(points, 2);
  CHECK(count.offered - count.inserted == (points.size() + 2) / 3);
  CHECK(ask(map, kCorner + Vec3(0.7, 0.7, 0.2)).valid);
}
