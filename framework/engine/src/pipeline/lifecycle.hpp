#pragma once
/// When a run starts, when it is lost, and when it starts again. The loop (odometry.cpp) asks here for a first state,
/// and says here what became of each window.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "aslio/pipeline/initialiser.hpp"
#include "aslio/pipeline/new_start.hpp"
#include "aslio/pipeline/odometry.hpp"
#include "aslio/pipeline/tracking.hpp"

namespace aslio::pipeline {

class Lifecycle {
 public:
  /// `stream`: that of the run, which outlives this.
  Lifecycle(const PipelineConfig& config, const SensorModel& sensor, TimeNs start_offset,
            stream::MeasurementStream& stream);

  bool started() const { return initialisation_.has_value(); }
  bool lost() const { return tracking_.lost(); }
  /// It is lost, and will not start again.
  bool has_ended() const {
    return lost() && (config_.when_lost == PipelineConfig::WhenLost::end || !tracking_.may_restart());
  }
  /// Windows are cut from here on: there is a state to go on from.
  bool running() const { return started() && !lost(); }

  /// A first state: of the run or, after a loss, of its next segment. Nothing while the data that have arrived do not
  /// suffice; what can be of no use any more is forgotten. `estimator`: the one that runs, or was lost, as it was then;
  /// `misled`: it has learnt from what does not fit. Pre: neither running() nor has_ended(). Post, with a state:
  /// running().
  std::optional<InitialState> find_start(const Estimator& estimator, bool misled);
  /// 0 for the first one.
  std::uint32_t segment() const { return segment_; }

  /// The clocks of both sensors jumped: the points of before are gone, and how long ago they were is not known.
  void note_clock_jumps();
  /// Before the window is cut: what comes after a gap that is too long is for a new start. `inertial`: IMU data are
  /// asked for.
  void note_gaps(const WindowPlan& plan, bool inertial);
  /// What became of a window. `unread`: it has no IMU readings to believe; `alarm`: of the monitor. Returns whether it
  /// was refused because hardly any points came, where usually many do.
  bool note_update(const Window& window, const Update& update, bool unread, const std::optional<std::string>& alarm);
  /// What comes while the LiDAR is silent would pile up. Points may be late, but not by so much.
  void forget_unused_imu();

  const Tracking& tracking() const { return tracking_; }
  const std::optional<Initialisation>& initialisation() const { return initialisation_; }

 private:
  std::optional<InitialState> first_start(bool inertial);
  std::optional<InitialState> next_start(const Estimator& estimator, bool misled);
  void begin(const NavState& state);
  void scale_specific_force(const Initialisation& found);
  bool look_at_sweeps(Initialisation& found, bool inertial, const Mat3* heading);
  void forget_waiting_data();
  TimeNs points_kept() const;
  LastKnown last_known(const NavState& state, bool misled) const;
  void note_gap(const WindowPlan& plan);
  bool lacks_view(const Window& window, const Update& update);
  bool sound(const NavState& state) const;

  /// Of data that wait for others, while there is no state. IMU data that come no later than this after the points
  /// change nothing by it.
  static constexpr TimeNs kMaxKept = 5 * kSecond;

  const PipelineConfig& config_;
  const SensorModel& sensor_;
  TimeNs start_offset_;
  stream::MeasurementStream& stream_;
  Tracking tracking_;
  std::optional<Initialisation> initialisation_;
  std::optional<NewStart> new_start_;          ///< while lost
  std::optional<Initialisation> found_start_;  ///< by it, not yet confirmed by the sweeps
  std::size_t clock_jumps_ = 0;                ///< of the stream, that the tracking knows of
  Pose believed_;                              ///< T_W_I where the run starts again if it is lost now
  TimeNs last_point_ = 0, last_accepted_ = 0, segment_begin_ = 0;
  double usual_density_ = 0;  ///< points per second of the updates that were accepted
  std::uint32_t segment_ = 0;
};

}  // namespace aslio::pipeline
