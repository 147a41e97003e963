#pragma once
/// The time-ordered stream of points and IMU samples, and the cutting of windows by point time, never by packet.
/// Points with equal time stay together on one side of any cut. Memory is bounded by what windows may still reach.

#include <cstdint>
#include <vector>

#include "aslio/core/measurement.hpp"
#include "aslio/stages/window.hpp"

namespace aslio::stream {

/// What was not taken as it came. Every anomaly has a counter; all are written to the summary.
struct StreamCounters {
  std::uint64_t packets = 0, empty_packets = 0, duplicate_packets = 0;
  std::uint64_t points = 0;            ///< accepted
  std::uint64_t points_invalid = 0;    ///< not finite or dropped by the decoder
  std::uint64_t points_late = 0;       ///< before the last cut: dropped
  std::uint64_t points_reordered = 0;  ///< arrived out of order, put in order
  std::uint64_t imu = 0;               ///< accepted
  std::uint64_t imu_invalid = 0;       ///< not finite: dropped
  std::uint64_t imu_duplicate = 0;     ///< equal stamp: first kept
  std::uint64_t imu_late = 0;          ///< before the last cut: dropped
  std::uint64_t imu_reordered = 0;
  std::uint64_t imu_time_jumps = 0;  ///< stamps implausibly far from the last (> 1 s back or > 60 s ahead): dropped
  std::uint64_t imu_gaps = 0;        ///< steps longer than 5 median periods
};

class MeasurementStream final : public StreamView {
 public:
  MeasurementStream();

  void push(LidarPacket&& packet);
  void push(const ImuSample& sample);
  /// No more data: *_until() become kTimeMax.
  void finish();

  /// The window of a plan: spans into the stream, IMU interpolated at both ends (held where IMU data is missing).
  /// Valid until the next push(), release() or cut().
  Window cut(const WindowPlan& plan, std::uint32_t sequence);
  /// IMU samples covering [begin, end], interpolated at both ends, in caller's storage.
  bool imu_covering(TimeNs begin, TimeNs end, std::vector<ImuSample>& out) const;
  /// Everything up to `t` may be forgotten; later arrivals before it are late.
  void release(TimeNs t);

  TimeNs points_until() const override;
  TimeNs imu_until() const override;
  TimeNs last_point() const override;
  TimeNs last_imu() const override;
  std::span<const TimedPoint> points(TimeNs begin, TimeNs end) const override;
  std::span<const ImuSample> imu(TimeNs begin, TimeNs end) const override;
  std::optional<TimeNs> sweep_end_after(TimeNs t) const override;

  bool finished() const { return finished_; }
  std::optional<TimeNs> first_point() const { return first_point_; }
  std::optional<TimeNs> first_imu() const { return first_imu_; }
  const StreamCounters& counters() const { return counters_; }
  /// Median step between accepted IMU samples so far [ns]; 0 before two samples.
  TimeNs imu_period() const;
  std::size_t buffered_points() const { return points_.size() - points_head_; }

 private:
  std::vector<TimedPoint> points_;
  std::size_t points_head_ = 0;
  std::vector<ImuSample> imu_;
  std::size_t imu_head_ = 0;
  std::vector<ImuSample> window_imu_;
  std::optional<TimeNs> first_point_, first_imu_;
  TimeNs released_ = kTimeMin;
  std::uint32_t next_index_ = 0;
  bool finished_ = false;
  StreamCounters counters_;
};

}  // namespace aslio::stream
