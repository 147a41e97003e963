// Unseen space, gaps in the data, and runs that must end.
#include <catch2/catch.hpp>

#include "aslio/simulator/analytic_world.hpp"
#include "pipeline/runs.hpp"
#include "pipeline/two_buildings.hpp"

using namespace aslio;
using namespace aslio::test;
using Catch::Matchers::Contains;
using pipeline::TrackingStatus;

namespace {

/// The recording without what `drop` names within (begin, end].
template <class T>
Recording without(const Recording& recording, TimeNs begin, TimeNs end) {
  Recording out;
  for (const Measurement& m : recording) {
    TimeNs t = kTimeMin;
    if constexpr (std::is_same_v<T, LidarPacket>) {
      if (const auto* packet = std::get_if<LidarPacket>(&m)) t = packet->stamp;
    } else {
      if (const auto* imu = std::get_if<ImuSample>(&m)) t = imu->t;
    }
    if (t <= begin || t > end) out.push_back(m);
  }
  return out;
}

/// Distance [m] and angle [rad] from the truth, in the frame of the first update.
std::pair<double, double> error_at_end(const Run& run, const std::function<Pose(TimeNs)>& truth) {
  const auto &first = run.updates.front(), &last = run.updates.back();
  const Pose moved = first.state.pose().inverse() * last.state.pose();
  const Pose error = (truth(first.plan.end).inverse() * truth(last.plan.end)).inverse() * moved;
  return {error.p.norm(), log_so3(error.R).norm()};
}

}  // namespace

TEST_CASE("a turn of 180 deg at 300 deg/s into a room never seen: the map goes on growing and the run recovers") {
  const std::string name = GENERATE(std::string("as_lio"), std::string("fixed_window"));
  CAPTURE(name);
  const TwoBuildings world(1.3125, 5.0);  // peak rate 300 deg/s; nothing in view for some 0.25 s
  Run run(shipped(name), world.sensor);
  run.play(world.recording);
  CHECK_FALSE(run.odometry.divergence());
  CHECK(run.odometry.tracking() == TrackingStatus::ok);
  std::size_t unmatched = 0, inserted_unmatched = 0;
  for (const auto& u : run.updates) {
    if (u.status != UpdateStatus::few_matches) continue;
    ++unmatched;
    inserted_unmatched += u.inserted.inserted > 0 ? 1U : 0U;
    CHECK(u.plan.end > world.at(TwoBuildings::kTurnBegin));
  }
  CHECK(unmatched >= 1);  // nothing of the new building is known at first ..
  CHECK(inserted_unmatched >= 1);
  std::size_t before = 0;
  for (const auto& u : run.updates) {
    if (u.plan.end < world.at(TwoBuildings::kTurnBegin)) before = u.map_points;
  }
  CHECK(run.updates.back().map_points > before + before / 2);  // .. and it is well known in the end
  const auto [distance, angle] = error_at_end(run, [&](TimeNs t) { return world.pose(t); });
  CHECK(distance < 0.05);
  CHECK(angle < 0.02);
}

TEST_CASE("dead reckoning for more than a second stops inserting, and the run ends with moment and reason") {
  const TwoBuildings world(1.3125, 5.5);
  // Blind from before the turn until after it: 1.7 s of dead reckoning, then the unseen building.
  const TimeNs blind_until = world.at(TwoBuildings::kTurnBegin + 1.6);
  Run run(shipped("fixed_window", {"insertion.type=on_new"}), world.sensor);
  run.play(without<LidarPacket>(world.recording, world.at(TwoBuildings::kTurnBegin - 0.1), blind_until));
  REQUIRE(run.odometry.divergence());
  CHECK(run.odometry.tracking() == TrackingStatus::lost);
  CHECK_THAT(run.odometry.divergence()->reason, Contains("no accepted update for") && Contains("few_matches"));
  CHECK(run.odometry.divergence()->t == run.updates.back().plan.end);
  CHECK(run.odometry.divergence()->t > blind_until + kSecond / 2);
  std::size_t blind = 0;
  for (const auto& u : run.updates) {
    if (u.plan.end <= blind_until) continue;
    ++blind;
    CHECK(u.status == UpdateStatus::few_matches);
    CHECK(u.inserted.offered == 0);
  }
  CHECK(blind >= 5);
}

TEST_CASE("gaps: 2 s without LiDAR are bridged by the IMU, 0.05 s without IMU are interpolated") {
  const simulator::AnalyticWorld world({.seed = 2});
  const auto source = world.source();
  const TimeNs begin = world.begin_time();
  const Recording whole = record(*source, begin + to_ns(4.5));
  const auto truth = [&](TimeNs t) { return world.pose(t); };
  for (const char* name : {"as_lio", "fixed_window"}) {
    CAPTURE(name);
    Run lidar_gap(shipped(name), world.sensor());
    lidar_gap.play(without<LidarPacket>(whole, begin + to_ns(1.35), begin + to_ns(3.35)));
    CHECK_FALSE(lidar_gap.odometry.divergence());
    CHECK(lidar_gap.odometry.tracking() == TrackingStatus::ok);
    std::size_t bridging = 0;
    for (const auto& u : lidar_gap.updates) {
      if (u.plan.end - u.plan.fresh_begin < 2 * kSecond) continue;
      ++bridging;
      CHECK(u.plan.partial);
    }
    CHECK(bridging == 1);
    CHECK(error_at_end(lidar_gap, truth).first < 0.1);

    Run imu_gap(shipped(name), world.sensor());
    imu_gap.play(without<ImuSample>(whole, begin + to_ns(2.5), begin + to_ns(2.55)));
    CHECK_FALSE(imu_gap.odometry.divergence());
    CHECK(imu_gap.odometry.tracking() == TrackingStatus::ok);
    CHECK(imu_gap.odometry.stream().counters().imu_gaps == 1);
    CHECK(imu_gap.count(UpdateStatus::few_matches) == 0);
    CHECK(error_at_end(imu_gap, truth).first < 0.05);
  }
}

TEST_CASE("a state driven beyond max_speed ends the run, nothing is taken after it") {
  const simulator::AnalyticWorld world({.duration_scale = 0.5});
  const auto source = world.source();
  Recording recording = record(*source, world.begin_time() + to_ns(2.5));
  for (Measurement& m : recording) {
    auto* imu = std::get_if<ImuSample>(&m);
    if (imu != nullptr && imu->t > world.begin_time() + kSecond) imu->acc.x() += 2000;
  }
  Run run(shipped("fixed_window"), world.sensor());
  run.play(recording);
  REQUIRE(run.odometry.divergence());
  CHECK_THAT(run.odometry.divergence()->reason, Contains("m/s, above max_speed 30.0 m/s"));
  CHECK(run.odometry.divergence()->t > world.begin_time() + kSecond);
  CHECK(run.odometry.divergence()->t < world.begin_time() + to_ns(1.3));
  CHECK(run.updates.back().plan.end == run.odometry.divergence()->t);
}
