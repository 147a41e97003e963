/// Garage, approach and campus as they are shipped, whole and shortened.

#include <catch2/catch.hpp>
#include <utility>

#include "aslio/core/errors.hpp"
#include "aslio/simulator/scan_pattern.hpp"
#include "simulator/worlds/world_checks.hpp"

using namespace aslio;
using namespace aslio::simulator;
using namespace aslio::simulator::testing;

namespace {

constexpr std::size_t kMaxTriangles = 1'500'000;
constexpr std::size_t kMaxBytes = 400'000'000;

World built(const Scene& scene, const Route& route, double scale) {
  switch (scene.world.type) {
    case WorldKind::approach:
      return build_approach(scene.world.approach, route, scale);
    case WorldKind::campus:
      return build_campus(scene.world.campus, route, scale);
    default:
      return build_garage(scene.world.garage, route, scale);
  }
}

std::int64_t& seed_of(Scene& scene) {
  switch (scene.world.type) {
    case WorldKind::approach:
      return scene.world.approach.seed;
    case WorldKind::campus:
      return scene.world.campus.seed;
    default:
      return scene.world.garage.seed;
  }
}

/// What an Avia sees that looks along the route.
struct Views {
  double share = 0;            ///< of the rays that meet something within 100 m
  double least_share = 1;      ///< at the worst place
  double median = 0, far = 0;  ///< of the ranges [m]; 99 % are below the second
};

Views avia_views(const World& world, const Caster& caster, const Route& route) {
  const auto pattern = make_scan_pattern(SensorKind::avia);
  std::vector<Beam> beams(pattern->beams_per_firing());
  std::vector<Vec3> directions(beams.size());
  std::vector<SurfaceHit> hits(beams.size());
  std::vector<double> ranges;
  std::size_t rays = 0;
  Views views;
  for (double s = 0; s < route.length(); s += 4) {
    const Route::Place place = route.at(s);
    const Vec3 eye(place.at.x(), place.at.y(), world.ground.height(place.at.x(), place.at.y()) + 1.4);
    Mat3 heading = Mat3::Identity();
    heading.topLeftCorner<2, 2>() << place.direction.x(), -place.direction.y(), place.direction.y(),
        place.direction.x();
    const std::size_t before = ranges.size();
    std::size_t here = 0;
    // A firing of every millisecond: 100 of them cover the field of view.
    for (TimeNs t = 0; t < 100'000'000; t += 1'000'000) {
      pattern->fire(t, beams);
      for (std::size_t k = 0; k < beams.size(); ++k) directions[k] = heading * beams[k].direction;
      caster.cast(eye, directions, 100, hits);
      for (const SurfaceHit& hit : hits)
        if (std::isfinite(hit.range)) ranges.push_back(hit.range);
      here += hits.size();
    }
    rays += here;
    views.least_share =
        std::min(views.least_share, static_cast<double>(ranges.size() - before) / static_cast<double>(here));
  }
  std::sort(ranges.begin(), ranges.end());
  views.share = static_cast<double>(ranges.size()) / static_cast<double>(rays);
  views.median = ranges.at(ranges.size() / 2);
  views.far = ranges.at(ranges.size() * 99 / 100);
  return views;
}

}  // namespace

TEST_CASE("garage and approach leave the route free, stand on their ground and have no holes", "[worlds]") {
  const std::string name = GENERATE("indoor_2", "garage_degenerate");
  const double scale = GENERATE(0.2, 1.0, 1.7);
  CAPTURE(name, scale);
  const auto [scene, route] = shipped(name, scale);
  const World world = built(scene, route, scale);
  CHECK(worst_clearance(world, route) >= 1 - 1e-6);
  const Caster caster(world.mesh);
  CHECK(worst_ground(world, caster, route) < 0.01);
  CHECK(share_of_hits(world, caster, route) > 0.999);
  CHECK(world.mesh.triangles.size() < kMaxTriangles);
  CHECK(caster.bytes() < kMaxBytes);
}

TEST_CASE("a campus leaves the route free and stands on its ground", "[worlds]") {
  const std::string name = GENERATE("outdoor_1", "outdoor_2", "outdoor_3", "outdoor_4", "outdoor_5", "outdoor_6");
  const double scale = GENERATE(0.2, 1.0);
  CAPTURE(name, scale);
  const auto [scene, route] = shipped(name, scale);
  const World world = built(scene, route, scale);
  CHECK(worst_clearance(world, route) >= 1 - 1e-6);
  const Caster caster(world.mesh);
  CHECK(worst_ground(world, caster, route) < 0.01);
  CHECK(world.mesh.triangles.size() < kMaxTriangles);
  CHECK(caster.bytes() < kMaxBytes);
}

TEST_CASE("the seed of an outdoor world gives its bits", "[worlds]") {
  const std::string name = GENERATE("indoor_2", "garage_degenerate", "outdoor_2");
  CAPTURE(name);
  auto [scene, route] = shipped(name, 1);
  const World first = built(scene, route, 1);
  CHECK(same_bits(first.mesh, built(scene, route, 1).mesh));
  seed_of(scene) += 1;
  CHECK_FALSE(same_bits(first.mesh, built(scene, route, 1).mesh));
}

TEST_CASE("any seed of a campus leaves the route free", "[worlds]") {
  auto [scene, route] = shipped("outdoor_2", 0.4);
  scene.world.campus.relief = 3;
  scene.world.campus.parked = 1;
  scene.world.campus.furniture = 2;
  scene.world.campus.trees = 2;
  for (std::int64_t seed = 100; seed < 103; ++seed) {
    CAPTURE(seed);
    seed_of(scene) = seed;
    const World world = built(scene, route, 0.4);
    CHECK(worst_clearance(world, route) >= 1 - 1e-6);
    CHECK(worst_ground(world, Caster(world.mesh), route) < 0.01);
  }
}

TEST_CASE("any seed of a garage leaves the route free", "[worlds]") {
  const std::string name = GENERATE("indoor_2", "garage_degenerate");
  auto [scene, route] = shipped(name, 1);
  scene.world.garage.clutter = 3;
  scene.world.garage.parked = 1;
  for (std::int64_t seed = 100; seed < 106; ++seed) {
    CAPTURE(name, seed);
    seed_of(scene) = seed;
    const World world = built(scene, route, 1);
    CHECK(worst_clearance(world, route) >= 1 - 1e-6);
    CHECK(worst_ground(world, Caster(world.mesh), route) < 0.01);
  }
}

TEST_CASE("a garage has near pillars and cars and views of 30 to 80 m", "[worlds]") {
  const auto [scene, route] = shipped("indoor_2", 1);
  const World world = built(scene, route, 1);
  const Views views = avia_views(world, Caster(world.mesh), route);
  CAPTURE(views.median, views.far);
  CHECK(views.share > 0.999);
  CHECK((views.median > 3 && views.median < 12));
  CHECK((views.far > 25 && views.far < 80));
}

TEST_CASE("a campus is seen everywhere along its streets, near and far", "[worlds]") {
  const std::string name = GENERATE("outdoor_1", "outdoor_2", "outdoor_3", "outdoor_4", "outdoor_5", "outdoor_6");
  const auto [scene, route] = shipped(name, 1);
  const World world = built(scene, route, 1);
  const Views views = avia_views(world, Caster(world.mesh), route);
  CAPTURE(name, views.share, views.least_share, views.median, views.far);
  CHECK((views.share > 0.6 && views.share < 0.95));
  CHECK(views.least_share > 0.45);
  CHECK((views.median > 5 && views.median < 20));
  CHECK((views.far > 40 && views.far < 100));
}

TEST_CASE("along the bare stretch of a campus nothing but the street stands near", "[worlds]") {
  auto [scene, route] = shipped("outdoor_6", 1);
  CampusParams& params = scene.world.campus;
  /// Share of level rays to both sides that meet something within the width of the stretch.
  const auto seen = [&](const World& world) {
    const Caster caster(world.mesh);
    int rays = 0, hits = 0;
    for (double s = 1; s < params.bare_length - 1; s += 0.25) {
      const Route::Place place = route.at(params.bare_begin * route.length() + s);
      const Vec3 eye(place.at.x(), place.at.y(), world.ground.height(place.at.x(), place.at.y()) + 1.4);
      for (const double side : {-1.0, 1.0}) {
        const Vec3 across(-side * place.direction.y(), side * place.direction.x(), 0);
        hits += std::isfinite(caster.cast(eye, across, params.bare_width - 1).range) ? 1 : 0;
        ++rays;
      }
    }
    return static_cast<double>(hits) / rays;
  };
  CHECK(seen(built(scene, route, 1)) == 0);
  const double length = std::exchange(params.bare_length, 0);
  const World other = built(scene, route, 1);
  params.bare_length = length;
  CHECK(seen(other) > 0.4);
}

TEST_CASE("streets have kerbs, and lie lower than the pavements beside them", "[worlds]") {
  const auto [scene, route] = shipped("outdoor_3", 1);
  const World world = built(scene, route, 1);
  const Caster caster(world.mesh);
  const double half = 0.5 * scene.world.campus.street;
  int low = 0, high = 0, places = 0;
  for (double s = 10; s < 90; s += 0.5) {
    const Route::Place place = route.at(s);
    for (const double side : {-1.0, 1.0}) {
      const auto above_ground = [&](double across) {
        const Vec2 p = place.at + side * across * Vec2(-place.direction.y(), place.direction.x());
        const double z = world.ground.height(p.x(), p.y());
        return 0.3 - caster.cast(Vec3(p.x(), p.y(), z + 0.3), -Vec3::UnitZ(), 10).range;
      };
      ++places;
      low += std::abs(above_ground(half - 0.1)) < 0.01 ? 1 : 0;
      high += std::abs(above_ground(half + 0.1) - 0.12) < 0.01 ? 1 : 0;
    }
  }
  CHECK(low > 0.9 * places);
  CHECK(high > 0.9 * places);
}

TEST_CASE("the way to the garage is bare at first: rays across it end on plane walls", "[worlds]") {
  const double scale = GENERATE(0.4, 1.0);
  const auto [scene, route] = shipped("garage_degenerate", scale);
  const ApproachParams& params = scene.world.approach;
  const World world = built(scene, route, scale);
  const Caster caster(world.mesh);
  const auto deviation = [&](double from, double to) {
    double worst = 0;
    for (double x = from; x < to; x += 0.05) {
      for (const double up : {0.3, 1.0, 1.7, 2.3}) {
        for (const double side : {-1.0, 1.0}) {
          const double range = caster.cast(Vec3(x, 0, world.ground.height(x, 0) + up), Vec3(0, side, 0), 10).range;
          worst = std::max(worst, std::abs(range - 0.5 * params.width));
        }
      }
    }
    return worst;
  };
  CHECK(deviation(0, scale * params.bare) < 1e-5);
  CHECK(deviation(scale * params.bare, scale * params.length - 0.5) > 0.05);
}

TEST_CASE("an approach names the point of the route that leaves its way", "[worlds]") {
  const Route route({{0, 0}, {70, 0}, {70, 10}, {30, 10}});
  CHECK_THROWS_WITH(build_approach({}, route, 1), Catch::Matchers::Contains("point 4 at (30.00, 10.00)"));
  CHECK_THROWS_AS(build_approach({}, route, 1), ConfigError);
}
