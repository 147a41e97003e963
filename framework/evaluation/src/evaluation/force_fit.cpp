#include "aslio/evaluation/force_fit.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "aslio/evaluation/alignment.hpp"
#include "clustered_fit.hpp"

namespace aslio::evaluation {

namespace {

constexpr int kCommon = 9, kOwn = 9;  // scales, bias, lever arm; start, velocity, gravity of a piece
constexpr int kPiecesPerCluster = 2;
constexpr std::size_t kFewest = 8;                     // pieces, and poses of one
constexpr double kSigmaBias = 0.5, kSigmaLever = 5.0;  // [m/s^2], [m]
constexpr double kSigmaScale = 3.0, kSigmaKnownScale = 0.01;
constexpr double kLeastNoise = 1e-5;  // [m]
constexpr int kIterations = 6;

/// State of the integration at one IMU sample, all since the begin of the piece: columns are scales, bias.
struct Integral {
  double t = 0;
  Mat3 R = Mat3::Identity();  ///< attitude
  Eigen::Matrix<double, 3, 6> velocity = Eigen::Matrix<double, 3, 6>::Zero();
  Eigen::Matrix<double, 3, 6> position = Eigen::Matrix<double, 3, 6>::Zero();
};

using Columns = Eigen::Matrix<double, 3, 6>;

Columns columns(const Mat3& R, const Vec3& force) {
  Columns out;
  out << R * force.asDiagonal(), -R;
  return out;
}

/// A piece with its own unknowns taken out: what is left is linear in the common ones.
struct Piece {
  Eigen::MatrixXd J, own;  ///< rows of the common and of the own unknowns
  Eigen::VectorXd z;       ///< z = own y + J x
};

class PieceMaker {
 public:
  PieceMaker(std::span<const ImuSample> imu, const ForceFitOptions& options)
      : imu_(imu), options_(options), correction_(Mat3::Identity() - options.gyro_sensitivity) {}

  /// Of poses [begin, end) of the stretch; false where the IMU data do not cover them.
  bool make(const MotionStretch& stretch, std::size_t begin, std::size_t end, Piece& out) {
    const std::vector<TimeNs> offsets = window_offsets(stretch.window);
    const TimeNs delay = to_ns(options_.delay);
    const TimeNs from = stretch.poses[begin].t + offsets.front() + delay;
    const TimeNs to = stretch.poses[end - 1].t + offsets.back() + delay;
    if (!integrate(from, to)) return false;
    const auto rows = static_cast<Eigen::Index>(3 * (end - begin));
    out.J = Eigen::MatrixXd::Zero(rows, kCommon);
    out.own = Eigen::MatrixXd::Zero(rows, kOwn);
    out.z = Eigen::VectorXd::Zero(rows);
    const Mat3 R_W_0 = start_attitude(stretch, begin, end, from);
    const double share = 1.0 / static_cast<double>(offsets.size());
    for (std::size_t k = begin; k < end; ++k) {
      const auto row = static_cast<Eigen::Index>(3 * (k - begin));
      out.z.segment<3>(row) = stretch.poses[k].T.p;
      for (const TimeNs offset : offsets) {
        const double t = to_seconds(stretch.poses[k].t + offset + delay - from);
        const Integral at = at_time(t);
        auto own = out.own.middleRows<3>(row);
        own.leftCols<3>() += share * Mat3::Identity();
        own.middleCols<3>(3) += share * t * Mat3::Identity();
        own.rightCols<3>() += share * 0.5 * t * t * Mat3::Identity();
        auto common = out.J.middleRows<3>(row);
        common.leftCols<6>() += share * R_W_0 * at.position;
        common.rightCols<3>() += share * R_W_0 * at.R;
      }
    }
    return true;
  }

 private:
  Vec3 rate(const ImuSample& s) const {
    return correction_ * (options_.gyro_signs.cwiseProduct(s.gyro) - options_.gyro_bias);
  }

  bool integrate(TimeNs from, TimeNs to) {
    constexpr TimeNs kMaxGap = kSecond / 4;
    path_.clear();
    auto at = std::upper_bound(imu_.begin(), imu_.end(), from, [](TimeNs t, const ImuSample& s) { return t < s.t; });
    if (at == imu_.begin() || at == imu_.end()) return false;
    ImuSample last = *(at - 1);
    const double begin = to_seconds(last.t - from);  // negative: integration starts at the sample before
    path_.push_back({begin, Mat3::Identity(), Columns::Zero(), Columns::Zero()});
    for (; at != imu_.end(); ++at) {
      if (at->t <= last.t) continue;
      if (at->t - last.t > kMaxGap) return false;
      add(last, *at);
      last = *at;
      if (last.t >= to) return true;
    }
    return false;
  }

  void add(const ImuSample& a, const ImuSample& b) {
    const Integral& before = path_.back();
    const double dt = to_seconds(b.t - a.t);
    Integral now;
    now.t = before.t + dt;
    now.R = orthonormalised(before.R * exp_so3(dt * 0.5 * (rate(a) + rate(b))));
    const Columns fa = columns(before.R, a.acc), fb = columns(now.R, b.acc);
    now.velocity = before.velocity + 0.5 * dt * (fa + fb);
    now.position = before.position + dt * before.velocity + dt * dt / 6.0 * (2.0 * fa + fb);
    path_.push_back(now);
  }

  Integral at_time(double t) const {
    auto next = std::upper_bound(path_.begin(), path_.end(), t, [](double x, const Integral& i) { return x < i.t; });
    if (next == path_.end()) --next;
    if (next == path_.begin()) ++next;
    const Integral &a = *(next - 1), &b = *next;
    const double h = t - a.t, u = h / (b.t - a.t);
    Integral out;
    out.t = t;
    out.R = a.R * exp_so3(u * log_so3(a.R.transpose() * b.R));
    out.position = a.position + h * a.velocity + 0.5 * h * u * (b.velocity - a.velocity);
    return out;
  }

  /// R_W_I at the begin of the integration, by all poses: the gyro's own turn is better than theirs.
  Mat3 start_attitude(const MotionStretch& stretch, std::size_t begin, std::size_t end, TimeNs from) const {
    Mat3 sum = Mat3::Zero();
    for (std::size_t k = begin; k < end; ++k) {
      const double t = to_seconds(stretch.poses[k].t + to_ns(options_.delay) - from);
      sum += stretch.poses[k].T.R * options_.R_I_A.transpose() * at_time(t).R.transpose();
    }
    return nearest_rotation(sum);
  }

  std::span<const ImuSample> imu_;
  const ForceFitOptions& options_;
  Mat3 correction_;
  std::vector<Integral> path_;
};

std::vector<Piece> pieces_of(std::span<const MotionStretch> stretches, std::span<const ImuSample> imu,
                             const ForceFitOptions& options) {
  std::vector<Piece> out;
  PieceMaker maker(imu, options);
  for (const MotionStretch& s : stretches) {
    std::size_t begin = 0;
    for (std::size_t i = 0; i < s.poses.size(); ++i) {
      if (s.poses[i].t - s.poses[begin].t < to_ns(options.piece)) continue;
      Piece piece;
      if (i - begin >= kFewest && maker.make(s, begin, i + 1, piece)) out.push_back(std::move(piece));
      begin = i;
    }
  }
  return out;
}

/// eq. FRM-5.
class Solver {
 public:
  Solver(const std::vector<Piece>& pieces, const ForceFitOptions& options) : pieces_(pieces), options_(options) {
    for (const Piece& p : pieces_) {
      const Eigen::HouseholderQR<Eigen::MatrixXd> qr(p.own);
      const Eigen::MatrixXd Q = qr.householderQ();
      const Eigen::MatrixXd rest = Q.rightCols(Q.cols() - kOwn).transpose();
      reduced_.push_back({rest * p.J, {}, rest * p.z});
    }
  }

  /// The common unknowns with the scales held near `scale` within `sigma_scale`.
  void run(const Vec3& scale, double sigma_scale) {
    x_ = Eigen::VectorXd::Zero(kCommon);
    x_.head<3>() = scale;
    x_.tail<3>() = options_.expected;
    for (int i = 0; i < kIterations; ++i) {
      measure();
      ClusteredFit system(kCommon);
      for (int k = 0; k < 3; ++k) {
        system.hold(k, x_[k] - scale[k], sigma_scale);
        system.hold(3 + k, x_[3 + k], kSigmaBias);
        system.hold(6 + k, x_[6 + k] - options_.expected[k], kSigmaLever);
      }
      for (std::size_t p = 0; p < reduced_.size(); ++p) {
        const double weight = robust_weight(lengths_[p], sigma_) / (sigma_ * sigma_);
        system.add(static_cast<int>(p) / kPiecesPerCluster, reduced_[p].J, reduced_[p].J * x_ - reduced_[p].z, weight);
      }
      if (i + 1 == kIterations) {
        covariance_ = system.covariance();
      } else {
        x_ += system.step();
      }
    }
  }

  const Eigen::VectorXd& x() const { return x_; }
  const Eigen::MatrixXd& covariance() const { return covariance_; }
  double sigma() const { return sigma_; }

  /// Of every piece that fits.
  std::vector<Vec3> gravities() const {
    std::vector<Vec3> out;
    for (std::size_t p = 0; p < pieces_.size(); ++p) {
      if (robust_weight(lengths_[p], sigma_) < 0.25) continue;
      const Eigen::VectorXd own = pieces_[p].own.householderQr().solve(pieces_[p].z - pieces_[p].J * x_);
      out.emplace_back(own.tail<3>());
    }
    return out;
  }

 private:
  /// Residuals, per piece as the length of a vector of three would be.
  void measure() {
    lengths_.clear();
    for (const Piece& p : reduced_) {
      const Eigen::VectorXd r = p.J * x_ - p.z;
      lengths_.push_back(std::sqrt(3.0 * r.squaredNorm() / static_cast<double>(r.size())));
    }
    sigma_ = spread_of(lengths_, kLeastNoise);
  }

  const std::vector<Piece>& pieces_;
  const ForceFitOptions& options_;
  std::vector<Piece> reduced_;
  std::vector<double> lengths_;
  double sigma_ = kLeastNoise;
  Eigen::VectorXd x_;
  Eigen::MatrixXd covariance_;
};

/// `common`: deviation of the bias, which all pieces share [m/s^2].
void weigh_gravity(const std::vector<Vec3>& gravities, double common, ForceFit& fit) {
  std::vector<double> lengths;
  for (const Vec3& g : gravities) {
    lengths.push_back(g.norm());
    fit.up -= g;
  }
  if (lengths.empty()) return;
  if (fit.up.norm() > 0) fit.up.normalize();
  std::sort(lengths.begin(), lengths.end());
  const std::size_t n = lengths.size();
  fit.gravity = lengths[n / 2];
  // Half the distance of the quartiles is 0.674 sigma, and the median of n has 1.25 sigma / sqrt(n).
  const double sigma = (lengths[(3 * n) / 4] - lengths[n / 4]) / 1.349;
  fit.sigma_gravity =
      std::hypot(1.2533 * sigma / std::sqrt(static_cast<double>(n)), common, kSigmaKnownScale * kStandardGravity);
}

}  // namespace

ForceFit fit_force(std::span<const MotionStretch> a, std::span<const ImuSample> imu, const ForceFitOptions& options) {
  ForceFit fit;
  const std::vector<Piece> pieces = pieces_of(a, imu, options);
  fit.pieces = pieces.size();
  if (pieces.size() < kFewest) {
    fit.problem = fmt::format("too short: {} pieces of {:g} s, {} are needed", pieces.size(), options.piece, kFewest);
    return fit;
  }
  Solver solver(pieces, options);
  solver.run(Vec3::Ones(), kSigmaScale);
  fit.scale = solver.x().head<3>();
  fit.sigma_scale = solver.covariance().diagonal().head<3>().cwiseSqrt();
  for (int i = 0; i < 3; ++i) {
    const bool reversed = fit.scale[i] < -0.3 && fit.scale[i] + 5.0 * fit.sigma_scale[i] < 0.3;
    fit.signs[i] = reversed ? -1.0 : 1.0;
  }
  solver.run(fit.signs, kSigmaKnownScale);
  fit.lever = solver.x().tail<3>();
  fit.covariance = solver.covariance().bottomRightCorner<3, 3>();
  fit.rms = solver.sigma();
  weigh_gravity(solver.gravities(), std::sqrt(solver.covariance().diagonal().segment<3>(3).maxCoeff()), fit);
  return fit;
}

}  // namespace aslio::evaluation
