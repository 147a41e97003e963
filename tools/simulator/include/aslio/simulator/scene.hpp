#pragma once
/// A scene file (`schema: aslio/scene/1`): world, motion, people, sensors and their errors.

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "aslio/simulator/cars.hpp"
#include "aslio/simulator/drive.hpp"
#include "aslio/simulator/imu_params.hpp"
#include "aslio/simulator/mesh_file.hpp"
#include "aslio/simulator/people.hpp"
#include "aslio/simulator/pose_spline.hpp"
#include "aslio/simulator/realism.hpp"
#include "aslio/simulator/return_model.hpp"
#include "aslio/simulator/route_walk.hpp"
#include "aslio/simulator/worlds/approach.hpp"
#include "aslio/simulator/worlds/campus.hpp"
#include "aslio/simulator/worlds/doorway.hpp"
#include "aslio/simulator/worlds/escalator_hall.hpp"
#include "aslio/simulator/worlds/forest.hpp"
#include "aslio/simulator/worlds/garage.hpp"
#include "aslio/simulator/worlds/library.hpp"
#include "aslio/simulator/worlds/office.hpp"
#include "aslio/simulator/worlds/old_town.hpp"
#include "aslio/simulator/worlds/stairwell.hpp"
#include "aslio/simulator/worlds/street.hpp"
#include "aslio/simulator/worlds/tunnel.hpp"

namespace aslio::simulator {

enum class WorldKind : std::uint8_t {
  office,
  garage,
  library,
  campus,
  approach,
  doorway,
  stairwell,
  old_town,
  tunnel,
  forest,
  escalator_hall,
  street,
  mesh
};
/// All of them, in this order.
inline constexpr std::array<WorldKind, 13> kWorldKinds = {
    WorldKind::office,         WorldKind::garage,    WorldKind::library,  WorldKind::campus, WorldKind::approach,
    WorldKind::doorway,        WorldKind::stairwell, WorldKind::old_town, WorldKind::tunnel, WorldKind::forest,
    WorldKind::escalator_hall, WorldKind::street,    WorldKind::mesh};
enum class MotionKind : std::uint8_t { walk, drive };

/// `world:` has `type` and the keys of that type.
struct WorldParams {
  WorldKind type = WorldKind::office;
  OfficeParams office;
  GarageParams garage;
  LibraryParams library;
  CampusParams campus;
  ApproachParams approach;
  DoorwayParams doorway;
  StairwellParams stairwell;
  OldTownParams old_town;
  TunnelParams tunnel;
  ForestParams forest;
  EscalatorHallParams escalator_hall;
  StreetParams street;
  MeshFileParams mesh;
  static void describe(config::Binder& b, WorldParams& params);
};

/// Seed of the layout; 1 for a mesh.
std::uint64_t world_seed(const WorldParams& params);

/// One corner of the route; a list of [x, y] would lose its units.
struct RoutePoint {
  double x = 0, y = 0;  ///< [m]
  static void describe(config::Binder& b, RoutePoint& point);
};

/// What a stress study adds. All off by default.
struct StressParams {
  double clock_offset = 0;      ///< added to the stamps of the IMU [ms]
  double stamp_jitter = 0;      ///< standard deviation of the IMU stamps [us]; order is kept
  double packet_loss = 0;       ///< share of LiDAR messages lost
  double imu_loss = 0;          ///< share of IMU samples lost
  double extrinsic_angle = 0;   ///< the sensor file is wrong by this much about a random axis [deg]
  double extrinsic_offset = 0;  ///< and by this much in a random direction [m]
  static void describe(config::Binder& b, StressParams& params);
};

/// Exactly one of `route` with `walk` (`drive` where the motion is one), or `follow`. The keys of the other motion do
/// not exist.
struct Scene {
  std::string description;
  SensorKind sensor = SensorKind::avia;
  WorldParams world;
  MotionKind motion = MotionKind::walk;
  std::vector<RoutePoint> route;  ///< of a walk a closed line, of a drive an open one
  WalkParams walk;
  DriveParams drive;
  FollowParams follow;
  PeopleParams people;
  CarsParams cars;
  LidarParams lidar;
  ImuParams imu;
  RealismParams realism;
  StressParams stress;
  static void describe(config::Binder& b, Scene& scene);
};

/// The values and, for messages and relative paths, where they came from.
struct SceneFile {
  Scene scene;
  std::filesystem::path path;
  std::string resolved;  ///< YAML with every key at its effective value
};

/// Throws ConfigError with every problem of the file, each with its line.
SceneFile load_scene(const std::filesystem::path& path, const std::vector<std::string>& overrides = {});
/// The scene with more keys changed ("key.path=value").
SceneFile with_overrides(const SceneFile& scene, const std::vector<std::string>& overrides);

/// "avia", "mid360", ...
std::optional<SensorKind> sensor_kind(std::string_view name);

}  // namespace aslio::simulator
