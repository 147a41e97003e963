#include "aslio/simulator/pose_spline.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "aslio/core/errors.hpp"
#include "aslio/io/writers.hpp"

namespace aslio::simulator {
namespace {

constexpr int kOrder = 6;                ///< coefficients that act on one piece
constexpr std::size_t kFewestPoses = 6;  ///< what a single piece needs
constexpr double kFastest = 100;         ///< [m/s]
constexpr double kLargestTurn =
    std::numbers::pi / 2;         ///< between two poses [rad]; far from where the short way is in doubt
constexpr double kWidestGap = 2;  ///< between two poses, in knot intervals
/// Weight of the squared fourth differences of the coefficients: settles those that sparse poses leave open, and moves
/// the others by less than what rounding of a file does.
constexpr double kSmoothing = 1e-9;

using Sparse = Eigen::SparseMatrix<double>;
using Piece = Eigen::Matrix<double, kOrder, 7>;  ///< row k: factor of u^k; columns: position, quaternion (x y z w)
using Row7 = Eigen::Matrix<double, 1, 7>;

/// Column j: the polynomial, by powers of u in [0, 1], by which the j-th of six coefficients acts on a piece.
Eigen::Matrix<double, kOrder, kOrder> basis() {
  Eigen::Matrix<double, kOrder, kOrder> m;
  m << 1, 26, 66, 26, 1, 0,    //
      -5, -50, 0, 50, 5, 0,    //
      10, 20, -60, 20, 10, 0,  //
      -10, 20, 0, -20, 10, 0,  //
      5, -20, 30, -20, 5, 0,   //
      -1, 5, -10, 10, -5, 1;
  return m / 120;
}

class PoseSpline final : public Motion {
 public:
  PoseSpline(std::vector<Piece> pieces, double interval) : pieces_(std::move(pieces)), interval_(interval) {}

  double duration() const override { return interval_ * static_cast<double>(pieces_.size()); }

  /// Beyond the ends the first and the last polynomial go on.
  MotionState at(double t) const override {
    const double place = std::clamp(std::floor(t / interval_), 0.0, static_cast<double>(pieces_.size() - 1));
    const Piece& c = pieces_[static_cast<std::size_t>(place)];
    const double u = t / interval_ - place;
    Row7 x = c.row(kOrder - 1), d = Row7::Zero(), half_dd = Row7::Zero();
    for (int k = kOrder - 2; k >= 0; --k) {
      half_dd = half_dd * u + d;
      d = d * u + x;
      x = x * u + c.row(k);
    }
    const Eigen::Quaterniond q(x[6], x[3], x[4], x[5]);
    const Eigen::Quaterniond rate(d[6] / interval_, d[3] / interval_, d[4] / interval_, d[5] / interval_);
    MotionState state;
    state.R = q.normalized().toRotationMatrix();
    state.p = x.head<3>().transpose();
    state.v = d.head<3>().transpose() / interval_;
    state.a = 2 * half_dd.head<3>().transpose() / (interval_ * interval_);
    // The change of length is the real part of the product and drops out.
    state.w = 2 * (q.conjugate() * rate).vec() / q.squaredNorm();
    return state;
  }

 private:
  std::vector<Piece> pieces_;
  double interval_;
};

double since_first(std::span<const StampedPose> poses, std::size_t k) { return to_seconds(poses[k].t - poses[0].t); }

void check(std::span<const StampedPose> poses, double knot_interval) {
  if (!(knot_interval > 0))
    throw ConfigError(fmt::format("follow.knot_interval is {} s, must be above 0", knot_interval));
  if (poses.size() < kFewestPoses)
    throw DataError(
        fmt::format("the trajectory to follow has {} poses, needs at least {}", poses.size(), kFewestPoses));
  for (std::size_t k = 0; k < poses.size(); ++k)
    if (!poses[k].T.p.allFinite() || !poses[k].T.R.allFinite())
      throw DataError(fmt::format("the trajectory to follow has a pose that is not finite after {:.3f} s (pose {})",
                                  since_first(poses, k), k + 1));
  for (std::size_t k = 1; k < poses.size(); ++k) {
    const double gap = to_seconds(poses[k].t - poses[k - 1].t), at = since_first(poses, k - 1);
    if (gap <= 0)
      throw DataError(fmt::format("the trajectory to follow goes back in time after {:.3f} s (pose {})", at, k));
    if (gap > kWidestGap * knot_interval * (1 + 1e-9))
      throw DataError(
          fmt::format("the trajectory to follow has a gap of {:.3f} s after {:.3f} s (pose {}); follow.knot_interval "
                      "{:g} s bridges at most {:g} s: make it longer",
                      gap, at, k, knot_interval, kWidestGap * knot_interval));
    const double distance = (poses[k].T.p - poses[k - 1].T.p).norm();
    if (distance > kFastest * gap)
      throw DataError(fmt::format(
          "the trajectory to follow jumps by {:.3g} m in {:.3f} s after {:.3f} s (pose {}), faster than {:g} m/s",
          distance, gap, at, k, kFastest));
    const double turn = log_so3(poses[k - 1].T.R.transpose() * poses[k].T.R).norm();
    if (turn > kLargestTurn)
      throw DataError(
          fmt::format("the trajectory to follow turns by {:.0f} deg in {:.3f} s after {:.3f} s (pose {}), at most 90 "
                      "deg between two poses are possible: give more poses",
                      turn * 180 / std::numbers::pi, gap, at, k));
  }
}

/// What is fitted: a row for each pose, positions relative to the first, quaternions without changes of sign.
Eigen::MatrixXd values(std::span<const StampedPose> poses) {
  Eigen::MatrixXd rows(static_cast<Eigen::Index>(poses.size()), 7);
  Eigen::Vector4d before = Eigen::Quaterniond(poses[0].T.R).coeffs();
  for (std::size_t k = 0; k < poses.size(); ++k) {
    Eigen::Vector4d q = Eigen::Quaterniond(poses[k].T.R).coeffs();
    if (q.dot(before) < 0) q = -q;
    rows.row(static_cast<Eigen::Index>(k)) << (poses[k].T.p - poses[0].T.p).transpose(), q.transpose();
    before = q;
  }
  return rows;
}

/// Row k: how the coefficients act at the time of pose k.
Sparse design(std::span<const StampedPose> poses, double interval, Eigen::Index pieces) {
  const auto m = basis();
  std::vector<Eigen::Triplet<double>> entries;
  for (std::size_t k = 0; k < poses.size(); ++k) {
    const double place = since_first(poses, k) / interval;
    const auto piece = std::min(static_cast<Eigen::Index>(place), pieces - 1);
    const double u = place - static_cast<double>(piece);
    Eigen::Matrix<double, 1, kOrder> powers;
    powers << 1, u, u * u, u * u * u, u * u * u * u, u * u * u * u * u;
    const Eigen::Matrix<double, 1, kOrder> weights = powers * m;
    for (int j = 0; j < kOrder; ++j) entries.emplace_back(static_cast<int>(k), static_cast<int>(piece) + j, weights[j]);
  }
  Sparse rows(static_cast<Eigen::Index>(poses.size()), pieces + kOrder - 1);
  rows.setFromTriplets(entries.begin(), entries.end());
  return rows;
}

Sparse fourth_differences(Eigen::Index coefficients) {
  constexpr int kDifference[] = {1, -4, 6, -4, 1};
  std::vector<Eigen::Triplet<double>> entries;
  for (int k = 0; k + 4 < static_cast<int>(coefficients); ++k)
    for (int j = 0; j < 5; ++j) entries.emplace_back(k, k + j, kDifference[j]);
  Sparse rows(coefficients - 4, coefficients);
  rows.setFromTriplets(entries.begin(), entries.end());
  return rows;
}

}  // namespace

std::unique_ptr<Motion> follow_poses(std::span<const StampedPose> poses, double knot_interval, double* fit_error) {
  check(poses, knot_interval);
  const double duration = since_first(poses, poses.size() - 1);
  const auto count = static_cast<Eigen::Index>(std::max(1.0, std::ceil(duration / knot_interval - 1e-9)));
  const double interval = duration / static_cast<double>(count);
  const Sparse rows = design(poses, interval, count), differences = fourth_differences(count + kOrder - 1);
  const Sparse normal = Sparse(rows.transpose() * rows) + kSmoothing * Sparse(differences.transpose() * differences);
  const Eigen::SimplicialLDLT<Sparse> solver(normal);
  const Eigen::MatrixXd coefficients = solver.solve(rows.transpose() * values(poses));
  if (solver.info() != Eigen::Success || !coefficients.allFinite())
    throw DataError("the trajectory to follow cannot be fitted by a spline: its numbers are too large");
  std::vector<Piece> pieces;
  for (Eigen::Index k = 0; k < count; ++k) {
    pieces.emplace_back(basis() * coefficients.middleRows<kOrder>(k));
    pieces.back().row(0).head<3>() += poses[0].T.p.transpose();
  }
  auto motion = std::make_unique<PoseSpline>(std::move(pieces), interval);
  if (fit_error != nullptr) {
    *fit_error = 0;
    for (std::size_t k = 0; k < poses.size(); ++k)
      *fit_error = std::max(*fit_error, (motion->at(since_first(poses, k)).p - poses[k].T.p).norm());
  }
  return motion;
}

std::unique_ptr<Motion> follow_file(const std::filesystem::path& path, double knot_interval, double* fit_error) {
  const std::vector<StampedPose> poses = io::read_tum(path);
  try {
    return follow_poses(poses, knot_interval, fit_error);
  } catch (const DataError& error) {
    throw DataError(fmt::format("{}: {}", path.string(), error.what()));
  }
}

}  // namespace aslio::simulator
