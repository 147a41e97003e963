#include "aslio/pipeline/sweep_motion.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "aslio/core/angles.hpp"
#include "aslio/core/spread.hpp"
#include "inertial_path.hpp"
#include "motion_normal.hpp"

namespace aslio::pipeline {

namespace {

constexpr double kMaxSpeed = 40.0;               // [m/s]
constexpr std::size_t kReferencePoints = 40000;  // of the first sweep
constexpr std::size_t kScanPoints = 8000;        // of a sweep, where nothing stands upright
constexpr double kMaxUprightRange = 100.0;       // and to compare velocities by what stands there [m]
constexpr std::size_t kMinSweepPoints = 100;     // a sweep with fewer says nothing
constexpr double kSigmaGyro = 0.02;              // of a rate that is not corrected for its bias [rad/s]
constexpr double kMaxOfGyro = 0.1;               // a bias beyond that is implausible (MON-4) [rad/s]

class Registration {
 public:
  Registration(std::span<const TimedPoint> points, std::span<const ImuSample> imu, TimeNs begin,
               const SensorModel& sensor)
      : inertial_(!imu.empty()) {
    know_gravity(imu);
    InertialPath path(imu, begin);
    const TimeNs period = to_ns(sweep_motion_step(sensor));
    std::size_t next = 0;
    for (int k = 0; k < kSweepsOfMotion; ++k) {
      const std::size_t first = next;
      while (next < points.size() && points[next].t <= begin + (k + 1) * period) ++next;
      const auto of = static_cast<std::size_t>(k);
      std::vector<SweepPoint> all = placed(points.subspan(first, next - first), path, sensor);
      std::vector<SweepPoint> standing = upright(all);
      if (k == 0) overlap_edge_ = spread_edge(standing, 3 * kMinSweepPoints / 2);
      standing_[of] = spread(standing, kQueryPoints, 1.0 / overlap_edge_);
      std::erase_if(all, [](const SweepPoint& p) { return p.q.norm() > kMaxRange; });
      sweeps_[of] = k == 0 ? spread(all, kReferencePoints, 6.0)
                           : spread(all, kQueryPoints, 1.0 / spread_edge(all, kMinSweepPoints));
      if (standing_[of].size() < kMinSweepPoints) standing_[of] = some(sweeps_[of], kScanPoints);
    }
    if (!complete()) return;
    finest_ = finest_level();
  }

  bool complete() const {
    return std::all_of(sweeps_.begin(), sweeps_.end(), [](const auto& s) { return s.size() >= kMinSweepPoints; });
  }
  const ConstantMotion& prior() const { return prior_; }
  bool inertial() const { return inertial_; }

  /// Share of the second sweep that falls into occupied cells, for one velocity.
  double coarse_score(const Vec3& v) { return overlap(with_velocity(v), 0, 1); }

  /// The same of the first three sweeps with each other. It has no ill will against the fast, whose later sweeps see
  /// what the first one did not.
  double overlap(const ConstantMotion& motion) {
    return (overlap(motion, 0, 1) + overlap(motion, 1, 2) + overlap(motion, 0, 2)) / 3.0;
  }

  ConstantMotion with_velocity(const Vec3& v) const {
    ConstantMotion motion = prior_;
    motion.v = v;
    return motion;
  }

  void build(const ConstantMotion& motion, std::size_t level) {
    cells_.build(sweeps_[0], motion, kLevels[level].edge, kLevels[level].softness);
    if (coarse_too_) coarse_.build(sweeps_[0], motion, kLevels[0].edge, kLevels[0].softness);
  }

  /// From now on a coarse level takes part beside the fine one: it binds what only surfaces between distant scan lines
  /// do. Not before: it would hold the search back where it is.
  void add_coarse_level() { coarse_too_ = finest_ > 0; }

  /// Registers sweeps 1 to `last` with sweep 0, at kLevels from `from` on.
  void refine(ConstantMotion& motion, std::size_t from, std::size_t last) {
    for (std::size_t level = std::min(from, finest_); level <= finest_; ++level) {
      for (int i = 0; i < kLevels[level].iterations; ++i) {
        if (i % 2 == 0) build(motion, level);
        if (step(motion, last) < 1e-3) break;
      }
    }
  }

  /// Mean agreement of the upright points of a sweep at the finest level. `all`: those that meet no surface count as
  /// well, as not in agreement.
  double fit(const ConstantMotion& motion, std::size_t sweep, bool all) {
    cells_.build(sweeps_[0], motion, kLevels[finest_].edge, kLevels[finest_].softness);
    return agreement(standing_[sweep], motion, cells_, all);
  }

  /// Covariance of (v, g, e) after refine(). The softness stands for one standard deviation; on real drives the errors
  /// are twice what that gives, for the points of a cell err together.
  Mat9 covariance(const ConstantMotion& motion, std::size_t last) {
    constexpr double together = 2.0;
    build(motion, finest_);
    return together * together * linearise(motion, last).H.ldlt().solve(Mat9::Identity());
  }

  /// Takes the mean specific force as a measurement of gravity. The points bind an acceleration over so short a time
  /// hardly better than a vehicle's own acceleration blurs the force. That one is seldom large, but then very large:
  /// Student's t with four degrees of freedom in the two directions of tilt.
  void level(ConstantMotion& motion, Mat9& P) const {
    constexpr double own_acceleration = 0.7;  // of a vehicle or a walk, scale [m/s^2]
    constexpr double freedom = 4.0;
    if (!inertial_) return;
    const Vec3 residual = prior_.g - motion.g;
    const double scale = own_acceleration * own_acceleration + force_variance_;
    const double variance = (freedom * scale + residual.squaredNorm()) / (freedom + 2.0);
    const Eigen::LDLT<Mat3> solver(P.block<3, 3>(3, 3) + variance * Mat3::Identity());
    const Eigen::Matrix<double, 9, 3> gain = solver.solve(P.middleRows<3>(3)).transpose();
    const Vec9 step = gain * residual;
    motion.v += step.head<3>();
    motion.g += step.segment<3>(3);
    motion.e += step.tail<3>();
    motion.g *= kStandardGravity / motion.g.norm();
    P -= (gain * P.middleRows<3>(3)).eval();
  }

 private:
  /// The direction of the mean specific force, and how much that one varies.
  void know_gravity(std::span<const ImuSample> imu) {
    if (imu.empty()) return;
    Vec3 force = Vec3::Zero();
    for (const ImuSample& sample : imu) force += sample.acc;
    // All zero where the sensor is dead: then no direction is known.
    inertial_ = force.squaredNorm() > 0;
    if (!inertial_) return;
    prior_.g = -kStandardGravity * force.normalized();
    force /= static_cast<double>(imu.size());
    for (const ImuSample& sample : imu) {
      force_variance_ += (sample.acc - force).squaredNorm() / static_cast<double>(imu.size());
    }
  }

  static std::vector<SweepPoint> placed(std::span<const TimedPoint> raw, InertialPath& path,
                                        const SensorModel& sensor) {
    std::vector<SweepPoint> out;
    out.reserve(raw.size());
    for (const TimedPoint& p : raw) {
      const Vec3 p_L(p.x, p.y, p.z);
      const double range = p_L.norm();
      if (range < sensor.min_range || range > std::min(sensor.max_range, kMaxUprightRange)) continue;
      out.push_back(path.point(sensor.T_imu_lidar * p_L, p.t));
    }
    return out;
  }

  /// Share of the upright points of a sweep that fall into cells in which an earlier one has some.
  double overlap(const ConstantMotion& motion, std::size_t earlier, std::size_t later) {
    occupied_.build(standing_[earlier], motion, overlap_edge_);
    std::size_t hits = 0;
    for (const SweepPoint& p : standing_[later]) hits += occupied_.occupied(motion.place(p)) ? 1 : 0;
    return static_cast<double>(hits) / static_cast<double>(standing_[later].size());
  }

  /// One of every cell, so that near surfaces do not outvote all others, and of those so many.
  static std::vector<SweepPoint> spread(const std::vector<SweepPoint>& all, std::size_t most, double inverse_edge) {
    CellIndex index;
    std::vector<SweepPoint> apart;
    std::vector<double> off;  // of each from the centre of its cell
    for (const SweepPoint& p : all) {
      const auto cell = cell_of(p.q, inverse_edge);
      if (!cell) continue;
      const double distance = (inverse_edge * p.q - Vec3(cell->x + 0.5, cell->y + 0.5, cell->z + 0.5)).squaredNorm();
      const std::uint32_t at = index.find(pack(*cell));
      if (at == CellIndex::kNone) {
        index.insert(pack(*cell), static_cast<std::uint32_t>(apart.size()));
        apart.push_back(p);
        off.push_back(distance);
      } else if (distance < off[at]) {
        apart[at] = p;
        off[at] = distance;
      }
    }
    return some(apart, most);
  }

  /// Edge of cells of which one point each is kept: 1 m, less where that leaves too few, as in a room.
  static double spread_edge(const std::vector<SweepPoint>& sweep, std::size_t enough) {
    constexpr double finest = 0.2;  // [m]
    double edge = 1.0;
    while (edge > finest && spread(sweep, kQueryPoints, 1.0 / edge).size() < enough) edge *= 0.5;
    return edge;
  }

  /// Points of what stands upright: lines of the scanner on the ground move with the sensor and look at rest.
  std::vector<SweepPoint> upright(const std::vector<SweepPoint>& all) const {
    constexpr double column = 1.0, height = 0.6;  // [m]
    const Mat3 to_level = level_frame();
    CellIndex index;
    std::vector<std::pair<double, double>> extents;
    std::vector<std::uint32_t> of(all.size());
    for (std::size_t i = 0; i < all.size(); ++i) {
      const Vec3 p = to_level * all[i].q;
      const auto cell = cell_of(Vec3(p.x(), p.y(), 0), 1.0 / column);
      const std::uint64_t key = cell ? pack(*cell) : 0;
      of[i] = index.find(key);
      if (of[i] == CellIndex::kNone) {
        of[i] = static_cast<std::uint32_t>(extents.size());
        index.insert(key, of[i]);
        extents.emplace_back(p.z(), p.z());
      }
      auto& [low, high] = extents[of[i]];
      low = std::min(low, p.z());
      high = std::max(high, p.z());
    }
    std::vector<SweepPoint> out;
    for (std::size_t i = 0; i < all.size(); ++i) {
      if (extents[of[i]].second - extents[of[i]].first > height) out.push_back(all[i]);
    }
    return out;
  }

  /// Rotation from B to a frame whose z is up.
  Mat3 level_frame() const {
    const Vec3 up = prior_.g.squaredNorm() > 0 ? Vec3(-prior_.g.normalized()) : Vec3(Vec3::UnitZ());
    return Eigen::Quaterniond::FromTwoVectors(up, Vec3::UnitZ()).toRotationMatrix();
  }

  static std::vector<SweepPoint> some(const std::vector<SweepPoint>& all, std::size_t most) {
    std::vector<SweepPoint> out;
    const std::size_t taken = std::min(most, all.size());
    StratifiedPick choice(taken, all.size(), 1);
    for (std::size_t k = 0; k < taken; ++k) out.push_back(all[choice.next()]);
    return out;
  }

  MotionNormal linearise(const ConstantMotion& motion, std::size_t last) {
    // Known beforehand: the direction of gravity to 10 deg, the rate of the gyro.
    const MotionSigma sigma{100.0, inertial_ ? 1.7 : 3.0, inertial_ ? kSigmaGyro : 1.0};
    MotionNormal sum;
    sum.add_prior(motion, prior_, sigma);
    for (std::size_t k = 1; k <= last; ++k) {
      sum.add_matches(sweeps_[k], motion, cells_);
      if (coarse_too_) sum.add_matches(sweeps_[k], motion, coarse_);
    }
    return sum;
  }

  double step(ConstantMotion& motion, std::size_t last) {
    const double moved = linearise(motion, last).step(motion);
    if (inertial_) motion.g *= kStandardGravity / motion.g.norm();
    return moved;
  }

  /// The finest level at which enough points meet a surface: few lines leave small cells without one.
  std::size_t finest_level() {
    constexpr double enough = 0.25;
    for (std::size_t level = kLevels.size() - 1; level > 0; --level) {
      cells_.build(sweeps_[0], prior_, kLevels[level].edge, kLevels[level].softness);
      std::size_t met = 0;
      for (const SweepPoint& p : sweeps_[1]) met += cells_.nearest(prior_.place(p)) != nullptr ? 1 : 0;
      if (static_cast<double>(met) >= enough * static_cast<double>(sweeps_[1].size())) return level;
    }
    return 0;
  }

  bool inertial_;
  double overlap_edge_ = 1;    ///< [m]
  double force_variance_ = 0;  ///< of the specific force over the span [m^2/s^4]
  std::size_t finest_ = kLevels.size() - 1;
  std::array<std::vector<SweepPoint>, kSweepsOfMotion> sweeps_, standing_;  ///< all points, those of upright columns
  ConstantMotion prior_;
  SweepCells cells_, coarse_;
  bool coarse_too_ = false;
  OccupiedCells occupied_;
};

/// Velocities on a grid of displacements per sweep, `high` layers of it above and below the plane across `up`.
void add_hypotheses(const Vec3& up, int high, double period, std::vector<Vec3>& out) {
  constexpr double spacing = 0.75;  // [m]
  const double reach = kMaxSpeed * period;
  const int n = static_cast<int>(std::ceil(reach / spacing));
  const Vec3 along = up.unitOrthogonal(), across = up.cross(along);
  for (int i = -n; i <= n; ++i) {
    for (int j = -n; j <= n; ++j) {
      for (int k = -high; k <= high; ++k) {
        const Vec3 shift = spacing * (i * along + j * across + k * up);
        if (shift.norm() <= reach && (i != 0 || j != 0 || k != 0)) out.push_back(shift / period);
      }
    }
  }
}

/// Across the specific force; across the axis of the IMU next to it as well, for a car that brakes is not on a slope.
/// Without an IMU, in all directions.
std::vector<Vec3> hypotheses(const Registration& registration, double period) {
  std::vector<Vec3> out;
  if (!registration.inertial()) {
    add_hypotheses(Vec3::UnitZ(), 2, period, out);
  } else {
    constexpr double same = 0.998, upright = 0.9;  // cosines
    const Vec3 up = -registration.prior().g.normalized();
    add_hypotheses(up, 0, period, out);
    int nearest = 0;
    const double cosine = up.cwiseAbs().maxCoeff(&nearest);
    if (cosine > upright && cosine < same) add_hypotheses(Vec3::Unit(nearest), 0, period, out);
  }
  std::sort(out.begin(), out.end(), [](const Vec3& a, const Vec3& b) { return a.squaredNorm() < b.squaredNorm(); });
  return out;
}

struct Scored {
  Vec3 v = Vec3::Zero();
  double score = 0;
};

constexpr double kSame = 0.03;   // overlaps that differ by less are equal
constexpr double kBetter = 1.1;  // a fit that is better by less is as good
constexpr double kFits = 0.35;   // of the best fit: less is none
// A motion may be the right one although another overlaps by so much more and fits so many times better: guard rails.
constexpr double kAlsoOverlaps = 0.16, kAlsoFits = 1.35;
constexpr double kCertain = 0.3;  // sigma of one of several that is taken [m/s]
// Sweeps of a narrow view in a sharp turn share less of it. What little they share then fits one velocity or another.
constexpr double kShares = 0.3;  // least overlap of a motion that is believed
constexpr double kApart = 1.2;   // displacements per sweep that differ by more are two [m]

/// A rest, and the velocities to look at closely: those that overlap the most, apart from each other.
std::vector<Vec3> candidates(Registration& registration, double period) {
  constexpr std::size_t most = 5;  // of them
  std::vector<Scored> scored;
  for (const Vec3& v : hypotheses(registration, period)) scored.push_back({v, registration.coarse_score(v)});
  std::stable_sort(scored.begin(), scored.end(), [](const Scored& a, const Scored& b) { return a.score > b.score; });
  std::vector<Vec3> out = {Vec3::Zero()};
  for (const Scored& s : scored) {
    if (out.size() > most) break;
    const bool apart =
        std::all_of(out.begin(), out.end(), [&](const Vec3& v) { return (v - s.v).norm() * period > kApart; });
    if (apart) out.push_back(s.v);
  }
  return out;
}

struct Refined {
  ConstantMotion motion;
  double overlap = 0, fit = 0;
};

struct Choice {
  ConstantMotion motion;
  bool alone = true;  ///< no other motion, apart from it, explains the sweeps as well
};

/// Of those that fit at all and overlap the most, the one that fits best; of two that fit as well, the slower one.
Choice choose(const std::vector<Refined>& refined, double period) {
  double most = 0, fittest = 0;
  for (const Refined& r : refined) fittest = std::max(fittest, r.fit);
  for (const Refined& r : refined) {
    if (r.fit > kFits * fittest) most = std::max(most, r.overlap);
  }
  ConstantMotion best;
  double best_fit = -1;
  for (const Refined& r : refined) {
    if (r.fit <= kFits * fittest || r.overlap < most - kSame) continue;
    if (r.fit > kBetter * best_fit || (kBetter * r.fit > best_fit && r.motion.v.norm() < best.v.norm())) {
      best = r.motion;
      best_fit = std::max(r.fit, best_fit);
    }
  }
  const bool alone = std::none_of(refined.begin(), refined.end(), [&](const Refined& r) {
    const bool fits = r.fit > kFits * fittest && r.overlap >= most - kAlsoOverlaps && kAlsoFits * r.fit > best_fit;
    return fits && (r.motion.v - best.v).norm() * period > kApart;
  });
  return {best, alone};
}

}  // namespace

// eq. INI-6.
std::optional<SweepMotion> find_sweep_motion(std::span<const TimedPoint> points, std::span<const ImuSample> imu,
                                             TimeNs begin, const SensorModel& sensor) {
  const double step = sweep_motion_step(sensor);
  constexpr double kRestSpeed = 0.15;  // who stands and holds the sensor may be as fast [m/s]
  Registration registration(points, imu, begin, sensor);
  if (!registration.complete()) return std::nullopt;

  const ConstantMotion rest = registration.with_velocity(Vec3::Zero());
  const double overlap_at_rest = registration.overlap(rest);
  std::vector<Refined> refined;
  for (const Vec3& v : candidates(registration, step)) {
    Refined r;
    r.motion = registration.with_velocity(v);
    registration.refine(r.motion, 0, 1);
    r.overlap = registration.overlap(r.motion);
    r.fit = registration.fit(r.motion, 2, true);
    refined.push_back(r);
  }
  auto [best, alone] = choose(refined, step);
  const double overlap = registration.overlap(best);
  const bool overlaps_more = overlap > overlap_at_rest + kSame;
  registration.refine(best, kLevels.size(), 2);

  SweepMotion out;
  constexpr std::size_t check = kSweepsOfMotion - 1;
  out.fit = registration.fit(best, check, false);
  out.fit_at_rest = registration.fit(rest, check, false);
  const bool better =
      overlaps_more || registration.fit(best, check, true) > kBetter * registration.fit(rest, check, true);
  const bool fits = out.fit > 0.6 * registration.fit(best, 1, false);

  registration.add_coarse_level();
  registration.refine(best, kLevels.size(), check);
  Mat9 P = registration.covariance(best, check);
  registration.level(best, P);
  out.velocity = best.v;
  out.rate = best.e;
  if (registration.inertial()) out.gravity = best.g;
  const auto worst = [&](int at) {
    return std::sqrt(std::max(
        0.0, Eigen::SelfAdjointEigenSolver<Mat3>(P.block<3, 3>(at, at), Eigen::EigenvaluesOnly).eigenvalues()[2]));
  };
  out.sigma_velocity = worst(0);
  out.sigma_tilt = worst(3) / kStandardGravity;
  out.moves = better && best.v.norm() > std::max(kRestSpeed, out.sigma_velocity);
  out.ambiguous = !alone;
  out.contradicts_gyro = registration.inertial() && best.e.norm() > kMaxOfGyro;
  out.shares = overlap > kShares;
  out.believed = out.shares && fits && !out.contradicts_gyro && out.sigma_velocity < (alone ? 1.0 : kCertain);
  return out;
}

}  // namespace aslio::pipeline
