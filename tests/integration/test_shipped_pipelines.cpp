// Every pipeline file of this repository, over a walk with two sharp turns whose truth is known.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <map>
#include <numbers>

#include "aslio/evaluation/evaluation.hpp"
#include "aslio/simulator/analytic_world.hpp"
#include "integration/recorded_scene.hpp"
#include "pipeline/runs.hpp"
#include "plugins/estimators/room.hpp"
#include "shipped_names.hpp"

using namespace aslio;
using namespace aslio::test;
using pipeline::TrackingStatus;

namespace {

/// What a pipeline has to reach on this walk, whose view is narrow and in a third of the windows one bare wall.
struct Bound {
  double position_m, rotation_deg;
};

bool is_published(const std::string& name) {
  const std::vector<std::string> published = {
      "fast_lio2",  "fast_lio2_published", "fast_lio2_indoor", "faster_lio", "faster_lio_published",
      "point_lio",  "point_lio_published", "sr_lio",           "lio_sam",    "super_lio",
      "surfel_lio", "r_voxelmap",          "genz_lio",         "ac_lio"};
  return std::find(published.begin(), published.end(), name) != published.end();
}

/// Of the published systems no more is asked than that they stay whole. Over the seeds 2 to 9 of the noise `fast_lio2`,
/// `fast_lio2_published` and `r_voxelmap` have 0.02 to 0.50 m and 0.5 to 8.0 deg, `as_lio_plus` 0.003 to 0.021 m and
/// 0.1 to 0.4 deg. Why they are worse here is not known.
Bound bound_of(const std::string& name) {
  if (name == "fast_lio2" || name == "fast_lio2_published" || name == "r_voxelmap") return {0.60, 8.5};
  return is_published(name) ? Bound{0.30, 4.0} : Bound{0.15, 2.0};
}

bool uses_imu(const std::string& name) {
  BuildEnvironment environment;
  return shipped(name).estimator.make(environment.context())->uses_imu();
}

/// What a pipeline without IMU does on the quickstart scene today, with room for other roundings.
struct NarrowView {
  std::size_t least_updates, most_updates;
  bool lost;               ///< by its own word
  double good_for;         ///< [s] of data within the next
  double good_position_m;  ///< RMSE after alignment
  double position_m;       ///< RMSE of the whole run after alignment
};

/// The narrow view of a corridor loses them, each in its own place, so that no bound on the whole walk would say much;
/// the part before it does. The walk stands for 1 s and has 269 updates in 26.85 s. Seen, in brackets over 11 runs with
/// the points moved by at most a float's last bit: what another compiler may do.
///  - ct_icp: 0.057 m until 21 s (0.046 to 0.058), off in the last corner but one, where the monitor ends it (216
///    updates). A single step per solve has 4.4 m by then.
///  - kiss_icp: along the first corridor 0.29 m until 4 s, of which one that stands still would have 1.08 m; then no
///    matches, and lost at update 52 (the same each time; with other noise 98 to 170). Without its kernel 0.40 m.
///  - loam: 0.044 m until 9 s (0.031 to 0.065), in the next corner off by 2.5 m, where the monitor ends it (97
///  updates).
///    Without its map 0.77 m until 9 s, with one search in it 0.40 m.
///  - resple_lo: to the end with 0.153 m (seen once).
/// A better end is welcome, and then written here.
NarrowView narrow_view_of(const std::string& name) {
  static const std::map<std::string, NarrowView> known{{"ct_icp", {200, 235, true, 21.0, 0.08, 1.8}},
                                                       {"kiss_icp", {46, 58, true, 4.0, 0.35, 0.5}},
                                                       {"loam", {88, 110, true, 9.0, 0.09, 2.0}},
                                                       {"resple_lo", {262, 276, false, 26.0, 0.35, 0.35}}};
  const auto found = known.find(name);
  if (found == known.end()) FAIL("no bounds are known of a narrow view without IMU by " << name);
  return found->second;
}

/// Translation RMSE [m] after alignment of the poses of the first `seconds` of the truth.
double position_error(const Run& run, const Trajectory& truth, double seconds) {
  std::vector<StampedPose> poses;
  for (const StampedPose& pose : run.trajectory().samples()) {
    if (pose.t <= truth.begin_time() + to_ns(seconds)) poses.push_back(pose);
  }
  return evaluation::evaluate(Trajectory(std::move(poses)), truth).ate.translation.rmse;
}

void check_narrow_view(const Run& run, const Trajectory& truth, const NarrowView& bound) {
  CHECK(run.updates.size() >= bound.least_updates);
  CHECK(run.updates.size() <= bound.most_updates);
  CHECK((run.odometry.divergence() != nullptr) == bound.lost);
  CHECK((run.odometry.tracking() == TrackingStatus::lost) == bound.lost);
  CHECK(position_error(run, truth, bound.good_for) < bound.good_position_m);
  CHECK(position_error(run, truth, 1e6) < bound.position_m);
}

/// A hall of 40 x 30 x 15 m seen all round by 20 rings of 1000 points each 0.1 s, on a circle of 5 m at 2 m/s.
struct Hall {
  static constexpr double kScale = 5.0;  // of room.hpp
  static constexpr TimeNs kSweep = kSecond / 10;
  static constexpr int kRings = 20, kColumns = 1000;

  static Pose pose(TimeNs t) {
    const double angle = 0.4 * to_seconds(t - kRoomEpoch);
    return {exp_so3(angle * Vec3::UnitZ()), 5.0 * Vec3(std::sin(angle), 1.0 - std::cos(angle), 0.0)};
  }
  /// In the frame of the sensor, before it is tilted.
  static Vec3 direction(int ring, int column) {
    const double up = (2.0 * ring + 1.0) / kRings - 1.0, azimuth = 2.0 * std::numbers::pi * column / kColumns;
    const double across = std::sqrt(1.0 - up * up);
    return {across * std::cos(azimuth), across * std::sin(azimuth), up};
  }
  static LidarPacket sweep(std::uint32_t number) {
    LidarPacket packet;
    packet.stamp = kRoomEpoch + number * kSweep;
    // Points of one sweep do not lie where those of the last did, seen from the sensor: they would match as if at rest.
    const Mat3 tilt = exp_so3(number * Vec3(1.1, 2.3, 0.7));
    for (int column = 0; column < kColumns; ++column) {
      const TimeNs t = packet.stamp + (column + 1) * kSweep / kColumns;
      const Pose T = pose(t);
      for (int ring = 0; ring < kRings; ++ring) {
        const Vec3 d = tilt * direction(ring, column);
        const Vec3 p = kScale * wall_distance(T.p / kScale, T.R * d) * d;
        TimedPoint point;
        point.t = t;
        point.x = static_cast<float>(p.x());
        point.y = static_cast<float>(p.y());
        point.z = static_cast<float>(p.z());
        point.sweep_id = number;
        point.line = static_cast<std::uint8_t>(ring);
        packet.points.push_back(point);
      }
    }
    return packet;
  }
};

}  // namespace

TEST_CASE("every shipped pipeline without IMU follows a walk seen all round") {
  Recording recording;
  std::vector<StampedPose> truth;
  for (std::uint32_t k = 0; k < 60; ++k) {
    recording.emplace_back(Hall::sweep(k));
    for (TimeNs t = 0; t < Hall::kSweep; t += Hall::kSweep / 10) {
      truth.push_back({kRoomEpoch + k * Hall::kSweep + t, Hall::pose(kRoomEpoch + k * Hall::kSweep + t)});
    }
  }
  SensorModel sensor;
  sensor.T_imu_lidar = Pose{};
  std::vector<std::string> played;
  for (const std::string& name : shipped_names()) {
    if (uses_imu(name)) continue;
    played.push_back(name);
    Run run(shipped(name), sensor);
    run.play(recording);
    CAPTURE(name);
    REQUIRE_FALSE(run.odometry.divergence());
    CHECK(run.updates.size() >= 59);
    CHECK(run.odometry.stream().counters().imu == 0);
    // A turn rate of 0 would pass for one that was measured.
    CHECK(std::all_of(run.updates.begin(), run.updates.end(), [](const auto& u) { return std::isnan(u.gyro_rms); }));
    const auto found = evaluation::evaluate(run.trajectory(), Trajectory(truth));
    CAPTURE(found.ate.translation.rmse, found.ate.rotation.rmse);
    CHECK(found.ate.translation.rmse < 0.15);
    CHECK(found.ate.rotation.rmse < 2.0);
  }
  CHECK(played == std::vector<std::string>{"ct_icp", "kiss_icp", "loam", "resple_lo"});
}

TEST_CASE("every shipped pipeline with an IMU follows the walk to its end") {
  const std::vector<std::string> names = shipped_names();
  for (const std::string known :
       {"as_lio_plus", "as_lio", "as_lio_plus_paper_rate", "fixed_window", "fast_lio2", "faster_lio"}) {
    CHECK(std::find(names.begin(), names.end(), known) != names.end());
  }
  const simulator::AnalyticWorld world({.seed = 2});
  const auto source = world.source();
  const Recording recording = record(*source, world.begin_time() + 10 * kSecond);
  for (const std::string& name : names) {
    // A narrow view of bare walls through a sharp turn leaves directions open that nothing but an IMU can fill.
    if (!uses_imu(name)) continue;
    Run run(shipped(name), world.sensor());
    run.play(recording);
    CAPTURE(name);
    REQUIRE_FALSE(run.odometry.divergence());
    const TrackingStatus status = run.odometry.tracking();
    CHECK((status == TrackingStatus::ok || status == TrackingStatus::degraded));
    CHECK(run.updates.size() >= 90);
    for (const auto& update : run.updates) {
      REQUIRE((update.state.R.allFinite() && update.state.p.allFinite() && update.state.v.allFinite()));
    }
    const auto found = evaluation::evaluate(run.trajectory(), world.truth());
    CAPTURE(found.ate.translation.rmse, found.ate.rotation.rmse);
    CHECK(found.ate.translation.rmse < bound_of(name).position_m);
    CHECK(found.ate.rotation.rmse < bound_of(name).rotation_deg);
    CHECK(found.covered_share > 0.4);  // 10 s of the 20 s of truth
  }
}

TEST_CASE("every shipped pipeline begins anew after a gap that it must not bridge") {
  const simulator::AnalyticWorld world({.seed = 2});
  const auto source = world.source();
  const TimeNs begin = world.begin_time() + 2 * kSecond, end = begin + to_ns(0.8);
  Recording recording = record(*source, world.begin_time() + to_ns(4.5));
  std::erase_if(recording, [&](const Measurement& m) {
    const auto* packet = std::get_if<LidarPacket>(&m);
    return packet != nullptr && packet->stamp >= begin && packet->stamp < end;
  });
  for (const std::string& name : shipped_names()) {
    CAPTURE(name);
    Run run(shipped(name, {"max_gap=0.5"}), world.sensor());
    run.play(recording);
    REQUIRE(run.odometry.losses().size() == 1);
    REQUIRE(run.odometry.losses().front().restarted);
    CHECK(run.odometry.tracking() == TrackingStatus::ok);
    const auto first =
        std::find_if(run.updates.begin(), run.updates.end(), [](const auto& u) { return u.segment == 1; });
    REQUIRE(first != run.updates.begin());
    REQUIRE(first != run.updates.end());
    CHECK(first->status == UpdateStatus::initialising);
    CHECK((first->state.p - std::prev(first)->state.p).norm() < 2.0);  // from where it was, not from the origin
    const auto [strayed, turned] = run.error_at_end([&](TimeNs t) { return world.pose(t); }, 1);
    CAPTURE(strayed, turned);
    CHECK(strayed < 0.35);  // seen: 0.001 to 0.23 m
  }
}

TEST_CASE(
    "every shipped pipeline on the whole quickstart scene: with an IMU to its end, without as far as it is known to") {
  const simulator::SceneFile scene = simulator::load_scene(ASLIO_SOURCE_DIR "/configs/scenes/quickstart.yaml");
  const simulator::Simulation simulation(scene, {.seed = 1});
  const Recording recording = record(simulation, 3600.0);
  for (const std::string& name : shipped_names()) {
    CAPTURE(name);
    Run run(shipped(name, {"when_lost=end"}), simulation.claimed_sensor());
    run.play(recording);
    REQUIRE(run.updates.size() >= 20);
    for (const auto& update : run.updates) {
      REQUIRE((update.state.R.allFinite() && update.state.p.allFinite() && update.state.v.allFinite()));
    }
    if (!uses_imu(name)) {
      check_narrow_view(run, simulation.truth(), narrow_view_of(name));
      continue;
    }
    CHECK_FALSE(run.odometry.divergence());
    CHECK(run.odometry.tracking() != pipeline::TrackingStatus::lost);
    const auto found = evaluation::evaluate(run.trajectory(), simulation.truth());
    CHECK(found.covered_share > 0.95);
    // Seen: 0.01 to 0.16 m; of fast_lio2 0.12 to 0.59 m with eight seeds of the noise.
    CHECK(found.ate.translation.rmse < (name == "fast_lio2" ? 0.7 : 0.4));
  }
}
