// Every pipeline file of this repository, over a walk with two sharp turns whose truth is known.
#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>

#include "aslio/evaluation/evaluation.hpp"
#include "aslio/simulator/analytic_world.hpp"
#include "pipeline/runs.hpp"

using namespace aslio;
using namespace aslio::test;
using pipeline::TrackingStatus;

namespace {

/// What a pipeline has to reach on this walk, whose view is narrow and in a third of the windows one bare wall.
struct Bound {
  double position_m, rotation_deg;
};

/// Of the published systems, with their inflated noise of the IMU, no more is asked than that they stay whole.
Bound bound_of(const std::string& name) {
  const std::vector<std::string> published = {"fast_lio2", "faster_lio", "point_lio"};
  const bool wide = std::find(published.begin(), published.end(), name) != published.end();
  return wide ? Bound{0.30, 4.0} : Bound{0.15, 2.0};
}

}  // namespace

TEST_CASE("every shipped pipeline follows the walk to its end") {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(ASLIO_SOURCE_DIR "/configs/pipelines")) {
    names.push_back(entry.path().stem());
  }
  std::sort(names.begin(), names.end());
  for (const std::string known :
       {"as_lio", "as_lio_literal", "as_lio_paper_rate", "fixed_window", "fast_lio2", "faster_lio"}) {
    CHECK(std::find(names.begin(), names.end(), known) != names.end());
  }
  const simulator::AnalyticWorld world({.seed = 2});
  const auto source = world.source();
  const Recording recording = record(*source, world.begin_time() + 10 * kSecond);
  for (const std::string& name : names) {
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
