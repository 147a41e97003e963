#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>

#include "aslio/core/errors.hpp"
#include "aslio/simulator/scene.hpp"
#include "closure.hpp"
#include "routes.hpp"
#include "swings.hpp"

using namespace aslio;
using namespace aslio::simulator;
using namespace aslio::simulator::test;

namespace {

/// Files of configs/scenes whose motion is a walk over a route.
std::vector<SceneFile> shipped_walks() {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(ASLIO_SOURCE_DIR "/configs/scenes"))
    if (entry.path().extension() == ".yaml") files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  std::vector<SceneFile> scenes;
  for (const auto& file : files) {
    scenes.push_back(load_scene(file));
    if (scenes.back().scene.route.empty() || scenes.back().scene.motion != MotionKind::walk) scenes.pop_back();
  }
  REQUIRE(!scenes.empty());
  return scenes;
}

Route scaled_route(const Scene& scene, double scale) {
  std::vector<Vec2> points;
  for (const RoutePoint& p : scene.route) points.emplace_back(scale * p.x, scale * p.y);
  return Route(std::move(points));
}

}  // namespace

TEST_CASE("every shipped walk ends exactly where it began, at any scale and with any gait") {
  for (const SceneFile& file : shipped_walks())
    for (const double scale : {0.2, 0.5, 1.0, 3.0})
      for (const GaitKind gait : kGaits)
        for (const std::uint64_t seed : {1, 5}) {
          if (scale != 1 && file.scene.world.type == WorldKind::stairwell) continue;  // steps do not scale
          CAPTURE(file.path.stem().string(), scale, static_cast<int>(gait), seed);
          WalkParams params = file.scene.walk;
          params.gait = gait;
          const auto walk = make_route_walk(scaled_route(file.scene, scale), hilly(), params, seed);
          check_closed(*walk, params.standstill);
          if (!params.dynamic_start) check_still_before(*walk, params.standstill);
        }
}

TEST_CASE("the shipped scenes turn 90 deg in 0.4 to 0.8 s with peaks of 180 to 450 deg/s") {
  for (const SceneFile& file : shipped_walks()) {
    WalkParams params = file.scene.walk;
    params.gait = GaitKind::smooth;
    params.glances.clear();
    std::size_t sharp = 0;
    for (const std::uint64_t seed : {1, 2, 3})
      for (const Swing& swing : swings(*make_route_walk(scaled_route(file.scene, 1), Ground{}, params, seed))) {
        CAPTURE(file.path.stem().string(), seed, swing.begin, swing.angle);
        const double angle = std::abs(swing.angle), sharper = std::max(1.0, angle / 90);
        CHECK(swing.duration / sharper > 0.39);
        CHECK(swing.duration / sharper < 0.81);
        CHECK(swing.peak < 450);
        if (angle < 60) continue;
        ++sharp;
        CHECK(swing.peak > 180);
      }
    CAPTURE(file.path.stem().string());
    CHECK(sharp >= 9);
  }
}

TEST_CASE("keys of a walk out of range are refused by name") {
  const std::string scene = ASLIO_SOURCE_DIR "/configs/scenes/quickstart.yaml";
  const auto refusal = [&](const std::string& change) -> std::string {
    try {
      load_scene(scene, {change});
    } catch (const ConfigError& error) {
      return error.what();
    }
    return "accepted";
  };
  CHECK_THAT(refusal("walk.speed=0"), Catch::Contains("walk.speed") && Catch::Contains("0.1"));
  CHECK_THAT(refusal("walk.corner_speed=5"),
             Catch::Contains("walk.corner_speed") && Catch::Contains("must not be above speed"));
  CHECK_THAT(refusal("walk.turn_min=0.9"),
             Catch::Contains("walk.turn_min") && Catch::Contains("must not be above turn_max"));
  CHECK_THAT(refusal("walk.gait=hopping"), Catch::Contains("walk.gait") && Catch::Contains("oscillating"));
  CHECK_THAT(refusal("walk.laps=0"), Catch::Contains("walk.laps"));
  CHECK_THAT(refusal("walk.standstill=nan"), Catch::Contains("walk.standstill"));
  CHECK_THAT(refusal("walk.height=0"), Catch::Contains("walk.height"));
}
