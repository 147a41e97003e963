// Which steps of an update reach the points in proportion to their time (docs/equations.md DSK-4).
#include <catch2/catch.hpp>
#include <cmath>

#include "estimators/ieskf.hpp"
#include "plugins/estimators/room_filter.hpp"

using namespace aslio;
using namespace aslio::test;

namespace {

/// A turn that the gyro reads wrongly, so that the points are distorted by 0.002 rad.
TurningRoom turn() {
  TurningRoom motion;
  motion.rate = Vec3(0, 0, 3.0);
  motion.gyro_error = Vec3(0, 0, 0.02);
  return motion;
}

struct Found {
  NavState state;
  int iterations = 0, redeskews = 0;
  double off_the_walls = 0;   ///< RMS distance of the points for the map from the nearest wall [m]
  double off_trajectory = 0;  ///< greatest distance of such a point from where the trajectory has it [m]
  std::vector<Vec3> points;
};

/// One update of a window of that turn, always over `max_iterations` steps.
Found update(std::vector<std::string> overrides, int max_iterations = 6) {
  overrides.insert(overrides.end(),
                   {"estimator.gyro_calibration=full", "estimator.noise=physical", "estimator.converged_m=1e-12",
                    "estimator.max_iterations=" + std::to_string(max_iterations)});
  Filter filter(overrides);
  filter.build_map(1);
  const RoomWindow room(kRoomEpoch, kTenth, turn(), 2);
  const Update& update = filter.update(room);
  REQUIRE(update.accepted);
  Found out;
  out.state = update.state;
  out.iterations = update.iterations;
  out.redeskews = dynamic_cast<const plugins::Ieskf&>(*filter.estimator).redeskews();
  const Vec3 half(4, 3, 1.5);
  for (const WorldPoint& p : update.points(PointUse::map)) {
    out.points.push_back(p.p_W);
    const double off = (half - p.p_W.cwiseAbs()).cwiseAbs().minCoeff();
    out.off_the_walls += off * off;
    const TimedPoint& raw = room.fresh[p.index];
    const Vec3 there = update.trajectory->pose(raw.t) * Vec3(raw.x, raw.y, raw.z);
    out.off_trajectory = std::max(out.off_trajectory, (there - p.p_W).norm());
  }
  out.off_the_walls = std::sqrt(out.off_the_walls / static_cast<double>(out.points.size()));
  CHECK((update.trajectory->pose(kRoomEpoch + kTenth).p - update.state.p).norm() < 1e-9);
  return out;
}

double farthest(const Found& a, const Found& b) {
  REQUIRE(a.points.size() == b.points.size());
  double most = (a.state.p - b.state.p).norm() + log_so3(a.state.R.transpose() * b.state.R).norm();
  for (std::size_t i = 0; i < a.points.size(); ++i) most = std::max(most, (a.points[i] - b.points[i]).norm());
  return most;
}

const std::string kAsymptotic = "estimator.deskew_correction=asymptotic";
const std::string kOnce = "estimator.redeskew=once_registered", kUntil = "estimator.redeskew=until_converged";

}  // namespace

TEST_CASE("redeskew: without a gate every step reaches the points, with rigid none, and the default has none") {
  const Found all = update({kAsymptotic, "estimator.redeskew=every_iteration"}), plain = update({kAsymptotic});
  CHECK(all.redeskews == all.iterations);
  CHECK(farthest(all, plain) == 0.0);
  CHECK(all.state.R == plain.state.R);
  CHECK(update({"estimator.deskew_correction=rigid"}).redeskews == 0);
}

TEST_CASE("redeskew: a gate that is always open, and one that never is, are the rules without one") {  // eq. DSK-4
  const Found all = update({kAsymptotic}), rigid = update({"estimator.deskew_correction=rigid"});
  const Found open = update({kAsymptotic, kOnce, "estimator.redeskew_below=10"});
  CHECK(open.redeskews == open.iterations);
  CHECK(farthest(open, all) < 1e-9);
  const Found shut = update({kAsymptotic, kOnce, "estimator.redeskew_below=1e-9"});
  CHECK(shut.redeskews == 0);
  CHECK(farthest(shut, rigid) < 1e-9);
  CHECK(farthest(all, rigid) > 1e-3);
}

TEST_CASE("redeskew once_registered: steps count from the residual on that it names") {  // eq. DSK-4
  int before = 6;
  // The residuals of the first iterate are centimetres, those of the later ones millimetres.
  for (const double below : {0.5, 0.02, 0.004, 1e-6}) {
    CAPTURE(below);
    const Found found = update({kAsymptotic, kOnce, "estimator.redeskew_below=" + std::to_string(below)});
    CHECK(found.iterations == 6);
    CHECK(found.redeskews <= before);
    CHECK(found.off_trajectory < 1e-5);
    before = found.redeskews;
  }
  CHECK(before == 0);
}

TEST_CASE("redeskew until_converged: the last steps of an update move the points alike") {  // eq. DSK-4
  const Found all = update({kAsymptotic}), rigid = update({"estimator.deskew_correction=rigid"});
  const Found found = update({kAsymptotic, kUntil});
  CHECK(found.iterations == 6);
  CHECK(found.redeskews >= 1);
  CHECK(found.redeskews < found.iterations);
  CHECK(found.off_trajectory < 1e-5);
  CHECK(found.off_the_walls < 0.4 * rigid.off_the_walls);
  CHECK(farthest(found, all) < 0.5 * farthest(rigid, all));
  // A residual that has to vanish at once leaves the first step alone.
  CHECK(update({kAsymptotic, kUntil, "estimator.redeskew_fall=0.999"}).redeskews == 1);
}

TEST_CASE("redeskew: a refused update leaves the prediction, and other corrections take no gate") {
  Filter filter({kAsymptotic, kOnce, "estimator.min_matches=1000000"});
  filter.build_map(1);
  const Update& refused = filter.update(RoomWindow(kRoomEpoch, kTenth, turn(), 2));
  CHECK(refused.status == UpdateStatus::few_matches);
  CHECK((refused.trajectory->pose(kRoomEpoch + kTenth).p - refused.prior.p).norm() < 1e-12);
  for (const char* rule : {"rigid", "linear", "state"}) {
    CAPTURE(rule);
    CHECK_THROWS_WITH(Filter({std::string("estimator.deskew_correction=") + rule, kUntil}),
                      Catch::Contains("needs deskew_correction: asymptotic"));
  }
}
