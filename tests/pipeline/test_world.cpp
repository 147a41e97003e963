// Whole runs in a world with known truth.
#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cmath>

#include "aslio/evaluation/evaluation.hpp"
#include "aslio/simulator/analytic_world.hpp"
#include "pipeline/runs.hpp"

using namespace aslio;
using namespace aslio::test;
using pipeline::TrackingStatus;

namespace {

struct World {
  explicit World(const simulator::Options& options) : world(options) {
    const auto source = world.source();
    recording = record(*source);
  }
  TimeNs at(double t) const { return world.begin_time() + to_ns(t); }

  simulator::AnalyticWorld world;
  Recording recording;
};

/// The fastest rate of an update that ends in (begin, end] [Hz].
double fastest(const Run& run, TimeNs begin, TimeNs end) {
  double rate = 0;
  for (const auto& u : run.updates) {
    if (u.plan.end > begin && u.plan.end <= end) rate = std::max(rate, 1 / to_seconds(u.plan.end - u.plan.fresh_begin));
  }
  return rate;
}

/// Largest error of the estimated vertical, seen from the body, over all updates [rad].
double worst_vertical(const Run& run, const simulator::AnalyticWorld& world) {
  double worst = 0;
  for (const auto& u : run.updates) {
    const Vec3 down = (u.state.R.transpose() * u.state.g).normalized();
    const Vec3 truth = world.pose(u.plan.end).R.transpose() * -Vec3::UnitZ();
    worst = std::max(worst, std::atan2(down.cross(truth).norm(), down.dot(truth)));
  }
  return worst;
}

}  // namespace

TEST_CASE("both pipelines follow the walk, at 10 Hz at rest, the adaptive one faster in sharp turns") {
  const World w({.seed = 2});
  // Measured on seeds 1 to 6: as_lio_plus 0.007 to 0.029 m, 0.17 to 0.45 deg, 2 to 4 mm at the end; fixed_window 0.004
  // to 0.028 m, 0.14 to 0.46 deg, 2 to 6 mm. The bounds are 1.4 times the worst of both.
  for (const std::string name : {"as_lio_plus", "fixed_window"}) {
    Run run(shipped(name), w.world.sensor());
    run.play(w.recording);
    CAPTURE(name);
    CHECK_FALSE(run.odometry.divergence());
    CHECK(run.odometry.tracking() == TrackingStatus::ok);
    CHECK(run.count(UpdateStatus::non_finite) == 0);
    CHECK(run.odometry.initialisation()->initial.mode == InitialMode::static_start);
    const auto found = evaluation::evaluate(run.trajectory(), w.world.truth());
    CHECK(found.ate.translation.rmse < 0.040);
    CHECK(found.ate.rotation.rmse < 0.65);
    CHECK(found.end_to_end.error < 0.009);
    CHECK(found.covered_share > 0.98);
    // Gravity and biases: what the IMU model gave is found again.
    const NavState& last = run.updates.back().state;
    const NavState truth = w.world.state(last.t);
    CHECK(last.g.norm() == Approx(kStandardGravity).epsilon(1e-6));
    CHECK((last.b_w - truth.b_w).norm() < 4e-4);
    CHECK((last.b_a - truth.b_a).norm() < 0.02);
    CHECK(worst_vertical(run, w.world) < 0.035);
    // The walk begins at 1 s. Sharp turns: 4.65 s and 8.66 s, 280 deg/s, into unseen space.
    const bool adaptive = name == "as_lio_plus";
    CHECK(run.rate(w.at(0.2), w.at(1)) == Approx(10.0).epsilon(0.03));
    for (const double turn : {4.65, 8.66}) {
      const double rate = fastest(run, w.at(turn), w.at(turn + 0.9));
      CHECK((adaptive ? rate > 30.0 : rate == Approx(10.0)));
    }
  }
}
