// The fixed-lag smoother's own solver against Ceres, with numeric derivatives: one model, two solutions (LAG-4).
#include <ceres/ceres.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include "plugins/estimators/smooth_motion.hpp"

using namespace aslio;
using namespace aslio::test;

namespace {

constexpr int kWindows = 12;

/// What was measured, and what was guessed.
struct Chain {
  std::vector<NavState> guess{NavState{}};
  std::vector<Preintegration> motions;
  std::vector<Pose> poses;
  Vec15 sigma = start_sigma();

  Chain() {
    for (int k = 0; k < kWindows; ++k) {
      std::vector<ImuSample> imu;
      for (int i = 0; i <= 20; ++i) imu.push_back(smooth_sample(0.1 * k + 0.005 * i));
      motions.emplace_back(imu, NavState{}, InertialNoise{});
      const NavState to = carried(guess.back(), motions.back());
      guess.push_back(to);
      // Registrations that disagree with the IMU, and with each other.
      poses.push_back({to.R * exp_so3(0.02 * Vec3(std::sin(k), std::cos(2 * k), 0.5 + std::sin(3 * k))),
                       to.p + 0.03 * Vec3(std::cos(k), k % 3, std::sin(2 * k))});
    }
  }
};

/// A term over deviations of its states from the guess.
struct Rows {
  const StateTerm* term;
  const NavState *i, *j;

  bool operator()(double const* const* xi, double* out) const {
    const NavState at_i = moved(*i, Eigen::Map<const Vec15>(xi[0]));
    NavState at_j;
    if (term->two()) at_j = moved(*j, Eigen::Map<const Vec15>(xi[1]));
    const StateTerm::Rows r = term->at(at_i, term->two() ? &at_j : nullptr).r;
    Eigen::Map<Eigen::VectorXd>(out, r.size()) = r;
    return true;
  }
};

struct Solution {
  std::vector<NavState> states;
  Mat15 covariance;  ///< of the newest
};

void add(ceres::Problem& problem, const StateTerm& term, const Chain& chain, std::vector<Vec15>& xi) {
  const auto i = static_cast<std::size_t>(term.node());
  const NavState* next = term.two() ? &chain.guess[i + 1] : nullptr;
  auto* cost = new ceres::DynamicNumericDiffCostFunction<Rows, ceres::RIDDERS>(new Rows{&term, &chain.guess[i], next});
  std::vector<double*> blocks{xi[i].data()};
  cost->AddParameterBlock(kNodeDim);
  if (term.two()) {
    cost->AddParameterBlock(kNodeDim);
    blocks.push_back(xi[i + 1].data());
  }
  cost->SetNumResiduals(term.rows());
  problem.AddResidualBlock(cost, nullptr, blocks);
}

Solution by_ceres(const Chain& chain, const LagWindow::Params& params) {
  std::vector<std::unique_ptr<StateTerm>> terms;
  Mat15 to_world = Mat15::Identity();
  to_world.topLeftCorner<3, 3>() = chain.guess[0].R;
  const Mat15 U = chain.sigma.cwiseInverse().asDiagonal() * to_world;
  terms.push_back(std::make_unique<PriorTerm>(0, chain.guess[0], U, Vec15::Zero()));
  for (int k = 0; k < kWindows; ++k) {
    const auto at = static_cast<std::size_t>(k);
    terms.push_back(std::make_unique<InertialTerm>(k, chain.motions[at], chain.guess[0].g, params.noise));
    terms.push_back(std::make_unique<PoseTerm>(k + 1, chain.poses[at], params.sigma_rotation, params.sigma_position));
  }
  std::vector<Vec15> xi(chain.guess.size(), Vec15::Zero());
  ceres::Problem problem;
  for (const auto& term : terms) add(problem, *term, chain, xi);
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  options.max_num_iterations = 200;
  options.function_tolerance = options.gradient_tolerance = options.parameter_tolerance = 1e-14;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  REQUIRE(summary.IsSolutionUsable());
  Solution out;
  for (std::size_t i = 0; i < xi.size(); ++i) out.states.push_back(moved(chain.guess[i], xi[i]));
  ceres::Covariance::Options dense;
  dense.algorithm_type = ceres::DENSE_SVD;
  ceres::Covariance covariance(dense);
  const double* newest = xi.back().data();
  const std::vector<std::pair<const double*, const double*>> wanted{{newest, newest}};
  REQUIRE(covariance.Compute(wanted, &problem));
  Eigen::Matrix<double, kNodeDim, kNodeDim, Eigen::RowMajor> block;
  REQUIRE(covariance.GetCovarianceBlock(newest, newest, block.data()));
  // Of the deviation from the guess, to that from the solution.
  Mat15 turn = Mat15::Identity();
  turn.topLeftCorner<3, 3>() = right_jacobian_so3(xi.back().head<3>());
  out.covariance = turn * block * turn.transpose();
  return out;
}

}  // namespace

TEST_CASE("the smoother's newest state and its covariance are those of Ceres") {  // eq. LAG-4
  const Chain chain;
  LagWindow::Params params;
  params.sigma_rotation = 0.01;
  params.sigma_position = 0.02;
  params.max_iterations = 100;
  LagWindow window(params);
  window.start(chain.guess[0], chain.sigma);
  for (std::size_t k = 0; k < kWindows; ++k) {
    window.append(chain.motions[k], chain.guess[k + 1]);
    window.measure(chain.poses[k], false);
  }
  REQUIRE(window.solve());
  const Solution found = by_ceres(chain, params);
  const Vec15 sigma = found.covariance.diagonal().cwiseSqrt();
  // It has moved far from the guess, or the test would say little.
  REQUIRE(plugins::difference(found.states.back(), chain.guess.back()).cwiseQuotient(sigma).norm() > 1.0);
  const Vec15 off = plugins::difference(window.newest(), found.states.back());
  CHECK(off.cwiseQuotient(sigma).cwiseAbs().maxCoeff() < 1e-3);
  const Mat15 scaled =
      sigma.cwiseInverse().asDiagonal() * (window.covariance() - found.covariance) * sigma.cwiseInverse().asDiagonal();
  CHECK(scaled.cwiseAbs().maxCoeff() < 1e-3);
}
