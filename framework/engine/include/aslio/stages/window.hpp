#pragma once
/// Windows: when is the next update, and over which points? (AS-LIO section III-C; docs/equations.md WIN-1..)

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "aslio/config/nested.hpp"
#include "aslio/core/types.hpp"

namespace aslio {

/// Outcome of one update.
enum class UpdateStatus : std::uint8_t { ok, initialising, few_matches, degenerate, not_converged, non_finite };

/// Deepest soft-margin layer any metric may report, plus one.
inline constexpr std::size_t kMaxLayers = 8;

/// What an overlap metric said of one frame. `value` is undefined on an empty map or with too few points.
struct OverlapScore {
  std::optional<double> value;                     ///< O in [0, 1], a share of points
  std::array<std::uint32_t, kMaxLayers> layers{};  ///< points at layer 0, 1, ..; disjoint
  std::uint32_t points = 0;                        ///< points scored
};

/// Result of the last update, for the window strategy and the samplers. Before the first update `t` is the start of the
/// stream.
struct Feedback {
  TimeNs t = 0;                       ///< t_{k-1}, end of the last window
  TimeNs first_insertion = kTimeMax;  ///< end of the first window whose update left the map with points
  UpdateStatus status = UpdateStatus::initialising;
  OverlapScore overlap;
  NavState state;
  std::array<double, 6> spectrum{};  ///< eigenvalues of the pose information, ascending
  std::uint32_t matches = 0;
  bool unobservable = false;  ///< Update::unobservable_direction()
};

/// Read access to the time-ordered stream, as far as it has arrived.
class StreamView {
 public:
  virtual ~StreamView() = default;
  /// All points / IMU samples up to and including this time have arrived, or are waited for no longer. kTimeMax once
  /// the source has ended.
  virtual TimeNs points_until() const = 0;
  virtual TimeNs imu_until() const = 0;
  /// Time of the last point / IMU sample that has arrived (kTimeMin: none).
  virtual TimeNs last_point() const = 0;
  virtual TimeNs last_imu() const = 0;
  /// Points with time in (begin, end], in time order.
  virtual std::span<const TimedPoint> points(TimeNs begin, TimeNs end) const = 0;
  /// IMU samples with time in (begin, end], in time order.
  virtual std::span<const ImuSample> imu(TimeNs begin, TimeNs end) const = 0;
  /// Time of the last point of the first sweep that ends after `t`, once a point of a later sweep has arrived or the
  /// source has ended.
  virtual std::optional<TimeNs> sweep_end_after(TimeNs t) const = 0;
};

/// Overlap of coming points at the predicted pose, for strategies that look ahead.
class OverlapProbe {
 public:
  virtual ~OverlapProbe() = default;
  /// Score of the points in (feedback.t, t] at the pose predicted by the IMU. Pre: points and IMU have arrived to t.
  virtual OverlapScore overlap(TimeNs t) = 0;
};

/// A decision: the window is (history_begin, end], of which (fresh_begin, end] is new.
/// fresh_begin is the end of the previous window: fresh intervals tile the stream.
struct WindowPlan {
  static constexpr std::size_t kMaxCuts = 32;

  TimeNs history_begin = 0;
  TimeNs fresh_begin = 0;
  TimeNs end = 0;
  std::array<TimeNs, kMaxCuts> cuts{};  ///< ends of sub-windows inside the fresh interval, ascending, last = end
  std::uint32_t cut_count = 0;          ///< 0: one interval
  // For the record (0 where the strategy has no such notion).
  double seg_time = 0;     ///< n of AS-LIO (7)
  double shift_time = 0;   ///< [s] of AS-LIO (8)
  std::uint32_t echo = 0;  ///< updates left at this n
  bool extended = false;   ///< shift lengthened because too few points had arrived
  bool partial = false;    ///< end of the stream or a gap cut the window short
};

/// Contract. Pre: called with the feedback of the window it returned last. Post: nothing, when the stream has not yet
/// arrived to the end the strategy wants (call again after more data), or when the source has ended and nothing is
/// left; otherwise a plan with fresh_begin == feedback.t < end, history_begin <= fresh_begin, and points and IMU
/// arrived to `end`. Decisions depend on data time alone. Not thread-safe. O(1) amortised, no allocation.
class WindowStrategy : public Stage {
 public:
  static constexpr std::string_view family = "windows";
  virtual std::optional<WindowPlan> next(const StreamView& stream, const Feedback& feedback, OverlapProbe& probe) = 0;
  /// Longest time before `feedback.t` that a later window may reach back [ns]; the stream keeps that much.
  virtual TimeNs reach() const = 0;
  /// Whether its plans name cuts: of use to an estimator that takes them (Estimator::uses_cuts).
  virtual bool gives_cuts() const { return false; }
  /// Whether IMU data decide when it updates: nothing does where the estimator takes none (Estimator::uses_imu).
  virtual bool decides_by_imu() const { return false; }
};

/// The cut made by a plan: what an estimator works on. Spans stay valid until the stream is next extended.
struct Window {
  WindowPlan plan;
  std::uint32_t sequence = 0;         ///< k, counted from 1; the stamp of what is inserted at this update
  std::span<const TimedPoint> fresh;  ///< raw points in (fresh_begin, end], in time order
  /// Samples that cover [fresh_begin, end]: the first is at fresh_begin and the last at `end` (interpolated there), so
  /// consecutive pairs are the integration intervals. At least 2; fewer only when there is no IMU data at all.
  std::span<const ImuSample> imu;
  bool imu_read_at_end = false;  ///< the last of `imu` is a reading, not what was interpolated between two
  TimeNs imu_gap = 0;  ///< longest time between readings that it reaches into, when that is a gap [ns]; otherwise 0
};

}  // namespace aslio
