#include "estimators/lag_window.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <utility>

namespace aslio::plugins {

void LagWindow::clear() {
  nodes_.clear();
  terms_.clear();
}

/// eq. LAG-5
void LagWindow::start(const NavState& state, const Vec15& sigma) {
  clear();
  nodes_.push_back(state);
  Mat15 to_world = Mat15::Identity();
  to_world.topLeftCorner<3, 3>() = state.R;
  const Mat15 U = sigma.cwiseInverse().asDiagonal() * to_world;
  terms_.push_back(std::make_unique<PriorTerm>(0, state, U, Vec15::Zero()));
  covariance_ = to_world.transpose() * sigma.cwiseAbs2().asDiagonal() * to_world;
}

void LagWindow::append(const Preintegration& motion, const NavState& guess) {
  const int last = static_cast<int>(nodes_.size()) - 1;
  terms_.push_back(std::make_unique<InertialTerm>(last, motion, nodes_.back().g, params_.noise));
  nodes_.push_back(guess);
  nodes_.back().g = nodes_.front().g;
}

void LagWindow::measure(const Pose& pose, bool degenerate) {
  const double rotation = degenerate ? params_.sigma_degenerate : params_.sigma_rotation;
  const double position = degenerate ? params_.sigma_degenerate : params_.sigma_position;
  terms_.push_back(std::make_unique<PoseTerm>(static_cast<int>(nodes_.size()) - 1, pose, rotation, position));
}

void LagWindow::add(const StateTerm& term, const std::vector<NavState>& nodes, NormalEquations& normal) const {
  const auto i = static_cast<std::size_t>(term.node());
  const StateTerm::At at = term.at(nodes[i], term.two() ? &nodes[i + 1] : nullptr);
  normal.own[i] += at.J_i.transpose() * at.J_i;
  normal.slope[i] += at.J_i.transpose() * at.r;
  normal.cost += at.r.squaredNorm();
  if (!term.two()) return;
  normal.own[i + 1] += at.J_j.transpose() * at.J_j;
  normal.below[i] += at.J_j.transpose() * at.J_i;
  normal.slope[i + 1] += at.J_j.transpose() * at.r;
}

LagWindow::NormalEquations LagWindow::linearise(const std::vector<NavState>& nodes) const {
  NormalEquations normal;
  normal.own.assign(nodes.size(), Mat15::Zero());
  normal.below.assign(nodes.size(), Mat15::Zero());
  normal.slope.assign(nodes.size(), Vec15::Zero());
  for (const auto& term : terms_) add(*term, nodes, normal);
  return normal;
}

/// Solves for moves_, the oldest state first (a block Cholesky decomposition of the chain); covariance_ is that of the
/// newest state when there is no damping. eq. LAG-4
bool LagWindow::step(const NormalEquations& normal, double damping) {
  const std::size_t n = nodes_.size();
  std::vector<Eigen::LLT<Mat15>> decomposed(n);
  std::vector<Vec15> slope = normal.slope;
  Mat15 own = normal.own[0];
  for (std::size_t i = 0; i < n; ++i) {
    own.diagonal() *= 1.0 + damping;
    decomposed[i].compute(own);
    if (decomposed[i].info() != Eigen::Success) return false;
    if (i + 1 == n) break;
    const Mat15& below = normal.below[i];
    own = normal.own[i + 1] - below * decomposed[i].solve(below.transpose());
    slope[i + 1] -= below * decomposed[i].solve(slope[i]);
  }
  moves_.assign(n, Vec15::Zero());
  for (std::size_t i = n; i-- > 0;) {
    Vec15 right = slope[i];
    if (i + 1 < n) right += normal.below[i].transpose() * moves_[i + 1];
    moves_[i] = -decomposed[i].solve(right);
    if (!moves_[i].allFinite()) return false;
  }
  if (damping == 0) covariance_ = decomposed.back().solve(Mat15::Identity());
  return true;
}

/// Levenberg-Marquardt.
bool LagWindow::solve() {
  constexpr double small = 1e-8;  // relative decrease of the cost
  NormalEquations normal = linearise(nodes_);
  double damping = 0;
  for (int j = 0; j < params_.max_iterations; ++j) {
    if (!step(normal, damping)) return false;
    std::vector<NavState> there = nodes_;
    for (std::size_t i = 0; i < there.size(); ++i) there[i] = moved(there[i], moves_[i]);
    NormalEquations next = linearise(there);
    if (!std::isfinite(next.cost)) return false;
    if (next.cost > normal.cost * (1.0 + small)) {
      damping = damping == 0 ? 1e-4 : 10 * damping;
      continue;
    }
    const bool settled = normal.cost - next.cost <= small * normal.cost + 1e-12;
    nodes_ = std::move(there);
    normal = std::move(next);
    damping = damping < 1e-6 ? 0 : 0.1 * damping;
    if (settled) break;
  }
  if (!step(normal, 0)) return false;
  while (static_cast<std::int64_t>(nodes_.size()) > params_.lag) {
    if (!drop_oldest()) return false;
  }
  return true;
}

/// eq. LAG-3
bool LagWindow::drop_oldest() {
  NormalEquations normal;
  normal.own.assign(2, Mat15::Zero());
  normal.below.assign(2, Mat15::Zero());
  normal.slope.assign(2, Vec15::Zero());
  for (const auto& term : terms_) {
    if (term->node() == 0) add(*term, nodes_, normal);
  }
  const Eigen::LLT<Mat15> oldest(normal.own[0]);
  const Mat15& below = normal.below[0];
  const Mat15 left = normal.own[1] - below * oldest.solve(below.transpose());
  const Vec15 slope = normal.slope[1] - below * oldest.solve(normal.slope[0]);
  const Eigen::LLT<Mat15> llt(0.5 * (left + left.transpose()));
  if (oldest.info() != Eigen::Success || llt.info() != Eigen::Success) return false;
  // |U x + e|^2 = x^T H x + 2 g^T x + const with H = U^T U and U^T e = g.
  const Mat15 U = llt.matrixU();
  const Vec15 offset = llt.matrixL().solve(slope);

  terms_.erase(std::remove_if(terms_.begin(), terms_.end(), [](const auto& term) { return term->node() == 0; }),
               terms_.end());
  for (const auto& term : terms_) term->shift();
  nodes_.erase(nodes_.begin());
  terms_.insert(terms_.begin(), std::make_unique<PriorTerm>(0, nodes_.front(), U, offset));
  return true;
}

}  // namespace aslio::plugins
