#pragma once
/// Knowing that a run is lost: the same signals for every estimator, from what its updates say anyway.

#include <array>
#include <limits>
#include <optional>
#include <string>
#include <type_traits>

#include "aslio/pipeline/mount_check.hpp"
#include "aslio/pipeline/view_change.hpp"
#include "aslio/pipeline/view_check.hpp"

namespace aslio::pipeline {

/// What the monitor sees at one update (docs/equations.md MON-1..MON-6). Rises are logarithms of a mean over the last
/// moments to the run's own level of the last seconds: 0.7 is a factor of two. Nothing of the first second: 0.
struct MonitorSignals {
  double nis = 0;            ///< Update::nis; 0: none
  double matched = 0;        ///< share of the points to match that the map has a surface for
  double fit_rise = 0;       ///< of the RMS of the residuals
  double nis_rise = 0;       ///< of the squared innovation
  double match_loss = 0;     ///< of `matched`, downwards
  double overlap_loss = 0;   ///< of the overlap, downwards
  double velocity_pull = 0;  ///< mean change of velocity by the points, against the prediction [m/s^2]
  double turn_pull = 0;      ///< the same of the attitude [rad/s]
  double velocity_pull_rise = 0, turn_pull_rise = 0;  ///< these over their own level, as factors
  double misfit = 0;                                  ///< sum of the rises that say that the points fit no longer
  double gyro_mismatch = 0;                           ///< share of the measured turn that the points contradict
  double mount = 0;                                   ///< MountCheck::contradiction() (MON-7)
  double view_change = 0;  ///< mean |ln range ratio| of the last sweep (at least 0.1 s) to the one before
  double view_jump = 0;    ///< that over the largest of the four before, a factor
  /// Share of what was seen that is not where the run's own motion puts it (MON-6); NaN where no slot ended.
  double unexplained = std::numeric_limits<double>::quiet_NaN();
  bool alarm = false;
};

/// What a run amounts to for the summary.
struct MonitorReport {
  std::uint64_t alarms = 0;
  std::string implausible;          ///< of what the estimator has learnt at the end; empty: nothing
  std::array<double, 6> unbound{};  ///< time in which x, y, z, roll, pitch, yaw was the weakest direction, open [s]
};

/// "translation along x of the body is not bound (12.3 s), yaw is not bound (2.0 s)"; what lasted for less than a
/// second is left out.
std::string unbound_text(const MonitorReport& report);

/// Watches the updates of one run. It changes nothing: its alarm is for the loop to heed. Deterministic; no allocation
/// but for the text of an alarm. Not thread-safe.
class Monitor {
 public:
  explicit Monitor(const SensorModel& sensor) : view_(sensor), check_(sensor) {}

  /// `uses_imu`: the prior is a prediction by the IMU. Forgets all levels, not the report.
  void begin(bool uses_imu);
  /// `overlap`: of this window with what was known before it. `bridged`: its IMU data come from its points (WID-1), and
  /// say nothing against them.
  const MonitorSignals& observe(const Window& window, const Update& update, const OverlapScore& overlap,
                                bool bridged = false);
  /// Why the run is lost by the update that was observed last; nothing: it is not.
  const std::optional<std::string>& alarm() const { return alarm_; }
  const MonitorReport& report() const { return report_; }

 private:
  /// Mean with exponential forgetting over data time, without bias at its begin.
  template <class T>
  struct Mean {
    T value;
    double weight = 0;
    Mean() {
      if constexpr (std::is_arithmetic_v<T>) {
        value = 0;
      } else {
        value.setZero();
      }
    }
    void add(const T& x, double dt, double time);
  };
  /// A quantity now and as it usually is.
  struct Level {
    Mean<double> now, usual;
    double rise(double x, double dt, bool known);
  };
  /// What MON-2 says of one.
  struct Sweep {
    double change = 0, jump = 0;
  };
  struct Pull {
    Mean<Vec3> now;
    Mean<double> usual;  ///< of the squared norm of `now`
    double rise(const Vec3& x, double dt, bool known);
  };

  void judge_gap(const Window& window, const Update& update);
  void measure_fit(const Update& update, const OverlapScore& overlap, double dt);
  void measure_pull(const Window& window, const Update& update, double dt, bool bridged);
  void judge_change(double change);
  void judge_unexplained(const Unexplained& seen);
  bool finds_itself(const Window& window, const Update& update);
  void measure_view(const Window& window, const Update& update, bool bridged);
  void note_unbound(const Update& update, double dt);
  void judge_learnt(const Update& update, double dt);
  void judge_fit(double dt);
  void judge_gyro();
  void raise(std::string reason);

  ViewChange view_;
  ViewCheck check_;
  MountCheck mount_;
  bool uses_imu_ = true;
  MonitorSignals signals_;
  MonitorReport report_;
  std::optional<std::string> alarm_;
  double age_ = 0;  ///< time of accepted updates [s]
  Level rms_, nis_, matched_, known_;
  Pull velocity_, turn_;
  Mean<Mat3> contradicted_;  ///< [rad^2/s]
  Mean<double> turned_;      ///< [rad^2/s]
  std::array<double, 4> views_{};
  int view_count_ = 0;
  std::array<double, 4> unexplained_{};
  int unexplained_count_ = 0;
  int phantom_slots_ = 0;                    ///< in a row, with a motion of the run that the view does not show
  double fastest_ = 0, fastest_before_ = 0;  ///< turn rate since the last slot that said something, before it [rad/s]
  std::array<Sweep, 2> sweeps_{};            ///< the last one first
  double since_jump_ = 1e9;                  ///< [s] of the last jump of the view
  double refused_for_ = 0;                   ///< [s] without an accepted update
  double unsettled_for_ = 0;                 ///< [s] still, after many refused ones
  bool doubted_ = false;                     ///< something stood in for the gyro since begin()
  /// [s] without a break.
  double misfit_for_ = 0, rout_for_ = 0, implausible_for_ = 0, torn_for_ = 0;
};

}  // namespace aslio::pipeline
