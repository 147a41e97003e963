// Something covers the lens for a while: the run says so, goes on by the IMU, and recovers or ends.
#include <algorithm>
#include <catch2/catch.hpp>

#include "aslio/simulator/analytic_world.hpp"
#include "pipeline/runs.hpp"

using namespace aslio;
using namespace aslio::test;
using Catch::Matchers::Contains;
using pipeline::TrackingStatus;

namespace {

/// The recording with one point in 4000 left of the packets that begin within [begin, end).
Recording covered(const Recording& recording, TimeNs begin, TimeNs end) {
  Recording out = recording;
  for (Measurement& m : out) {
    auto* packet = std::get_if<LidarPacket>(&m);
    if (packet == nullptr || packet->stamp < begin || packet->stamp >= end) continue;
    std::vector<TimedPoint> left;
    for (std::size_t i = 0; i < packet->points.size(); i += 4000) left.push_back(packet->points[i]);
    packet->points = std::move(left);
  }
  return out;
}

/// How the status went, without repetitions.
std::vector<TrackingStatus> course(const Run& run) {
  std::vector<TrackingStatus> out;
  for (const auto& u : run.updates) {
    if (out.empty() || out.back() != u.tracking) out.push_back(u.tracking);
  }
  return out;
}

std::size_t count(const Run& run, TrackingStatus status) {
  return static_cast<std::size_t>(
      std::count_if(run.updates.begin(), run.updates.end(), [&](const auto& u) { return u.tracking == status; }));
}

}  // namespace

TEST_CASE("covered lens: 0.6 s degrade the run, five good updates make it whole, more than a second is a loss") {
  const simulator::AnalyticWorld world({.seed = 3});
  const auto source = world.source();
  const TimeNs begin = world.begin_time();
  const Recording whole = record(*source, begin + to_ns(6.5));
  for (const char* name : {"as_lio_plus", "fixed_window"}) {
    CAPTURE(name);
    Run brief(shipped(name), world.sensor());
    brief.play(covered(whole, begin + to_ns(2.5), begin + to_ns(3.1)));
    CHECK_FALSE(brief.odometry.divergence());
    CHECK(course(brief) == std::vector{TrackingStatus::initialising, TrackingStatus::ok, TrackingStatus::degraded,
                                       TrackingStatus::recovering, TrackingStatus::ok});
    // The first 0.15 s are a blink, as of an empty message.
    CHECK(count(brief, TrackingStatus::degraded) + 2 >= brief.count(UpdateStatus::few_matches));
    CHECK(count(brief, TrackingStatus::degraded) < brief.count(UpdateStatus::few_matches));
    CHECK(count(brief, TrackingStatus::recovering) == 4);
    CHECK(brief.error_at_end([&](TimeNs t) { return world.pose(t); }).first < 0.05);

    Run longer(shipped(name), world.sensor());
    longer.play(covered(whole, begin + to_ns(2.5), begin + to_ns(4.0)));
    REQUIRE(longer.odometry.divergence());
    CHECK_THAT(longer.odometry.divergence()->reason, Contains("no accepted update for 1.") && Contains("few_matches"));
    CHECK(longer.odometry.divergence()->t > begin + to_ns(3.5));
    CHECK(longer.odometry.divergence()->t < begin + to_ns(3.8));
    // The first new start has only what the cover lets through, the second has a view.
    using enum TrackingStatus;
    CHECK(course(longer) == std::vector{initialising, ok, degraded, lost, recovering, degraded, lost, recovering, ok});
    CHECK(longer.odometry.losses().size() == 2);
    Run ends(shipped(name, {"when_lost=end"}), world.sensor());
    ends.play(covered(whole, begin + to_ns(2.5), begin + to_ns(4.0)));
    CHECK(course(ends) == std::vector{initialising, ok, degraded, lost});
  }
}
