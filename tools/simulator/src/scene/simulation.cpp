#include "aslio/simulator/simulation.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "aslio/core/angles.hpp"
#include "aslio/core/errors.hpp"
#include "aslio/simulator/random.hpp"
#include "mesh/roughness.hpp"
#include "purposes.hpp"

namespace aslio::simulator {
namespace {

constexpr double kTruthRate = 200;  ///< [Hz]
/// About 0.5 GB: samples, biases and poses are kept.
constexpr double kMaxSamples = 4e6;

std::filesystem::path beside(const SceneFile& scene, const std::string& file) {
  return std::filesystem::path(file).is_absolute() ? std::filesystem::path(file) : scene.path.parent_path() / file;
}

World build_world(const SceneFile& scene, const Route* route, double scale) {
  const WorldParams& world = scene.scene.world;
  if (world.type == WorldKind::mesh) return load_mesh_world(beside(scene, world.mesh.file), world.mesh);
  if (route == nullptr)
    throw ConfigError(
        fmt::format("{}: world: only a world of type mesh can be walked without a route", scene.path.string()));
  switch (world.type) {
    case WorldKind::garage:
      return build_garage(world.garage, *route, scale);
    case WorldKind::library:
      return build_library(world.library, *route, scale);
    case WorldKind::campus:
      return build_campus(world.campus, *route, scale);
    case WorldKind::approach:
      return build_approach(world.approach, *route, scale);
    case WorldKind::doorway:
      return build_doorway(world.doorway, *route, scale);
    case WorldKind::stairwell:
      return build_stairwell(world.stairwell, *route, scale);
    case WorldKind::old_town:
      return build_old_town(world.old_town, *route, scale);
    case WorldKind::tunnel:
      return build_tunnel(world.tunnel, *route, scale);
    case WorldKind::forest:
      return build_forest(world.forest, *route, scale);
    case WorldKind::escalator_hall:
      return build_escalator_hall(world.escalator_hall, *route, scale);
    default:
      return build_office(world.office, *route, scale);
  }
}

std::vector<Vec2> scaled_points(const Scene& scene, double scale) {
  std::vector<Vec2> points;
  for (const RoutePoint& p : scene.route) points.emplace_back(scale * p.x, scale * p.y);
  return points;
}

std::unique_ptr<Route> scaled_route(const SceneFile& scene, double scale) {
  if (scene.scene.route.empty()) {
    if (scale != 1)
      throw ConfigError(fmt::format("{}: --scale {}: a scene that follows a trajectory has no route to scale",
                                    scene.path.string(), scale));
    return nullptr;
  }
  return std::make_unique<Route>(scaled_points(scene.scene, scale));
}

Vec3 random_direction(RandomStream& stream) {
  const Vec3 v(stream.normal(), stream.normal(), stream.normal());
  return v.normalized();
}

SensorModel true_sensor(SensorKind kind, const LidarParams& lidar, const ImuModel& imu,
                        const std::optional<Pose>& T_imu_lidar) {
  const SensorFacts& f = facts(kind);
  SensorModel sensor;
  sensor.T_imu_lidar.p = f.p_imu_lidar;
  if (T_imu_lidar) sensor.T_imu_lidar = *T_imu_lidar;
  sensor.scan_lines = static_cast<int>(make_scan_pattern(kind)->beams_per_firing());
  sensor.min_range = lidar.min_range.value_or(f.min_range);
  sensor.max_range = lidar.max_range.value_or(f.max_range);
  sensor.sweep_period = to_seconds(Simulation::kPacketPeriod);
  // A sensor file has to hold positive densities: those of an IMU without noise are left at their defaults.
  if (imu.gyro_noise > 0) sensor.gyro_noise = imu.gyro_noise;
  if (imu.acc_noise > 0) sensor.acc_noise = imu.acc_noise;
  if (imu.gyro_bias_walk > 0) sensor.gyro_bias_walk = imu.gyro_bias_walk;
  if (imu.acc_bias_walk > 0) sensor.acc_bias_walk = imu.acc_bias_walk;
  return sensor;
}

/// The extrinsic turned about an axis [rad] and moved [m].
void displace(SensorModel& sensor, const Vec3& axis, double angle, const Vec3& shift) {
  if (angle > 0) sensor.T_imu_lidar.R = Eigen::AngleAxisd(angle, axis).toRotationMatrix() * sensor.T_imu_lidar.R;
  sensor.T_imu_lidar.p += shift;
}

void add_errors(SensorModel& sensor, const StressParams& stress, std::uint64_t seed) {
  RandomStream stream(seed, purpose::kExtrinsicError);
  const Vec3 axis = random_direction(stream), direction = random_direction(stream);
  displace(sensor, axis, stress.extrinsic_angle * std::numbers::pi / 180, stress.extrinsic_offset * direction);
}

/// A mount that is measured as well as one can: part of each bound at least.
void add_mount_error(SensorModel& sensor, const MountRealism& mount, std::uint64_t seed) {
  constexpr double kLeastAngle = 0.2, kLeastOffset = 0.3;
  RandomStream stream(seed, purpose::kMountRealism);
  const Vec3 axis = random_direction(stream), direction = random_direction(stream);
  const double angle = mount.angle * kRadPerDeg * stream.uniform(kLeastAngle, 1);
  displace(sensor, axis, angle, mount.offset * stream.uniform(kLeastOffset, 1) * direction);
}

}  // namespace

std::uint64_t cell_key(const Vec3& p_W) {
  static const Vec3 kCorner(0.0937, 0.0719, 0.0613);
  std::uint64_t key = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const auto cell = static_cast<std::int64_t>(std::floor((p_W[axis] - kCorner[axis]) / kOverlapCell));
    key = key << 21U | (static_cast<std::uint64_t>(cell + (1 << 20)) & 0x1fffffU);
  }
  return key;
}

Simulation::Simulation(const SceneFile& file, const SimulationOptions& options)
    : scene_(file.scene),
      realism_(simulator::realism(file.scene.realism)),
      options_(options),
      kind_(options.sensor.value_or(file.scene.sensor)) {
  if (!(options.scale >= kMinScale && options.scale <= kMaxScale))
    throw ConfigError(fmt::format("scale is {}, must be in [{}, {}]", options.scale, kMinScale, kMaxScale));
  // A scanned mesh has its own surfaces, and what of it is glass is not known.
  if (scene_.world.type == WorldKind::mesh) {
    realism_.surface = {};
    if (!scene_.realism.glass) realism_.glass = 0;
  }
  try {
    build(file);
  } catch (const ConfigError& error) {
    const std::string place = file.path.string();
    const std::string scaled = options.scale == 1 ? "" : fmt::format(" (at scale {:g})", options.scale);
    if (std::string_view(error.what()).starts_with(place)) throw;
    throw ConfigError(fmt::format("{}: {}{}", place, error.what(), scaled));
  }
}

/// Road, world, drive and the cars about it.
void Simulation::build_drive(const SceneFile& file) {
  road_ = std::make_unique<RoadLine>(scaled_points(scene_, options_.scale), scene_.drive.bend_radius);
  const WorldParams& params = scene_.world;
  World world = params.type == WorldKind::mesh ? load_mesh_world(beside(file, params.mesh.file), params.mesh)
                                               : build_street(params.street, *road_);
  ground_ = std::move(world.ground);
  caster_ = std::make_unique<Caster>(std::move(world.mesh));
  auto drive = std::make_unique<Drive>(*road_, ground_, scene_.drive, options_.seed);
  cars_ = Cars(scene_.cars, params.street, ground_, *drive, options_.seed);
  motion_ = std::move(drive);
}

void Simulation::build_walk(const SceneFile& file) {
  route_ = scaled_route(file, options_.scale);
  World world = build_world(file, route_.get(), options_.scale);
  ground_ = std::move(world.ground);
  caster_ = std::make_unique<Caster>(std::move(world.mesh));
  if (route_) {
    motion_ = make_route_walk(*route_, ground_, scene_.walk, options_.seed, realism_.gait);
    // Of the walk without a body, so that gait moves nobody else.
    const std::unique_ptr<Motion> plain = make_route_walk(*route_, ground_, scene_.walk, options_.seed);
    if (!world.climbs.empty()) motion_ = make_climbing(std::move(motion_), *plain, *route_, std::move(world.climbs));
    people_ = People(scene_.people, *route_, ground_, *plain, options_.seed);
  } else {
    motion_ = follow_file(beside(file, scene_.follow.file), scene_.follow.knot_interval, &follow_error_);
  }
}

void Simulation::build(const SceneFile& file) {
  if (scene_.motion == MotionKind::drive) {
    build_drive(file);
  } else {
    build_walk(file);
  }
  pattern_ = make_scan_pattern(kind_, scene_.lidar.columns);
  const ImuModel model = with_realism(imu_model(scene_.imu), realism_.imu, facts(kind_).motor);
  sensor_ = true_sensor(kind_, scene_.lidar, model, options_.T_imu_lidar);
  claimed_sensor_ = sensor_;
  add_errors(claimed_sensor_, scene_.stress, options_.seed);
  // A recording in another's layout has its sensor file: there it is the mount that is wrong.
  add_mount_error(options_.T_imu_lidar ? sensor_ : claimed_sensor_, realism_.mount, options_.seed);
  roughness_ = std::make_unique<Roughness>(realism_.surface, world_seed(scene_.world));
  duration_ = std::min(motion_->duration(), options_.duration.value_or(motion_->duration()));
  const double samples = duration_ * std::max(model.rate, kTruthRate);
  if (samples > kMaxSamples)
    throw ConfigError(
        fmt::format("the motion lasts {:.0f} s: {:.3g} samples at {:g} Hz, at most {:g} fit into memory. Give fewer "
                    "walk.laps, a shorter route or a lower imu.rate",
                    duration_, samples, std::max(model.rate, kTruthRate), kMaxSamples));
  imu_ = simulate_imu(*motion_, options_.begin, duration_, model, options_.seed);
}

Simulation::~Simulation() = default;

TimeNs Simulation::end_time() const { return options_.begin + to_ns(duration()); }

Trajectory Simulation::truth() const {
  std::vector<StampedPose> poses;
  const auto add = [&](TimeNs since) {
    const MotionState m = motion_->at(to_seconds(since));
    poses.push_back({options_.begin + since, {m.R, m.p}});
  };
  const TimeNs end = to_ns(duration());
  const auto count = static_cast<std::int64_t>(std::floor(duration() * kTruthRate));
  for (std::int64_t k = 0; k <= count; ++k) add(std::min(end, to_ns(static_cast<double>(k) / kTruthRate)));
  if (poses.back().t < options_.begin + end) add(end);
  return Trajectory(std::move(poses));
}

std::size_t Simulation::packet_count() const {
  return static_cast<std::size_t>((to_ns(duration()) + kPacketPeriod - 1) / kPacketPeriod);
}

}  // namespace aslio::simulator
