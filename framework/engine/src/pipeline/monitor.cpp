#include "aslio/pipeline/monitor.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "aslio/core/angles.hpp"
#include "aslio/core/lie.hpp"

namespace aslio::pipeline {

namespace {

constexpr double kNow = 0.15;   ///< time over which something is "now" [s]
constexpr double kUsual = 3.0;  ///< and over which it is usual [s]
constexpr double kKnown = 1.0;  ///< nothing is usual before [s]

// Thresholds, chosen on seeds from 100 up: docs/results/monitor.md.
constexpr double kViewJump = 3.3, kViewStir = 2.2;  ///< factors: alone, and with a misfit
constexpr double kViewLeast = 0.1, kStirred = 0.5;  ///< change of the view; time after one [s]
constexpr double kMisfit = 1.65, kMisfitStirred = 1.2, kRout = 2.4;
// Of that, what residuals and matches must say without the corrections: an old part of the map that is met again some
// centimetres off says less (docs/results/monitor.md).
constexpr double kWorseFit = 1.5, kWorseFitStirred = 0.5;
constexpr double kMisfitFor = 0.12;                     ///< [s]
constexpr double kRoutFor = 0.25;                       ///< longer than a swing past a near wall [s]
constexpr double kTear = 30.0;                          ///< velocity that the points take or give [m/s^2]
constexpr double kMismatch = 0.15, kTurnEnough = 0.05;  ///< of the turn; of a turn of that many (rad/s)^2
constexpr double kWrongFor = 0.2;                       ///< [s]
// Shares of the view: least that counts, least that is usual, factors for an alarm and to be stirred.
constexpr double kUnexplained = 0.1, kUnexplainedUsual = 0.025;
// In a sharp turn poses are off by degrees for a moment: share per rad/s beyond this rate [rad/s].
constexpr double kUnexplainedTurn = 0.15, kSharpTurn = 1.0;
// A piece that is missing leaves most of the change of the view unexplained; a turn past something near, half of it.
constexpr double kUnexplainedOfChange = 0.6;
constexpr double kUnexplainedJump = 4.0, kUnexplainedStir = 2.5;
// Beside a jump of the view in the same sweep: share of the surfaces and of the change for an alarm, share to be
// stirred.
constexpr double kUnexplainedBoth = 0.06, kBothOfChange = 0.5, kUnexplainedStirs = 0.03;
// A motion that is not there: least share, factor to the change of the view, slots in a row.
constexpr double kPhantom = 0.06, kPhantomOfChange = 2.0;
constexpr int kPhantomSlots = 3;
constexpr double kScale = 0.03, kDelay = 0.015, kGyroBias = 0.1, kAccBias = 1.5;
constexpr double kMountTurn = 0.05, kMountShift = 0.15;  // of T_imu_lidar [rad, m]

/// Turn that the gyro measured over the window, in I [rad], its bias included.
Vec3 measured_turn(std::span<const ImuSample> imu) {
  Vec3 turn = Vec3::Zero();
  for (std::size_t i = 1; i < imu.size(); ++i) {
    turn += 0.5 * to_seconds(imu[i].t - imu[i - 1].t) * (imu[i].gyro + imu[i - 1].gyro);
  }
  return turn;
}

/// Whether something stands in for the gyro.
bool unread(const Window& window) {
  constexpr auto bad = imu_fault::gyro_dead | imu_fault::gyro_clipped;
  return window.imu_gap > 0 ||
         std::any_of(window.imu.begin(), window.imu.end(), [](const ImuSample& s) { return (s.faults & bad) != 0; });
}

double length(const Window& window) {
  return std::clamp(to_seconds(window.plan.end - window.plan.fresh_begin), 1e-3, 0.5);
}

/// Nearest axis of a direction.
std::size_t axis_of(const Vec3& direction) {
  int axis = 0;
  direction.cwiseAbs().maxCoeff(&axis);
  return static_cast<std::size_t>(axis);
}

}  // namespace

std::string unbound_text(const MonitorReport& report) {
  static constexpr std::array kNames = {"translation along x of the body",
                                        "translation along y of the body",
                                        "translation along z of the body",
                                        "roll",
                                        "pitch",
                                        "yaw"};
  std::string text;
  for (std::size_t i = 0; i < kNames.size(); ++i) {
    if (report.unbound[i] < 1.0) continue;
    text += fmt::format("{}{} is not bound ({:.1f} s)", text.empty() ? "" : ", ", kNames[i], report.unbound[i]);
  }
  return text;
}

template <class T>
void Monitor::Mean<T>::add(const T& x, double dt, double time) {
  const double share = 1.0 - std::exp(-dt / time);
  weight += (1.0 - weight) * share;
  value += (share / weight) * (x - value);
}

double Monitor::Level::rise(double x, double dt, bool known) {
  now.add(x, dt, kNow);
  const double out = known ? now.value - usual.value : 0.0;
  usual.add(x, dt, kUsual);
  return out;
}

double Monitor::Pull::rise(const Vec3& x, double dt, bool known) {
  now.add(x, dt, kNow);
  const double square = now.value.squaredNorm();
  const double out = known && usual.value > 0 ? std::sqrt(square / usual.value) : 0.0;
  usual.add(square, dt, kUsual);
  return out;
}

void Monitor::begin(bool uses_imu) {
  uses_imu_ = uses_imu;
  view_.forget();
  check_.forget();
  mount_ = {};
  signals_ = {};
  alarm_.reset();
  age_ = misfit_for_ = rout_for_ = implausible_for_ = torn_for_ = 0;
  rms_ = nis_ = matched_ = known_ = {};
  velocity_ = turn_ = {};
  contradicted_ = {};
  turned_ = {};
  view_count_ = unexplained_count_ = phantom_slots_ = 0;
  fastest_ = fastest_before_ = 0;
  sweeps_ = {};
  since_jump_ = 1e9;
  refused_for_ = unsettled_for_ = 0;
  doubted_ = false;
}

const MonitorSignals& Monitor::observe(const Window& window, const Update& update, const OverlapScore& overlap,
                                       bool bridged) {
  signals_ = {};
  alarm_.reset();
  measure_view(window, update, bridged);
  judge_gap(window, update);
  if (!update.accepted || update.restart_map) {
    mount_.interrupt();
    return signals_;
  }
  const double dt = length(window);
  measure_fit(update, overlap, dt);
  measure_pull(window, update, dt, bridged);
  age_ += dt;
  note_unbound(update, dt);
  judge_fit(dt);
  judge_gyro();
  judge_learnt(update, dt);
  return signals_;
}

/// A long gap of the IMU is bridged by the points or not at all: a prediction over it is a guess. eq. MON-5.
void Monitor::judge_gap(const Window& window, const Update& update) {
  constexpr TimeNs bridged_by_itself = kSecond / 2;
  if (!uses_imu_ || window.imu_gap < bridged_by_itself || update.status != UpdateStatus::few_matches) return;
  raise(fmt::format("no IMU data for {:.2f} s, and the points after it match nothing", to_seconds(window.imu_gap)));
}

// eq. MON-1.
void Monitor::measure_fit(const Update& update, const OverlapScore& overlap, double dt) {
  const bool known = age_ > kKnown;
  const auto points = static_cast<double>(std::max<std::size_t>(update.matches.size(), 1));
  const auto matched = static_cast<double>(
      std::count_if(update.matches.begin(), update.matches.end(), [](const MatchRecord& m) { return m.matched; }));
  signals_.nis = update.nis;
  signals_.matched = matched / points;
  signals_.fit_rise = rms_.rise(std::log(std::max(update.residual_rms, 1e-4)), dt, known);
  signals_.match_loss = -matched_.rise(std::log(std::max(signals_.matched, 1e-2)), dt, known);
  if (overlap.value) {
    signals_.overlap_loss = -known_.rise(std::log(std::max(*overlap.value, 2e-2)), dt, known);
  }
  if (update.nis > 0) signals_.nis_rise = nis_.rise(std::log(std::max(update.nis, 1e-4)), dt, known);
}

// eq. MON-2.
void Monitor::measure_view(const Window& window, const Update& update, bool bridged) {
  since_jump_ += length(window);
  if (update.trajectory == nullptr || !update.state.R.allFinite()) return;
  for (const ImuSample& s : window.imu) fastest_ = std::max(fastest_, s.gyro.norm());
  const auto change = view_.add(window.fresh, *update.trajectory, window.plan.end);
  if (change) judge_change(*change);
  // Without a gyro a turn that the points follow late changes the view as well.
  const bool tells = uses_imu_ && signals_.view_change > kViewLeast;
  const bool stirs = tells && signals_.view_jump > kViewStir;
  if (finds_itself(window, update)) {
    check_.forget();
    phantom_slots_ = 0;
  } else if (!uses_imu_ || bridged || unread(window)) {
    check_.forget();  // within such a window the poses are a guess, in a sharp turn
    phantom_slots_ = 0;
    if (stirs) since_jump_ = 0;
  } else if (const auto unexplained = check_.add(window.fresh, *update.trajectory, window.plan.end, view_.ended())) {
    judge_unexplained(*unexplained);
    // What a turn brings into view is where the motion puts it.
    if (stirs && unexplained->share > kUnexplainedStirs) since_jump_ = 0;
  } else if (view_.ended()) {
    phantom_slots_ = 0;  // too little is seen again: nothing is said of this sweep
  }
  if (tells && signals_.view_jump > kViewJump) {
    raise(
        fmt::format("{:.1f} times more of the view changed at once than before: a piece of the data is missing, or the "
                    "sensor was moved",
                    signals_.view_jump));
  }
}

/// Whether the run finds itself again after updates that were refused: then it moves by corrections, too, which no view
/// shows. eq. MON-6.
bool Monitor::finds_itself(const Window& window, const Update& update) {
  constexpr double blind = 0.25, settles = 0.3;  // [s]
  if (!update.accepted) {
    refused_for_ += length(window);
    if (refused_for_ > blind) unsettled_for_ = settles;
    return false;
  }
  refused_for_ = 0;
  const bool unsettled = unsettled_for_ > 0;
  unsettled_for_ -= length(window);
  return unsettled;
}

// eq. MON-2.
void Monitor::judge_change(double change) {
  signals_.view_change = change;
  if (view_count_ >= 4) {
    const double usual = std::max(*std::max_element(views_.begin(), views_.end()), 0.03);
    signals_.view_jump = change / usual;
  }
  sweeps_ = {Sweep{change, signals_.view_jump}, sweeps_[0]};
  views_[static_cast<std::size_t>(view_count_++ % 4)] = change;
}

// eq. MON-6.
void Monitor::judge_unexplained(const Unexplained& seen) {
  const double share = signals_.unexplained = seen.share;
  // Against the slot before the last one, what was in that between counts, too.
  const auto [last, before_last] = sweeps_;
  const double change = seen.skips ? std::max(last.change, before_last.change) : last.change;
  const double jump = seen.skips ? std::max(last.jump, before_last.jump) : last.jump;
  const double turn = seen.skips ? std::max(fastest_, fastest_before_) : fastest_;
  if (unexplained_count_ >= 4) {
    const double before = *std::max_element(unexplained_.begin(), unexplained_.end());
    const double usual = std::max(before, kUnexplainedUsual);
    const double least =
        std::max(kUnexplained + kUnexplainedTurn * std::max(turn - kSharpTurn, 0.0), kUnexplainedOfChange * change);
    // A jump of the view in the same sweep: two signs that are weak alone.
    const bool jumps = change > kViewLeast && jump > kViewStir;
    const bool both = jumps && share > kUnexplainedBoth && share > kBothOfChange * change;
    if (both || (share > least && share > kUnexplainedJump * usual)) {
      raise(
          fmt::format("{:.0f} % of the surfaces seen before are not where the motion of the run puts them, usually "
                      "{:.0f} %. A piece of the data is missing, or the sensor was moved",
                      100 * share, 100 * before));
    }
    if (share > least && share > kUnexplainedStir * usual) since_jump_ = 0;
  }
  unexplained_[static_cast<std::size_t>(unexplained_count_++ % 4)] = share;
  const bool phantom = !seen.skips && share > kPhantom && share > kPhantomOfChange * change;
  phantom_slots_ = phantom ? phantom_slots_ + 1 : 0;
  fastest_before_ = std::exchange(fastest_, 0.0);
}

// eq. MON-3.
void Monitor::measure_pull(const Window& window, const Update& update, double dt, bool bridged) {
  if (bridged) {  // it was predicted from its own points
    mount_ = {};
    velocity_.now = turn_.now = {};
    return;
  }
  const bool known = age_ > kKnown;
  const Mat3 Rt = update.prior.R.transpose();
  const Vec3 turn = log_so3(Rt * update.state.R);
  signals_.velocity_pull_rise = velocity_.rise(Rt * (update.state.v - update.prior.v) / dt, dt, known);
  signals_.turn_pull_rise = turn_.rise(turn / dt, dt, known);
  signals_.velocity_pull = velocity_.now.value.norm();
  signals_.turn_pull = turn_.now.value.norm();
  std::uint8_t faults = 0;
  for (const ImuSample& s : window.imu) faults |= s.faults;
  const bool dead = (faults & imu_fault::gyro_dead) != 0;
  doubted_ = doubted_ || dead;
  // What stands in for the gyro, and the corrections that mend it later, say nothing of the mounting.
  if (!uses_imu_ || window.imu_gap > 0 || faults != 0) mount_ = {};
  if (!uses_imu_ || window.imu.size() < 2 || window.imu_gap > 0) return;
  if (faults != 0 && !dead) return;  // an axis at the end of its range is known to be wrong
  const Vec3 measured = measured_turn(window.imu);
  contradicted_.add(turn * measured.transpose() / (dt * dt), dt, kUsual);
  turned_.add(measured.squaredNorm() / (dt * dt), dt, kUsual);
  if (turned_.value > kTurnEnough) signals_.gyro_mismatch = contradicted_.value.norm() / turned_.value;
  const double span = to_seconds(window.imu.back().t - window.imu.front().t);
  if (faults == 0) mount_.add(turn, measured - span * update.prior.b_w, dt);
  signals_.mount = mount_.contradiction();
}

// eqs. MON-3, MON-6.
void Monitor::judge_fit(double dt) {
  const double pull = std::max(signals_.velocity_pull_rise, signals_.turn_pull_rise);
  const double pulled = 0.5 * std::max(std::log(std::max(pull, 1e-3)), 0.0);
  signals_.misfit = signals_.fit_rise + pulled - 0.5 * std::max(signals_.overlap_loss, 0.0);
  const double worse_fit = signals_.fit_rise + std::max(signals_.match_loss, 0.0);
  const bool stirred = since_jump_ < kStirred;
  // Without an IMU nothing holds a run that the points lead astray: corrections are as good a sign as residuals.
  const double least = !uses_imu_ ? 0.0 : stirred ? kWorseFitStirred : kWorseFit;
  const bool misfit = signals_.misfit > (stirred ? kMisfitStirred : kMisfit) && worse_fit > least;
  misfit_for_ = misfit ? misfit_for_ + dt : 0.0;
  const bool rout = worse_fit + pulled > kRout;
  rout_for_ = rout ? rout_for_ + dt : 0.0;
  if (misfit_for_ > kMisfitFor || rout_for_ > kRoutFor) {
    raise(
        fmt::format("the points no longer fit: residuals {:.1f} times as large as usual, matches {:.1f} times as rare, "
                    "corrections of the state {:.1f} times as large",
                    std::exp(signals_.fit_rise), std::exp(signals_.match_loss), pull));
  }
  if (age_ > kKnown && phantom_slots_ >= kPhantomSlots && worse_fit > kWorseFitStirred) {
    raise(fmt::format(
        "the run moves as the view does not: for {} sweeps, at least {:.0f} % of the surfaces are not where "
        "its motion puts them, and residuals and matches are {:.1f} times worse than usual",
        phantom_slots_, 100 * kPhantom, std::exp(worse_fit)));
  }
  torn_for_ = age_ > kKnown && signals_.velocity_pull > kTear ? torn_for_ + dt : 0.0;
  if (torn_for_ > kMisfitFor) {
    raise(fmt::format("the points change the velocity against its prediction by {:.0f} m/s^2", signals_.velocity_pull));
  }
}

// eqs. MON-3, MON-7.
void Monitor::judge_gyro() {
  if (age_ > kKnown && signals_.gyro_mismatch > kMismatch) {
    const double share = 100 * signals_.gyro_mismatch;
    raise(
        doubted_
            ? fmt::format(
                  "the points contradict {:.0f} % of the turn that replaces the readings of a stuck or dead IMU", share)
            : fmt::format("the points contradict {:.0f} % of the turn that the gyro measures: implausible: check "
                          "T_imu_lidar, gyro_unit",
                          share));
  }
  if (signals_.mount > 1.0) {
    const Vec3& axis = mount_.axis();
    raise(
        fmt::format("the points contradict {:.0f} % of the turn about ({:.1f}, {:.1f}, {:.1f}) that the gyro measures: "
                    "implausible: check the rotation of T_imu_lidar",
                    100 * mount_.share(), axis.x(), axis.y(), axis.z()));
  }
}

namespace {

/// What of the learnt state is beyond what a part can have, with the evidence of P; empty: nothing. `strict`: beyond
/// doubt.
std::string implausible(const Update& update, bool strict) {
  const NavState& x = update.state;
  const double sigmas = strict ? 5.0 : 3.0, share = strict ? 3.3 : 0.67;
  std::string what;
  const auto beyond = [&](double value, double sigma, double limit) {
    return sigma > 0 && std::abs(value) > share * limit && std::abs(value) - sigmas * sigma > 0.5 * share * limit;
  };
  /// The first of the entries that is; one is enough to name.
  const auto look_at = [&](const auto& values, const auto& sigmas_of, double limit, double unit, const char* name,
                           const char* of) {
    for (Eigen::Index i = 0; i < values.size(); ++i) {
      if (!beyond(values[i], sigmas_of[i], limit)) continue;
      what += fmt::format("{}{} {:+.3g} +- {:.1g} {}", what.empty() ? "implausible: " : ", ", name, unit * values[i],
                          unit * sigmas_of[i], of);
      return;
    }
  };
  const StateVector sigma = update.P.diagonal().cwiseMax(0.0).cwiseSqrt();
  const auto look = [&](const double* values, int count, int at, double limit, double unit, const char* name,
                        const char* of) {
    look_at(Eigen::Map<const Eigen::VectorXd>(values, count), sigma.segment(at, count), limit, unit, name, of);
  };
  look(x.S_w.data(), 9, block::s, kScale, 100, "gyro scale or cross-axis term", "%");
  look(&x.imu_delay, 1, block::d, kDelay, 1e3, "IMU delay", "ms");
  look(x.b_w.data(), 3, block::b_w, kGyroBias, 1, "gyro bias", "rad/s");
  look(x.b_a.data(), 3, block::b_a, kAccBias, 1, "accelerometer bias", "m/s^2");
  if (const auto& s = update.sensor) {
    const Vec3 turn = log_so3(s->declared.R.transpose() * s->T_imu_lidar.R), shift = s->T_imu_lidar.p - s->declared.p;
    look_at(turn, s->sigma_rotation, kMountTurn, 1 / kRadPerDeg, "turn of T_imu_lidar", "deg");
    look_at(shift, s->sigma_translation, kMountShift, 1, "shift of T_imu_lidar", "m");
  }
  return what.empty() ? what : what + ": check T_imu_lidar";
}

}  // namespace

// eq. MON-4.
void Monitor::judge_learnt(const Update& update, double dt) {
  report_.implausible = implausible(update, false);
  if (report_.implausible.empty()) {
    implausible_for_ = 0.0;
    return;
  }
  const std::string certain = implausible(update, true);
  implausible_for_ = certain.empty() ? 0.0 : implausible_for_ + dt;
  if (implausible_for_ > kWrongFor) raise(certain);
}

/// The direction that the points leave open.
void Monitor::note_unbound(const Update& update, double dt) {
  if (!update.unobservable_direction() || !update.weakest.allFinite() || update.weakest.isZero()) return;
  const Vec3 turn = update.weakest.head<3>(), shift = update.state.R.transpose() * update.weakest.tail<3>();
  if (shift.squaredNorm() >= turn.squaredNorm()) {
    report_.unbound[axis_of(shift)] += dt;
    return;
  }
  const bool upright = std::abs((update.state.R * turn.normalized()).z()) > 0.8;
  report_.unbound[upright ? 5 : 3 + axis_of(turn)] += dt;
}

void Monitor::raise(std::string reason) {
  if (alarm_) return;
  alarm_ = std::move(reason);
  signals_.alarm = true;
  ++report_.alarms;
}

}  // namespace aslio::pipeline
