#pragma once
/// What a run amounts to: the content of summary.json, and the one place where the status of a run is decided.

#include <array>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "aslio/core/trajectory.hpp"
#include "aslio/evaluation/evaluation.hpp"
#include "aslio/experiment/calibration.hpp"
#include "aslio/pipeline/tracking.hpp"
#include "aslio/pipeline/update_record.hpp"
#include "aslio/stream/measurement_stream.hpp"

namespace aslio::experiment {

/// A run whose updates cover less of its data than this has failed.
inline constexpr double kMinCoverage = 0.95;
/// Initialisation may take this long before the time it takes counts as uncovered [ns].
inline constexpr TimeNs kInitialisationGrace = kSecond;
/// A run with weak updates (degenerate, few matches, not finite) over more than this share of its time is `degraded`.
/// Of its time, not of its updates: a window that shortens itself where the view is weak must not look worse for it.
inline constexpr double kMaxWeakShare = 0.25;
/// A step between IMU samples, or between points, beyond this makes a run `degraded` [ns].
inline constexpr TimeNs kLongGap = kSecond / 2;

/// IMU readings that are clipped, stuck or zero for more than this in all make a run `degraded` [ns].
inline constexpr TimeNs kDoubtedImu = kSecond / 10;

/// Minimum, median and maximum of the rate of updates [Hz]; windows that a gap or the end cut short do not count.
struct RateRange {
  double min = 0, median = 0, max = 0;
};

/// Everything summary.json holds.
struct Summary {
  pipeline::RunStatus status = pipeline::RunStatus::failed;
  std::string reason;                        ///< why the status is not `ok`
  std::optional<TimeNs> moment;              ///< data time of the divergence or of the failure
  std::vector<pipeline::Divergence> losses;  ///< those of the odometry itself, in the order of time
  pipeline::MonitorReport monitor;           ///< alarms, what is implausible, which direction was not bound
  std::string initialisation;                ///< the verdict
  std::string start_doubt;                   ///< why the first velocity may be wrong; empty: nothing speaks against it
  std::vector<std::string> notes;            ///< verdicts and warnings of the reader
  double coverage = 0;                       ///< share of the data's duration inside fresh intervals that counted
  stream::StreamCounters counters;
  std::uint64_t malformed_lidar = 0, malformed_imu = 0;  ///< messages that the reader could not decode and left out
  std::array<std::uint64_t, 6> updates_by_status{};      ///< by UpdateStatus
  std::array<std::uint64_t, 6> refused_by_status{};      ///< of them, those refused: after the map had its first points
  std::uint64_t updates_bridged = 0;                     ///< points stood in for IMU readings
  std::uint64_t gyro_bias_steps = 0;                     ///< that were found
  std::uint64_t updates_without_view = 0;                ///< hardly any points came, which is no refusal
  std::uint64_t accepted = 0;                            ///< updates that corrected the state
  std::uint64_t matchable_points = 0;                    ///< points that the samplers left to match, of all updates
  double refused_s = 0;                                  ///< time of those after the first accepted update [s]
  double weak_share = 0;                                 ///< of the time of all windows, that of weak updates
  std::uint64_t updates = 0;
  double longest_imu_gap_s = 0, longest_lidar_gap_s = 0;
  double imu_period_s = 0;  ///< between IMU samples, as a rule
  std::optional<RateRange> rate_hz;
  double path_length_m = 0;
  double cpu_s = 0;   ///< process CPU time of the loop: reading, updates and writing
  double wall_s = 0;  ///< the same in wall-clock time
  double data_s = 0;  ///< from the first to the last point read
  double peak_rss_mb = 0;
  double range_sigma = 0;                  ///< of the sensor file [m]
  std::optional<double> range_sigma_seen;  ///< [m] (eq. NOI-1)
  double noise_scale = 1;                  ///< of the stages at the end (eq. NOI-2)
  std::optional<Calibration> calibration;  ///< of the IMU, at the end
  std::optional<double> end_to_end_m;      ///< distance between the first and the last position, of a closed loop
  std::optional<evaluation::Evaluation> evaluation;  ///< against the reference, when there is one
  std::optional<double> failed_at;                   ///< share of the reference's path, of failed_after()
  std::string evaluation_error;                      ///< why there is none although there is a reference
};

/// summary.json as text.
std::string to_json(const Summary& summary);

/// "31 of 273 updates degenerate, 4 of 273 updates few_matches": updates that bind the state poorly or not at all.
/// Empty when there is none.
std::string weak_updates(const Summary& summary);
/// Does this status mean that the update bound the state poorly or not at all?
bool is_weak(UpdateStatus status);

/// Steps of a run, of whatever length it is, in bounded memory: by their length, exact while there are few lengths, and
/// to a microsecond, ten, .. where there are many.
class StepCounts {
 public:
  /// `step`: positive [ns].
  void add(TimeNs step);
  /// Of all steps: the minimum and the maximum exact. Nothing without any.
  std::optional<RateRange> rates() const;

 private:
  void coarsen();

  static constexpr std::size_t kMaxLengths = 4096;
  std::map<TimeNs, std::uint64_t> counts_;  ///< by the length, a multiple of resolution_
  TimeNs resolution_ = 1;
  TimeNs shortest_ = kTimeMax, longest_ = 0;
};

/// Follows a run and gathers what its summary needs.
class SummaryCollector final : public pipeline::UpdateObserver {
 public:
  /// `keeps_poses`: false leaves poses() empty, and then the memory does not grow with the run.
  explicit SummaryCollector(bool keeps_poses = true) : keeps_poses_(keeps_poses) {}

  void on_update(const pipeline::UpdateRecord& record) override;
  /// Fills everything that follows from updates and stream. `data_end` is where the data would have ended, for a run
  /// that stopped early. A sensor that falls silent before the other one ends has a gap there; where the points end
  /// more than `max_gap` [ns] before the IMU does, that time is not covered.
  void fill(Summary& summary, const stream::MeasurementStream& stream, std::optional<TimeNs> data_end,
            TimeNs max_gap) const;

  /// The first moment at which the run was lost by itself: its state was not finite, or no update was accepted for more
  /// than kMaxSilence. `end`: of what it should have covered.
  std::optional<TimeNs> lost_at(TimeNs end) const;

  /// T_W_I at the end of every update with a finite state, if it keeps them.
  const std::vector<StampedPose>& poses() const { return poses_; }

 private:
  bool keeps_poses_;
  std::vector<StampedPose> poses_;
  std::optional<Vec3> first_position_, last_position_;
  double path_length_ = 0;  ///< [m]
  StepCounts steps_;        ///< between the ends of consecutive whole windows
  std::array<std::uint64_t, 6> by_status_{}, refused_{};
  std::uint64_t updates_ = 0, accepted_ = 0, matchable_points_ = 0, without_view_ = 0, bridged_ = 0, bias_steps_ = 0;
  TimeNs covered_ = 0;
  std::optional<TimeNs> first_begin_;
  std::optional<Calibration> calibration_;
  TimeNs refused_time_ = 0;  ///< after the first accepted update
  std::optional<TimeNs> first_end_, last_accepted_, silent_from_, not_finite_;
  TimeNs weak_ = 0, windows_ = 0;  ///< time of the fresh intervals of weak updates, and of all
};

/// What may end a run, in order of precedence.
struct RunOutcome {
  bool interrupted = false;
  std::optional<std::string> failure;  ///< reading, a stage or writing failed in the middle
  std::optional<std::pair<TimeNs, std::string>> divergence;
  bool truncated = false;
  pipeline::TrackingStatus tracking = pipeline::TrackingStatus::initialising;
};

/// Sets status, reason and moment. Pre: everything else of the summary is filled.
///   interrupted > failed (in the middle) > diverged > truncated > failed (no state, none accepted, lost, coverage) >
///   degraded > ok
void judge(Summary& summary, const RunOutcome& outcome);

}  // namespace aslio::experiment
