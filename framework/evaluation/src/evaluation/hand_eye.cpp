#include "aslio/evaluation/hand_eye.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "clustered_fit.hpp"

namespace aslio::evaluation {

namespace {

constexpr TimeNs kCluster = 6 * kSecond;  // twice as long as the longest motion: those that overlap are alike
// Variances are twice what the scatter of the clusters says: over 16 series made with known noise the squares of the
// errors of position were 1.9 times what was claimed.
constexpr double kClaimedTooWell = 2.0;
constexpr std::size_t kFewest = 20;
constexpr int kIterations = 10;
constexpr double kSlope = 5e-3;                          // [s] of a central difference over the delay
constexpr double kLeastTurn = 1e-5, kLeastShift = 1e-5;  // [rad], [m]
constexpr double kSigmaTurn = 0.5, kSigmaShift = 10.0, kSigmaDelay = 0.1;
constexpr double kStep = 0.2;  // [s] between the starts of two motions

struct Motion {
  TimeNs begin, end, window;
  Vec3 turn, shift;  ///< of A, in its axes at the begin
  std::size_t kind;  ///< 0: of the shorter span
};

/// Long motions turn more, and short ones drift less.
void add_motions(std::span<const MotionStretch> stretches, TimeNs span, std::size_t kind, std::vector<Motion>& out) {
  for (const MotionStretch& s : stretches) {
    TimeNs next = kTimeMin;
    std::size_t j = 0;
    for (const StampedPose& from : s.poses) {
      while (j < s.poses.size() && s.poses[j].t < from.t + span) ++j;
      if (j == s.poses.size()) break;
      if (from.t < next) continue;
      next = from.t + to_ns(kStep);
      const Pose T = from.T.inverse() * s.poses[j].T;
      out.push_back({from.t, s.poses[j].t, s.window, log_so3(T.R), T.p, kind});
    }
  }
}

/// The pose of B as a window around `t` shows it: its rotation there, and the mean of its positions.
std::optional<Pose> mean_pose(const Trajectory& b, TimeNs t, TimeNs window, TimeNs max_gap) {
  auto out = b.pose(t, max_gap);
  if (!out) return std::nullopt;
  Vec3 sum = Vec3::Zero();
  const std::vector<TimeNs> offsets = window_offsets(window);
  for (const TimeNs offset : offsets) {
    const auto at = b.pose(t + offset, max_gap);
    if (!at) return std::nullopt;
    sum += at->p;
  }
  out->p = sum / static_cast<double>(offsets.size());
  return out;
}

class Solver {
 public:
  Solver(const std::vector<Motion>& motions, const Trajectory& b, const HandEyeOptions& options, HandEye& fit)
      : motions_(motions),
        b_(b),
        max_gap_(to_ns(options.max_gap)),
        expected_(options.expected),
        start_(options.start),
        fit_(fit) {}

  bool run() {
    fit_.T_B_A = expected_;
    load();
    fit_.rms_expected = rows_.empty() ? 0 : rms();
    fit_.T_B_A.R = start_;
    for (int i = 0; i < kIterations; ++i) {
      load();
      if (rows_.size() < kFewest) return false;
      const ClusteredFit system = build();
      if (system.clusters() < 3) return false;
      if (i + 1 == kIterations) {
        conclude(kClaimedTooWell * system.covariance());
        break;
      }
      apply(system.step());
    }
    return true;
  }

 private:
  struct Relative {
    Mat3 R;
    Vec3 turn, p;
  };
  struct Row {
    const Motion* motion;
    Relative b;
    Vec3 turn_slope, shift_slope;  ///< of B over the delay
    Vec3 turn, shift;              ///< residuals
  };

  std::optional<Relative> relative(const Motion& m, TimeNs delay) const {
    const auto from = mean_pose(b_, m.begin + delay, m.window, max_gap_);
    const auto to = mean_pose(b_, m.end + delay, m.window, max_gap_);
    if (!from || !to) return std::nullopt;
    const Pose T = from->inverse() * *to;
    return Relative{T.R, log_so3(T.R), T.p};
  }

  void load() {
    rows_.clear();
    std::array<std::vector<double>, 2> turns, shifts;
    const TimeNs d = to_ns(fit_.delay), h = to_ns(kSlope);
    const Pose& X = fit_.T_B_A;
    for (const Motion& m : motions_) {
      const auto now = relative(m, d), before = relative(m, d - h), after = relative(m, d + h);
      if (!now || !before || !after) continue;
      Row row{&m,
              *now,
              (after->turn - before->turn) / (2 * kSlope),
              (after->p - before->p) / (2 * kSlope),
              now->turn - X.R * m.turn,
              now->R * X.p + now->p - X.R * m.shift - X.p};
      rows_.push_back(row);
      turns[m.kind].push_back(row.turn.norm());
      shifts[m.kind].push_back(row.shift.norm());
    }
    for (std::size_t kind = 0; kind < 2; ++kind) {
      sigma_turn_[kind] = spread_of(std::move(turns[kind]), kLeastTurn);
      sigma_shift_[kind] = spread_of(std::move(shifts[kind]), kLeastShift);
    }
  }

  ClusteredFit build() const {
    ClusteredFit system(7);
    const Vec3 off = fit_.T_B_A.p - expected_.p;
    for (int i = 0; i < 3; ++i) {
      system.hold(i, 0, kSigmaTurn);
      system.hold(3 + i, off[i], kSigmaShift);
    }
    system.hold(6, 0, kSigmaDelay);
    Eigen::MatrixXd J(3, 7);
    for (const Row& row : rows_) {
      const auto cluster = static_cast<int>((row.motion->begin - motions_.front().begin) / kCluster);
      const double turn = sigma_turn_[row.motion->kind], shift = sigma_shift_[row.motion->kind];
      const double weight = std::min(robust_weight(row.turn.norm(), turn), robust_weight(row.shift.norm(), shift));
      J << hat(fit_.T_B_A.R * row.motion->turn), Mat3::Zero(), row.turn_slope;
      system.add(cluster, J, row.turn, weight / (turn * turn));
      J << hat(fit_.T_B_A.R * row.motion->shift), Mat3(row.b.R - Mat3::Identity()), row.shift_slope;
      system.add(cluster, J, row.shift, weight / (shift * shift));
    }
    return system;
  }

  void apply(const Eigen::VectorXd& x) {
    fit_.T_B_A.R = orthonormalised(exp_so3(x.head<3>()) * fit_.T_B_A.R);
    fit_.T_B_A.p += x.segment<3>(3);
    fit_.delay += std::clamp(x[6], -0.05, 0.05);
  }

  double rms() const {
    double n = 0, squares = 0;
    for (const Row& row : rows_) {
      if (row.motion->kind != 0) continue;
      const double w = robust_weight(row.shift.norm(), sigma_shift_[0]);
      n += w;
      squares += w * row.shift.squaredNorm();
    }
    return n > 0 ? std::sqrt(squares / n) : 0;
  }

  void conclude(const Eigen::MatrixXd& covariance) {
    fit_.covariance = covariance.topLeftCorner<6, 6>();
    fit_.sigma_delay = std::sqrt(covariance(6, 6));
    fit_.pairs = rows_.size();
    fit_.rms = rms();
  }

  const std::vector<Motion>& motions_;
  const Trajectory& b_;
  TimeNs max_gap_;
  Pose expected_;
  Mat3 start_;
  HandEye& fit_;
  std::vector<Row> rows_;
  std::array<double, 2> sigma_turn_{}, sigma_shift_{};  ///< by kind [rad], [m]
};

}  // namespace

HandEye fit_hand_eye(std::span<const MotionStretch> a, const Trajectory& b, const HandEyeOptions& options) {
  HandEye fit;
  fit.delay = options.delay;
  std::vector<Motion> motions;
  add_motions(a, to_ns(options.span), 0, motions);
  add_motions(a, to_ns(3 * options.span), 1, motions);
  // Motions of one time are of one cluster.
  std::stable_sort(motions.begin(), motions.end(), [](const Motion& x, const Motion& y) { return x.begin < y.begin; });
  if (motions.size() < kFewest) {
    fit.problem = fmt::format("too short: {} motions of {:g} s, {} are needed", motions.size(), options.span, kFewest);
    return fit;
  }
  if (!Solver(motions, b, options, fit).run()) fit.problem = "the poses have too little time in common";
  return fit;
}

}  // namespace aslio::evaluation
