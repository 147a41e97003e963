#include "aslio/simulator/scene.hpp"

#include <array>
#include <utility>

#include "aslio/config/load.hpp"

namespace aslio::simulator {
namespace {

/// Scenes have no stages.
class NoStages final : public config::StageLookup {
 public:
  const config::StageEntry* find(std::string_view, std::string_view) const override { return nullptr; }
  std::vector<std::string> families() const override { return {}; }
  std::vector<std::string> types(std::string_view) const override { return {}; }
};

std::vector<config::Override> as_overrides(const std::vector<std::string>& texts) {
  std::vector<config::Override> overrides;
  for (const std::string& text : texts) overrides.push_back({text});
  return overrides;
}

/// The keys of the chosen type stand beside `type`.
void describe_world(config::Binder& b, WorldParams& params) {
  switch (params.type) {
    case WorldKind::office:
      return OfficeParams::describe(b, params.office);
    case WorldKind::garage:
      return GarageParams::describe(b, params.garage);
    case WorldKind::library:
      return LibraryParams::describe(b, params.library);
    case WorldKind::campus:
      return CampusParams::describe(b, params.campus);
    case WorldKind::approach:
      return ApproachParams::describe(b, params.approach);
    case WorldKind::doorway:
      return DoorwayParams::describe(b, params.doorway);
    case WorldKind::stairwell:
      return StairwellParams::describe(b, params.stairwell);
    case WorldKind::old_town:
      return OldTownParams::describe(b, params.old_town);
    case WorldKind::tunnel:
      return TunnelParams::describe(b, params.tunnel);
    case WorldKind::forest:
      return ForestParams::describe(b, params.forest);
    case WorldKind::escalator_hall:
      return EscalatorHallParams::describe(b, params.escalator_hall);
    case WorldKind::street:
      return StreetParams::describe(b, params.street);
    case WorldKind::mesh:
      return MeshFileParams::describe(b, params.mesh);
  }
}

}  // namespace

void WorldParams::describe(config::Binder& b, WorldParams& params) {
  b.choice("type", params.type,
           {{"office", WorldKind::office},
            {"garage", WorldKind::garage},
            {"library", WorldKind::library},
            {"campus", WorldKind::campus},
            {"approach", WorldKind::approach},
            {"doorway", WorldKind::doorway},
            {"stairwell", WorldKind::stairwell},
            {"old_town", WorldKind::old_town},
            {"tunnel", WorldKind::tunnel},
            {"forest", WorldKind::forest},
            {"escalator_hall", WorldKind::escalator_hall},
            {"street", WorldKind::street},
            {"mesh", WorldKind::mesh}},
           "kind of world; the other keys depend on it");
  describe_world(b, params);
}

std::uint64_t world_seed(const WorldParams& params) {
  const auto seed = [&]() -> std::int64_t {
    switch (params.type) {
      case WorldKind::office:
        return params.office.seed;
      case WorldKind::garage:
        return params.garage.seed;
      case WorldKind::library:
        return params.library.seed;
      case WorldKind::campus:
        return params.campus.seed;
      case WorldKind::approach:
        return params.approach.seed;
      case WorldKind::doorway:
        return params.doorway.seed;
      case WorldKind::stairwell:
        return params.stairwell.seed;
      case WorldKind::old_town:
        return params.old_town.seed;
      case WorldKind::tunnel:
        return params.tunnel.seed;
      case WorldKind::forest:
        return params.forest.seed;
      case WorldKind::escalator_hall:
        return params.escalator_hall.seed;
      case WorldKind::street:
        return params.street.seed;
      case WorldKind::mesh:
        break;
    }
    return 1;
  };
  return static_cast<std::uint64_t>(seed());
}

void RoutePoint::describe(config::Binder& b, RoutePoint& point) {
  b.real("x", point.x, "m", {.min = -2000.0, .max = 2000.0}, "position in the plan");
  b.real("y", point.y, "m", {.min = -2000.0, .max = 2000.0}, "position in the plan");
}

void StressParams::describe(config::Binder& b, StressParams& params) {
  b.real("clock_offset", params.clock_offset, "ms", {.min = -1000.0, .max = 1000.0}, "added to the stamps of the IMU");
  b.real("stamp_jitter", params.stamp_jitter, "us", {.min = 0.0, .max = 10000.0},
         "standard deviation of the stamps of the IMU; their order is kept");
  b.real("packet_loss", params.packet_loss, "1", {.min = 0.0, .max = 0.9}, "share of LiDAR messages that are lost");
  b.real("imu_loss", params.imu_loss, "1", {.min = 0.0, .max = 0.9}, "share of IMU samples that are lost");
  b.real("extrinsic_angle", params.extrinsic_angle, "deg", {.min = 0.0, .max = 45.0},
         "error of the rotation in the sensor file, about a random axis");
  b.real("extrinsic_offset", params.extrinsic_offset, "m", {.min = 0.0, .max = 1.0},
         "error of the translation in the sensor file, in a random direction");
}

namespace {

/// Keys of realism that would do nothing.
void require_realism(config::Binder& b, const Scene& scene) {
  const RealismParams& r = scene.realism;
  const auto given = [](const std::optional<double>& value) { return value.value_or(0) > 0; };
  const bool gait = given(r.gait.heel) || given(r.gait.sway) || given(r.gait.tremor) || given(r.gait.turns);
  const bool walked = scene.motion == MotionKind::walk && scene.follow.file.empty();
  b.require(!gait || walked, "realism", "gait needs a route that is walked: leave the keys of realism.gait out");
  b.require(!(given(r.gait.heel) || given(r.gait.sway)) || scene.walk.gait != GaitKind::smooth, "realism",
            "heel and sway need steps: walk.gait is smooth");
  b.require(!(given(r.surface.unevenness) || given(r.surface.relief)) || scene.world.type != WorldKind::mesh, "realism",
            "a world of type mesh has the surfaces of its triangles: leave the keys of realism.surface out");
}

/// Which motion fits which world.
void require_places(config::Binder& b, const Scene& scene) {
  const bool drives = scene.motion == MotionKind::drive, street = scene.world.type == WorldKind::street;
  b.require(!drives || street || scene.world.type == WorldKind::mesh, "world",
            "a drive needs a world of type street or mesh");
  b.require(drives || !street, "motion", "a world of type street is driven: give motion: drive");
  const CarsParams& cars = scene.cars;
  b.require(street || cars.ahead + cars.behind + cars.oncoming + cars.beside == 0, "cars",
            "cars need the lanes of a world of type street");
}

}  // namespace

void Scene::describe(config::Binder& b, Scene& scene) {
  b.text("description", scene.description, "what the scene is for");
  b.choice("sensor", scene.sensor,
           {{"avia", SensorKind::avia},
            {"mid360", SensorKind::mid360},
            {"spin16", SensorKind::spin16},
            {"spin32", SensorKind::spin32},
            {"spin64", SensorKind::spin64},
            {"vlp16", SensorKind::vlp16},
            {"mid40", SensorKind::mid40}},
           "the LiDAR");
  b.group("world", scene.world, "what does not move");
  b.choice("motion", scene.motion, {{"walk", MotionKind::walk}, {"drive", MotionKind::drive}},
           "on foot round the route, or by car along it");
  b.groups("route", scene.route,
           "corners of the closed line that is walked, or of the open one that is driven; the first is the start");
  if (scene.motion == MotionKind::drive) {
    b.group("drive", scene.drive, "how the route is driven");
    b.group("cars", scene.cars, "who else is on the road");
  } else {
    b.group("walk", scene.walk, "how the route is walked");
    b.group("follow", scene.follow, "a recorded trajectory to follow instead of a route");
    b.group("people", scene.people, "who walks about");
  }
  b.group("lidar", scene.lidar, "errors of the LiDAR");
  b.group("imu", scene.imu, "errors of the IMU");
  b.group("realism", scene.realism, "what real sensors, mounts, surfaces and people do besides");
  b.group("stress", scene.stress, "what goes wrong besides");
  const bool follows = !scene.follow.file.empty();
  b.require(follows != !scene.route.empty(), "route",
            "give either route (at least 2 points) or follow.file, one of the two");
  require_places(b, scene);
  require_realism(b, scene);
  const PeopleParams& people = scene.people;
  const bool alone = people.walking + people.ahead + people.crossing == 0;
  b.require(!follows || alone, "people", "people walk along a route: a scene that follows a file has none");
  b.require(scene.world.type != WorldKind::stairwell || alone, "people",
            "people stay on one level: a world of type stairwell has none, leave the group out");
}

SceneFile load_scene(const std::filesystem::path& path, const std::vector<std::string>& overrides) {
  const NoStages stages;
  config::Loaded<Scene> loaded = config::load<Scene>(path, config::FileKind::scene, stages, as_overrides(overrides));
  return {std::move(loaded.value), path, std::move(loaded.resolved)};
}

SceneFile with_overrides(const SceneFile& scene, const std::vector<std::string>& overrides) {
  const NoStages stages;
  config::Loaded<Scene> loaded = config::parse<Scene>(scene.resolved, scene.path.string(), config::FileKind::scene,
                                                      stages, as_overrides(overrides));
  return {std::move(loaded.value), scene.path, std::move(loaded.resolved)};
}

std::optional<SensorKind> sensor_kind(std::string_view name) {
  for (const SensorKind kind : kSensorKinds)
    if (facts(kind).name == name) return kind;
  return std::nullopt;
}

}  // namespace aslio::simulator
