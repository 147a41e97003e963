// Two maps behind one: points and queries go where their class belongs.
#include <catch2/catch.hpp>

#include "aslio/core/errors.hpp"
#include "plugins/maps/map_fixture.hpp"

using namespace aslio;
using namespace aslio::test;

namespace {

std::unique_ptr<Map> made(EveryMap& fixture, const std::string& text) {
  return make_stage<Map>(fixture.catalog, text, BuildContext{fixture.exec, fixture.sensor, nullptr});
}

WorldPoint classed(const Vec3& p, std::uint8_t feature) {
  WorldPoint point = at(p);
  point.feature = feature;
  return point;
}

}  // namespace

TEST_CASE("feature_maps: lines and planes are stored, thinned and found apart") {
  EveryMap fixture;
  const auto map = made(fixture,
                        "{type: feature_maps, lines: {type: voxel_hash, min_spacing: 0.2, radius: 20}, "
                        "planes: {type: voxel_hash, min_spacing: 0.4, radius: 30}}");
  using namespace feature_class;
  std::vector<WorldPoint> points;
  for (int i = 0; i < 100; ++i) {
    for (const std::uint8_t feature : {line, plane}) points.push_back(classed({0.1 * i, 0, 0}, feature));
  }
  points.push_back(classed({0, 5, 0}, none));
  const InsertCount count = map->insert(points, 1);
  CHECK(count.offered == 201);
  CHECK(count.inserted == map->size());
  CHECK(count.inserted >= 50 / 2 + 25 + 1);
  std::vector<Vec3> visited = contents(*map);
  CHECK(visited.size() == map->size());
  const std::vector<Vec3> queries{{3.0, 0.05, 0}, {0, 5, 0}};
  Neighbours found;
  MapQuery ask{.k = 5, .max_distance = 0.5};
  std::array<std::size_t, 2> near{};
  for (const std::uint8_t feature : {line, plane}) {
    ask.feature = feature;
    map->correspond(queries, ask, found);
    near[feature - std::size_t{1}] = found.count[0];
    CHECK(found.count[1] == (feature == line ? 0 : 1));  // what has no class is with the planes
  }
  CHECK(near[0] > near[1]);
  CHECK(near[1] >= 2);
  map->trim({25, 0, 0});
  ask.feature = line;
  map->correspond(queries, ask, found);
  CHECK(found.count[0] == 0);
  ask.feature = plane;
  map->correspond(queries, ask, found);
  CHECK(found.count[0] == near[1]);
  CHECK(map->radius() == 30.0);
  map->clear();
  CHECK(map->size() == 0);
}

TEST_CASE("feature_maps refuses a map of surfaces") {
  EveryMap fixture;
  CHECK_THROWS_AS(made(fixture, "{type: feature_maps, planes: {type: voxel_plane}}"), ConfigError);
}
