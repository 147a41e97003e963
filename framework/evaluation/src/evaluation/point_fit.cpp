#include "aslio/evaluation/point_fit.hpp"

#include <fmt/format.h>

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "aslio/core/errors.hpp"
#include "aslio/evaluation/alignment.hpp"
#include "clustered_fit.hpp"

namespace aslio::evaluation {

namespace {

constexpr std::size_t kFewest = 4, kFewestPoses = 20;
constexpr int kIterations = 12, kCommon = 4, kOwn = 6;
constexpr double kSlope = 5e-3;  // [s] of a central difference over the delay
constexpr double kSigmaPoint = 10.0, kSigmaDelay = 0.1;
constexpr double kLeastNoise = 1e-5;  // [m]

struct Piece {
  std::span<const StampedPose> poses;
  Pose world;  ///< of A's world in that of the positions
};

std::vector<Piece> pieces_of(std::span<const MotionStretch> stretches, TimeNs length) {
  std::vector<Piece> out;
  for (const MotionStretch& s : stretches) {
    std::size_t begin = 0;
    for (std::size_t i = 0; i < s.poses.size(); ++i) {
      const bool last = i + 1 == s.poses.size();
      if (!last && s.poses[i].t - s.poses[begin].t < length) continue;
      if (i - begin >= kFewestPoses) out.push_back({std::span(s.poses).subspan(begin, i - begin), Pose{}});
      begin = i;
    }
  }
  return out;
}

class Solver {
 public:
  Solver(std::vector<Piece> pieces, const Trajectory& positions, const PointFitOptions& options, PointFit& fit)
      : pieces_(std::move(pieces)),
        positions_(positions),
        max_gap_(to_ns(options.max_gap)),
        options_(options),
        fit_(fit) {}

  bool run() {
    std::erase_if(pieces_, [this](Piece& p) { return !lay(p); });
    if (pieces_.size() < kFewest) return false;
    for (int i = 0; i < kIterations; ++i) {
      const ClusteredFit system = build();
      if (i + 1 == kIterations) {
        conclude(system.covariance());
      } else {
        apply(system.step());
      }
    }
    return true;
  }

 private:
  struct Linear {
    Eigen::MatrixXd J, own;
    Eigen::VectorXd r;
  };

  /// A first alignment; false where the positions do not determine one.
  bool lay(Piece& piece) const {
    std::vector<PosePair> pairs;
    for (const StampedPose& pose : piece.poses) {
      const auto at = positions_.pose(pose.t + to_ns(fit_.delay), max_gap_);
      if (at) pairs.push_back({pose.t, Pose{pose.T.R, pose.T * fit_.point}, *at});
    }
    if (pairs.size() < kFewestPoses) return false;
    try {
      piece.world = align(Alignment::se3, pairs, std::vector<double>(pairs.size(), 1.0));
    } catch (const DataError&) {  // positions on a line
      return false;
    }
    return true;
  }

  Linear linear(const Piece& piece) const {
    Linear out;
    std::vector<Eigen::Matrix<double, 3, kCommon>> J;
    std::vector<Eigen::Matrix<double, 3, kOwn>> own;
    std::vector<Vec3> r;
    const TimeNs h = to_ns(kSlope);
    for (const StampedPose& pose : piece.poses) {
      const TimeNs t = pose.t + to_ns(fit_.delay);
      const auto now = positions_.pose(t, max_gap_), before = positions_.pose(t - h, max_gap_);
      const auto after = positions_.pose(t + h, max_gap_);
      if (!now || !before || !after) continue;
      const Vec3 turned = piece.world.R * (pose.T * fit_.point);
      r.push_back(turned + piece.world.p - now->p);
      J.emplace_back();
      J.back() << piece.world.R * pose.T.R, -(after->p - before->p) / (2 * kSlope);
      own.emplace_back();
      own.back() << -hat(turned), Mat3::Identity();
    }
    const auto rows = static_cast<Eigen::Index>(3 * r.size());
    out.J.resize(rows, kCommon);
    out.own.resize(rows, kOwn);
    out.r.resize(rows);
    for (std::size_t k = 0; k < r.size(); ++k) {
      const auto row = static_cast<Eigen::Index>(3 * k);
      out.J.middleRows<3>(row) = J[k];
      out.own.middleRows<3>(row) = own[k];
      out.r.segment<3>(row) = r[k];
    }
    return out;
  }

  ClusteredFit build() {
    linear_.clear();
    std::vector<double> lengths;
    for (const Piece& piece : pieces_) {
      linear_.push_back(linear(piece));
      const auto n = static_cast<double>(std::max<Eigen::Index>(linear_.back().r.size(), 1));
      lengths.push_back(std::sqrt(3.0 * linear_.back().r.squaredNorm() / n));
    }
    sigma_ = spread_of(lengths, kLeastNoise);
    ClusteredFit system(kCommon);
    for (int i = 0; i < 3; ++i) system.hold(i, fit_.point[i] - options_.expected[i], kSigmaPoint);
    system.hold(3, 0, kSigmaDelay);
    for (std::size_t p = 0; p < linear_.size(); ++p) {
      const Linear& l = linear_[p];
      if (l.r.size() <= kOwn) continue;
      const Eigen::MatrixXd Q = Eigen::HouseholderQR<Eigen::MatrixXd>(l.own).householderQ();
      const Eigen::MatrixXd rest = Q.rightCols(Q.cols() - kOwn).transpose();
      const double weight = robust_weight(lengths[p], sigma_) / (sigma_ * sigma_);
      system.add(static_cast<int>(p), rest * l.J, rest * l.r, weight);
    }
    return system;
  }

  void apply(const Eigen::VectorXd& x) {
    for (std::size_t p = 0; p < pieces_.size(); ++p) {
      const Linear& l = linear_[p];
      if (l.r.size() <= kOwn) continue;
      const Vec6 y = -l.own.colPivHouseholderQr().solve(l.r + l.J * x);
      pieces_[p].world.R = orthonormalised(exp_so3(y.head<3>()) * pieces_[p].world.R);
      pieces_[p].world.p += y.tail<3>();
    }
    fit_.point += x.head<3>();
    fit_.delay += std::clamp(x[3], -0.05, 0.05);
  }

  void conclude(const Eigen::MatrixXd& covariance) {
    fit_.pieces = pieces_.size();
    fit_.covariance = covariance.topLeftCorner<3, 3>();
    fit_.sigma_delay = std::sqrt(covariance(3, 3));
    fit_.rms = sigma_;
  }

  std::vector<Piece> pieces_;
  const Trajectory& positions_;
  TimeNs max_gap_;
  const PointFitOptions& options_;
  PointFit& fit_;
  std::vector<Linear> linear_;
  double sigma_ = kLeastNoise;
};

}  // namespace

PointFit fit_point(std::span<const MotionStretch> a, const Trajectory& positions, const PointFitOptions& options) {
  PointFit fit;
  fit.point = options.expected;
  fit.delay = options.delay;
  if (!Solver(pieces_of(a, to_ns(options.piece)), positions, options, fit).run()) {
    fit.problem =
        fmt::format("too short: {} pieces of {:g} s with positions off a line are needed", kFewest, options.piece);
  }
  return fit;
}

}  // namespace aslio::evaluation
