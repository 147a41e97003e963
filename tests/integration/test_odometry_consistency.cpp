// Whether the covariance of a whole pipeline says how wrong it is, where the map is its own. No bound: an absolute pose
// cannot be consistent against a map that is taken as exact, whose errors all updates share. The figures are printed;
// ASLIO_NEES_SEEDS sets the number of seeds.
#include <Eigen/Cholesky>
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdlib>

#include "aslio/simulator/analytic_world.hpp"
#include "aslio/toolkit/information_update.hpp"
#include "pipeline/runs.hpp"

using namespace aslio;
using namespace aslio::test;

namespace {

/// Number of seeds: of the environment, or enough to see that figures come out.
std::uint64_t seeds() {
  const char* text = std::getenv("ASLIO_NEES_SEEDS");
  return text == nullptr ? 2 : static_cast<std::uint64_t>(std::max(1, std::atoi(text)));
}

double nees(const Vec6& error, const Mat6& P) { return error.dot(P.ldlt().solve(error)); }

/// What an update claims.
struct Claim {
  TimeNs t = 0;
  Pose pose;
  Mat6 P;
  double nis = 0;
};

class Claims final : public pipeline::UpdateObserver {
 public:
  void on_update(const pipeline::UpdateRecord& record) override {
    const Update& update = *record.update;
    if (!update.accepted) return;
    all.push_back({record.plan.end, update.state.pose(), update.P.topLeftCorner<6, 6>(), update.nis});
  }
  std::vector<Claim> all;
};

/// Error of the pose (theta, p), as the filter perturbs it.
Vec6 error_of(const Pose& truth, const Pose& estimate) {
  Vec6 e;
  e << log_so3(estimate.R.transpose() * truth.R), truth.p - estimate.p;
  return e;
}

/// NEES of the motion from `a` to `b`. The covariance takes their errors as independent. As they share some, it is too
/// large, and the figure a lower bound.
double relative_nees(const Claim& a, const Claim& b, const Pose& true_a, const Pose& true_b) {
  const Pose moved = a.pose.inverse() * b.pose;
  Mat6 from = Mat6::Zero(), to = Mat6::Zero();  // of (theta, p) of the motion, by those of a and b
  from.topLeftCorner<3, 3>() = -moved.R.transpose();
  from.bottomLeftCorner<3, 3>() = hat(moved.p);
  from.bottomRightCorner<3, 3>() = -a.pose.R.transpose();
  to.topLeftCorner<3, 3>().setIdentity();
  to.bottomRightCorner<3, 3>() = a.pose.R.transpose();
  const Mat6 P = from * a.P * from.transpose() + to * b.P * to.transpose();
  return nees(error_of(true_a.inverse() * true_b, moved), P);
}

struct Figures {
  std::vector<double> absolute, relative, nis;

  void add(const Claims& claims, const simulator::AnalyticWorld& world, const InitialState& initial) {
    constexpr double settled = 2.0;  // [s]
    // W is what the first pose says it is.
    const Pose W_from_truth = initial.state.pose() * world.pose(initial.state.t).inverse();
    std::size_t before = 0;
    for (const Claim& claim : claims.all) {
      if (to_seconds(claim.t - world.begin_time()) < settled) continue;
      absolute.push_back(nees(error_of(W_from_truth * world.pose(claim.t), claim.pose), claim.P));
      nis.push_back(claim.nis);
      while (claims.all[before].t < claim.t - kSecond) ++before;
      if (claim.t - claims.all[before].t < kSecond * 9 / 10) continue;  // none a second ago
      const Claim& earlier = claims.all[before];
      relative.push_back(relative_nees(earlier, claim, world.pose(earlier.t), world.pose(claim.t)));
    }
  }
};

double mean(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

// eq. IESKF-10.
TEST_CASE("odometry consistency: NEES of the pose and of the motion of 1 s, and NIS, are reported for what they are") {
  for (const char* name : {"as_lio_plus", "fixed_window"}) {
    Figures figures;
    for (std::uint64_t seed = 1; seed <= seeds(); ++seed) {
      const simulator::AnalyticWorld world({.seed = seed});
      const auto source = world.source();
      Run run(shipped(name), world.sensor());
      Claims claims;
      run.odometry.add_observer(claims);
      run.play(record(*source, world.begin_time() + 10 * kSecond));
      CAPTURE(name, seed);
      REQUIRE_FALSE(run.odometry.divergence());
      figures.add(claims, world, run.odometry.initialisation()->initial);
    }
    for (const auto& values : {figures.absolute, figures.relative, figures.nis}) {
      REQUIRE(values.size() >= 50 * seeds());
      CHECK(std::all_of(values.begin(), values.end(), [](double v) { return std::isfinite(v) && v > 0; }));
    }
    WARN(name << ", " << seeds() << " seeds, mean and median over " << figures.nis.size()
              << " updates: NEES of the pose " << mean(figures.absolute) << ", " << median(figures.absolute)
              << "; of the motion of 1 s (a lower bound) " << mean(figures.relative) << ", " << median(figures.relative)
              << " (6 when consistent); NIS per match " << mean(figures.nis) << ", " << median(figures.nis)
              << " (1 when consistent)");
  }
}
