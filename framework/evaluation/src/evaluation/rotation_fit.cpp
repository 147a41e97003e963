#include "aslio/evaluation/rotation_fit.hpp"

#include <fmt/format.h>

#include <Eigen/SVD>
#include <algorithm>
#include <array>
#include <cmath>

#include "aslio/evaluation/alignment.hpp"
#include "clustered_fit.hpp"

namespace aslio::evaluation {

namespace {

constexpr TimeNs kCluster = 2 * kSecond;
constexpr double kStep = 0.1, kTurn = 0.2;  // [s] of a turn, for the coarse delay and for the fit
constexpr double kCoarseStep = 0.01;        // [s]
constexpr double kSlope = 2e-3;             // [s] of a central difference over the delay
constexpr std::size_t kFewest = 30, kMostCoarse = 2000;
constexpr double kLeastNoise = 1e-5;  // [rad] of a turn
constexpr int kIterations = 8;
// What is known of a gyro beforehand: one of any make.
constexpr double kSigmaBias = 0.05, kSigmaScale = 0.01, kSigmaAxes = 0.006;
constexpr double kSigmaTurn = 0.5;   // [rad] of the rotation about an axis that nothing binds
constexpr double kSigmaDelay = 0.1;  // [s]

struct Turn {
  TimeNs begin, end, window;
  Vec3 a;
};

/// From every pose to the first one that is `span` later.
std::vector<Turn> turns_of(std::span<const MotionStretch> stretches, double span) {
  std::vector<Turn> out;
  for (const MotionStretch& s : stretches) {
    std::size_t j = 0;
    for (const StampedPose& from : s.poses) {
      while (j < s.poses.size() && s.poses[j].t < from.t + to_ns(0.99 * span)) ++j;
      if (j == s.poses.size()) break;
      out.push_back({from.t, s.poses[j].t, s.window, log_so3(from.T.R.transpose() * s.poses[j].T.R)});
    }
  }
  return out;
}

/// Correlation of the lengths of the turns with B later by `delay`.
double correlation_at(std::span<const Turn> turns, const TurnSource& b, TimeNs delay) {
  double n = 0, sa = 0, sb = 0, saa = 0, sbb = 0, sab = 0;
  for (const Turn& turn : turns) {
    const auto other = b.turn(turn.begin + delay, turn.end + delay);
    if (!other) continue;
    const double x = turn.a.norm(), y = other->norm();
    n += 1, sa += x, sb += y, saa += x * x, sbb += y * y, sab += x * y;
  }
  if (n < static_cast<double>(kFewest)) return 0;
  const double va = saa - sa * sa / n, vb = sbb - sb * sb / n;
  return va > 0 && vb > 0 ? (sab - sa * sb / n) / std::sqrt(va * vb) : 0;
}

/// eq. FRM-2.
struct Coarse {
  double delay = 0, correlation = 0;
};

Coarse coarse_delay(const std::vector<Turn>& turns, const TurnSource& b, double max_delay) {
  std::vector<Turn> some;
  const std::size_t stride = turns.size() / kMostCoarse + 1;
  for (std::size_t i = 0; i < turns.size(); i += stride) some.push_back(turns[i]);
  Coarse best;
  const int steps = static_cast<int>(std::lround(max_delay / kCoarseStep));
  for (int i = -steps; i <= steps; ++i) {
    const double delay = kCoarseStep * i, value = correlation_at(some, b, to_ns(delay));
    if (value > best.correlation) best = {delay, value};
  }
  return best;
}

struct Pair {
  const Turn* turn;
  Vec3 b;
};

std::vector<Pair> pairs_at(const std::vector<Turn>& turns, const TurnSource& b, double delay) {
  std::vector<Pair> out;
  for (const Turn& turn : turns) {
    const auto other = mean_turn(b, turn.begin + to_ns(delay), turn.end + to_ns(delay), turn.window);
    if (other) out.push_back({&turn, *other});
  }
  return out;
}

/// Of the lengths of the turns that both take for large ones, B over A.
double ratio_of(const std::vector<Pair>& pairs) {
  double largest = 0, ab = 0, bb = 0;
  const auto lesser = [](const Pair& p) { return std::min(p.turn->a.norm(), p.b.norm()); };
  for (const Pair& p : pairs) largest = std::max(largest, lesser(p));
  for (const Pair& p : pairs) {
    if (lesser(p) < 0.3 * largest) continue;
    ab += p.turn->a.norm() * p.b.norm();
    bb += p.b.squaredNorm();
  }
  return ab > 0 ? bb / ab : 1;
}

/// The sign pattern and rotation whose turns fit best; where several do, the ones nearest to what is expected.
class SignedRotation {
 public:
  /// `patterns`: 8 to try all signs, 1 for none reversed.
  SignedRotation(const std::vector<Pair>& pairs, const Mat3& expected, int patterns, double ratio) {
    for (const Pair& p : pairs) {
      const double x = p.turn->a.norm(), y = p.b.norm() / ratio;
      if (std::abs(x - y) > 0.01 + 0.2 * std::max(x, y)) continue;
      product_ += p.turn->a * p.b.transpose() / ratio;
      energy_ += x * x + y * y;
      taken_ += 1;
    }
    if (energy_ > 0) choose(expected, patterns);
  }
  double taken() const { return taken_; }
  const Mat3& rotation() const { return rotation_; }
  const Vec3& signs() const { return signs_; }

 private:
  void choose(const Mat3& expected, int patterns) {
    constexpr double kUnbound = 4e-6, kPerFlip = 0.002, kPerAngle = 0.05;
    double least = 1e9;
    for (int pattern = 0; pattern < patterns; ++pattern) {
      const Vec3 signs((pattern & 1) != 0 ? -1 : 1, (pattern & 2) != 0 ? -1 : 1, (pattern & 4) != 0 ? -1 : 1);
      const Mat3 product = product_ * signs.asDiagonal();
      const Mat3 R = nearest_rotation(product + kUnbound * taken_ * expected);
      const double misfit = 1.0 - 2.0 * (R.transpose() * product).trace() / energy_;
      const double angle = log_so3(R.transpose() * expected).norm();
      const double flips = 0.5 * (3.0 - signs.sum());
      const double cost = misfit + kPerFlip * flips + kPerAngle * 0.5 * (1.0 - std::cos(angle));
      if (cost < least) {
        least = cost;
        rotation_ = R;
        signs_ = signs;
      }
    }
  }

  Mat3 product_ = Mat3::Zero(), rotation_ = Mat3::Identity();
  Vec3 signs_ = Vec3::Ones();
  double energy_ = 0, taken_ = 0;
};

/// Whether the axes whose sign is said to be wrong turn, and the other measures these turns as well. Turns that do not
/// fit, as of a registration that failed, weigh little.
bool signs_are_certain(const Mat3& R, const Vec3& signs, const std::vector<Pair>& pairs, double ratio) {
  const auto residual = [&](const Pair& p) { return (p.turn->a - R * signs.cwiseProduct(p.b) / ratio).norm(); };
  std::vector<double> lengths;
  for (const Pair& p : pairs) lengths.push_back(residual(p));
  const double sigma = spread_of(lengths, kLeastNoise);
  Vec3 ab = Vec3::Zero(), aa = Vec3::Zero(), bb = Vec3::Zero();
  for (const Pair& p : pairs) {
    const Vec3 x = R.transpose() * p.turn->a, y = signs.cwiseProduct(p.b);
    const double weight = robust_weight(residual(p), sigma);
    ab += weight * x.cwiseProduct(y);
    aa += weight * x.cwiseAbs2();
    bb += weight * y.cwiseAbs2();
  }
  for (int axis = 0; axis < 3; ++axis) {
    if (signs[axis] < 0 && !(ab[axis] > 0.5 * std::sqrt(aa[axis] * bb[axis]))) return false;
  }
  return true;
}

/// eq. FRM-3: theta_A = R (I - S) D theta_B - bias dt), over (turn of R, delay, bias, S).
class Refiner {
 public:
  Refiner(const std::vector<Turn>& turns, const TurnSource& b, bool gyro, RotationFit& fit)
      : turns_(turns), b_(b), gyro_(gyro), fit_(fit) {}

  bool run() {
    for (int i = 0; i < kIterations; ++i) {
      load();
      if (rows_.size() < kFewest) return false;
      const ClusteredFit system = build();
      if (system.clusters() < 3) return false;
      if (i + 1 == kIterations) {
        conclude(system.covariance());
        break;
      }
      apply(system.step());
    }
    return true;
  }

 private:
  struct Row {
    const Turn* turn;
    Vec3 b, slope, r;
  };

  Vec3 signed_turn(const Vec3& b, double dt) const { return fit_.signs.cwiseProduct(b) - fit_.bias * dt; }

  void load() {
    rows_.clear();
    lengths_.clear();
    const TimeNs d = to_ns(fit_.delay), h = to_ns(kSlope);
    for (const Turn& turn : turns_) {
      const auto at = [&](TimeNs by) { return mean_turn(b_, turn.begin + by, turn.end + by, turn.window); };
      const auto now = at(d), before = at(d - h), after = at(d + h);
      if (!now || !before || !after) continue;
      const double dt = to_seconds(turn.end - turn.begin);
      Row row{&turn, signed_turn(*now, dt), fit_.signs.cwiseProduct(*after - *before) / (2 * kSlope), Vec3::Zero()};
      row.r = turn.a - fit_.R_A_B * (row.b - fit_.sensitivity * row.b);
      rows_.push_back(row);
      lengths_.push_back(row.r.norm());
    }
    sigma_ = spread_of(lengths_, kLeastNoise);
  }

  ClusteredFit build() const {
    ClusteredFit system(gyro_ ? 13 : 4);
    for (int i = 0; i < 3; ++i) system.hold(i, 0, kSigmaTurn);
    system.hold(3, 0, kSigmaDelay);
    if (gyro_) {
      for (int i = 0; i < 3; ++i) {
        system.hold(4 + i, fit_.bias[i], kSigmaBias);
        system.hold(7 + i, fit_.sensitivity(i, i), kSigmaScale);
        system.hold(10 + i, fit_.sensitivity(i, (i + 1) % 3), kSigmaAxes);
      }
    }
    for (const Row& row : rows_) {
      const auto cluster = static_cast<int>((row.turn->begin - turns_.front().begin) / kCluster);
      const double weight = robust_weight(row.r.norm(), sigma_) / (sigma_ * sigma_);
      system.add(cluster, jacobian(row), row.r, weight);
    }
    return system;
  }

  Eigen::MatrixXd jacobian(const Row& row) const {
    Eigen::MatrixXd J = Eigen::MatrixXd::Zero(3, gyro_ ? 13 : 4);
    const Mat3& R = fit_.R_A_B;
    J.middleCols<3>(0) = hat(R * row.b);  // R <- Exp(x) R
    J.col(3) = -(R * row.slope);
    if (!gyro_) return J;
    J.middleCols<3>(4) = R * to_seconds(row.turn->end - row.turn->begin);
    for (int i = 0; i < 3; ++i) {
      const int j = (i + 1) % 3;
      J.col(7 + i) = R.col(i) * row.b[i];
      J.col(10 + i) = R.col(i) * row.b[j] + R.col(j) * row.b[i];
    }
    return J;
  }

  void apply(const Eigen::VectorXd& x) {
    fit_.R_A_B = orthonormalised(exp_so3(x.head<3>()) * fit_.R_A_B);
    fit_.delay += std::clamp(x[3], -0.05, 0.05);
    if (!gyro_) return;
    fit_.bias += x.segment<3>(4);
    for (int i = 0; i < 3; ++i) {
      const int j = (i + 1) % 3;
      fit_.sensitivity(i, i) += x[7 + i];
      fit_.sensitivity(i, j) += x[10 + i];
      fit_.sensitivity(j, i) = fit_.sensitivity(i, j);
    }
  }

  void conclude(const Eigen::MatrixXd& covariance) {
    fit_.covariance = covariance.topLeftCorner<3, 3>();
    fit_.sigma_delay = std::sqrt(covariance(3, 3));
    fit_.turns = rows_.size();
    double n = 0, squares = 0, seconds = 0;
    Vec3 turned = Vec3::Zero();
    for (const Row& row : rows_) {
      const double w = robust_weight(row.r.norm(), sigma_);
      n += w;
      squares += w * row.r.squaredNorm();
      turned += row.b.cwiseAbs2();
      seconds += to_seconds(row.turn->end - row.turn->begin);
    }
    fit_.rms = std::sqrt(squares / n);
    const auto count = static_cast<double>(rows_.size());
    fit_.rate = (turned / count).cwiseSqrt() / (seconds / count);
  }

  const std::vector<Turn>& turns_;
  const TurnSource& b_;
  bool gyro_;
  RotationFit& fit_;
  std::vector<Row> rows_;
  std::vector<double> lengths_;
  double sigma_ = kLeastNoise;
};

}  // namespace

RotationFit fit_rotation(std::span<const MotionStretch> a, const TurnSource& b, const RotationFitOptions& options) {
  RotationFit fit;
  const std::vector<Turn> steps = turns_of(a, kStep), turns = turns_of(a, kTurn);
  const auto without = [&](std::string why) {
    fit.problem = std::move(why);
    return fit;
  };
  if (turns.size() < kFewest) return without(fmt::format("too short: {} turns, {} are needed", turns.size(), kFewest));
  const Coarse coarse = coarse_delay(steps, b, options.max_delay);
  fit.delay = coarse.delay;
  fit.correlation = coarse.correlation;
  const std::vector<Pair> pairs = pairs_at(turns, b, fit.delay);
  if (pairs.size() < kFewest) return without("they hardly have a time in common");
  double squares = 0, seconds = 0;
  for (const Pair& p : pairs) {
    squares += p.turn->a.squaredNorm();
    seconds += to_seconds(p.turn->end - p.turn->begin);
  }
  const auto count = static_cast<double>(pairs.size());
  const double rate = std::sqrt(squares / count) / (seconds / count);
  if (rate < options.min_rate) return without(fmt::format("it hardly turns: {:.3f} rad/s RMS", rate));
  if (fit.correlation < 0.4) {
    fit.unlike = true;
    return without(fmt::format("the two rates have nothing in common: correlation {:.2f} at best within {:g} s",
                               fit.correlation, options.max_delay));
  }
  fit.ratio = ratio_of(pairs);
  SignedRotation rough(pairs, options.expected, options.gyro ? 8 : 1, fit.ratio);
  if (rough.taken() < static_cast<double>(kFewest)) return without("the lengths of the turns do not agree");
  if (!signs_are_certain(rough.rotation(), rough.signs(), pairs, fit.ratio)) {
    rough = SignedRotation(pairs, options.expected, 1, fit.ratio);
  }
  fit.R_A_B = rough.rotation();
  fit.signs = rough.signs();
  if (std::abs(fit.ratio - 1) > 0.2) {
    fit.unlike = true;
    return without(fmt::format("the rates differ by a factor of {:.3g}: a wrong unit", fit.ratio));
  }
  if (!Refiner(turns, b, options.gyro, fit).run()) return without("too little of it fits");
  return fit;
}

}  // namespace aslio::evaluation
