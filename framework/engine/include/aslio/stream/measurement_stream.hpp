#pragma once
/// The time-ordered stream of points and IMU samples, and the cutting of windows by point time, never by packet.
/// Points with equal time stay together on one side of any cut. Memory is bounded by what windows may still reach; but
/// where no points come any more, IMU data stay until one does or release() lets them go.

#include <algorithm>
#include <array>
#include <cstdint>
#include <type_traits>
#include <utility>
#include <vector>

#include "aslio/core/measurement.hpp"
#include "aslio/stages/window.hpp"
#include "aslio/stream/arrival.hpp"
#include "aslio/stream/channel.hpp"
#include "aslio/stream/imu_screen.hpp"
#include "aslio/stream/time_ordered.hpp"

namespace aslio::stream {

/// What was not taken as it came. Every anomaly has a counter; all are written to the summary.
struct StreamCounters {
  std::uint64_t packets = 0;            ///< arrived
  std::uint64_t empty_packets = 0;      ///< without a single valid point
  std::uint64_t duplicate_packets = 0;  ///< stamp, size and time extent of a recent packet: ignored
  /// Implausibly far from the last point (> 1 s back, > 60 s ahead, or > 1 s ahead of all that follow): ignored.
  std::uint64_t packet_time_jumps = 0;
  std::uint64_t points = 0;               ///< accepted
  std::uint64_t points_invalid = 0;       ///< not finite, absurdly far (> 1e5 m), or dropped by the decoder
  std::uint64_t points_beyond_lines = 0;  ///< of those that the decoder dropped, for their line number alone
  std::uint64_t points_stray = 0;         ///< time more than 1 s away from the body of the packet: dropped
  std::uint64_t points_late = 0;          ///< before the last cut: dropped
  /// Of a time that was released though no window was cut from it, such as those of a message that reaches over the
  /// start of the odometry, or over a new one after a loss: dropped, and no anomaly.
  std::uint64_t points_before_start = 0;
  std::uint64_t points_reordered = 0;  ///< arrived out of order, put in order
  std::uint64_t imu = 0;               ///< accepted
  std::uint64_t imu_invalid = 0;       ///< not finite, or beyond kMaxRate or kMaxForce: dropped
  std::uint64_t imu_duplicate = 0;     ///< equal stamp: first kept
  std::uint64_t imu_late = 0;          ///< before the last cut: dropped
  std::uint64_t imu_reordered = 0;
  std::uint64_t imu_time_jumps = 0;                     ///< as packet_time_jumps
  std::uint64_t clock_jumps = 0;                        ///< of both sensors together
  ImuFindings imu_found;                                ///< of the readings
  std::uint64_t imu_gaps = 0;                           ///< steps longer than 5 median periods, as they arrived
  TimeNs longest_imu_step = 0, longest_point_step = 0;  ///< of accepted ones, as they arrived [ns]
};

/// The clock of both sensors jumped.
struct ClockJump {
  TimeNs t = 0;   ///< the last time before, as of all that came before
  TimeNs by = 0;  ///< ahead where it is positive [ns]
};

class MeasurementStream final : public StreamView {
 public:
  MeasurementStream() = default;
  /// `range`: of the IMU, as far as it is known.
  explicit MeasurementStream(const ImuRange& range) : screen_(range) {}

  /// Points in any order. Three measurements in a row that agree show that a clock jumped (> 1 s back or > 60 s ahead).
  /// Where the other sensor's did, too, the points are forgotten, and what follows is moved to go on in time
  /// (clock_jumps()). Where the other sensor goes on for a second, or has sent nothing, the push()es throw DataError.
  /// Fewer are ignored and counted, and so is the first of all when the three after it agree against it. One of more
  /// than 1 s ahead is held until the next two of its sensor show whether it was a pause, or at the end of the data the
  /// other sensor. A copy shows nothing. IMU samples pass a screen (ImuScreen).
  void push(LidarPacket&& packet);
  void push(const ImuSample& sample);
  /// No more data: *_until() become kTimeMax.
  void finish();
  /// Nobody takes IMU data: it is not waited for, and what is pushed is dropped.
  void leave_imu_out() { imu_left_out_ = true; }
  /// From now on IMU data are not waited for where points of more than `patience` [ns] later have come. (Else one that
  /// falls silent would stop all windows, and the points pile up.)
  void wait_for_imu(TimeNs patience) { imu_patience_ = patience; }

  /// cut() and imu_covering() give the specific force times `factor` from now on, what imu() gives stays as read. Pre:
  /// factor > 0. eq. INI-7.
  void scale_specific_force(double factor) { force_scale_ = factor; }

  /// The window of a plan: spans into the stream, IMU interpolated at both ends (held where IMU data is missing).
  /// Valid until the next push(), release() or cut().
  Window cut(const WindowPlan& plan, std::uint32_t sequence);
  /// IMU samples covering [begin, end], interpolated at both ends, in caller's storage. Pre: begin < end. Where there
  /// are none, the nearest is held at an end, and a gap is bridged by a line; empty only when there is no IMU data at
  /// all.
  void imu_covering(TimeNs begin, TimeNs end, std::vector<ImuSample>& out) const;
  /// The sample after which there is none for more than `longest` [ns], the first such that lies before `end` and has
  /// its successor after `begin`. After the newest sample, to the newest point.
  std::optional<TimeNs> imu_silent_after(TimeNs begin, TimeNs end, TimeNs longest) const;
  /// Everything up to `t` may be forgotten; later arrivals before it are late, or, after the last cut, before the
  /// start.
  void release(TimeNs t);

  /// Points up to `t` may be forgotten, though later arrivals before it are none too late, and IMU data stay.
  void forget_points(TimeNs t);

  /// One ns short of the last point: the next packet may continue its firing, which no cut may split.
  TimeNs points_until() const override;
  TimeNs imu_until() const override;
  TimeNs last_point() const override;
  TimeNs last_imu() const override;
  std::span<const TimedPoint> points(TimeNs begin, TimeNs end) const override;
  std::span<const ImuSample> imu(TimeNs begin, TimeNs end) const override;
  std::optional<TimeNs> sweep_end_after(TimeNs t) const override;

  bool finished() const { return finished_; }
  /// Whether of each sensor in use more than one measurement was taken, or there are no more: until then the first may
  /// turn out to have had a wild stamp, and nothing should start or be released by it.
  bool settled() const { return finished_ || (recent_count_ > 1 && (imu_left_out_ || imu_settled())); }
  bool imu_settled() const { return counters_.imu > 1; }
  std::optional<TimeNs> first_point() const { return first_point_; }
  std::optional<TimeNs> first_imu() const { return first_imu_; }
  const StreamCounters& counters() const { return counters_; }
  /// In the order of time.
  const std::vector<ClockJump>& clock_jumps() const { return clock_jumps_; }
  /// What is added to the stamps that come now [ns].
  TimeNs clock_shift() const { return clock_shift_; }
  /// What the user should know of the readings, with remedies.
  std::vector<std::string> warnings() const { return screen_.warnings(); }
  /// Median of the last 101 steps between accepted IMU samples [ns]; 0 before two samples.
  TimeNs imu_period() const { return imu_steps_.median(); }
  std::size_t buffered_points() const { return points_.size(); }
  std::size_t buffered_imu() const { return imu_.size(); }
  std::size_t buffered_sweeps() const { return sweeps_.size(); }

 private:
  struct Sweep {
    std::uint32_t id = 0;
    TimeNs end = 0;  ///< time of its last point so far
  };
  /// What two copies of one message have in common.
  struct PacketKey {
    TimeNs stamp = 0, first = 0, last = 0;
    std::size_t size = 0;
    bool operator==(const PacketKey&) const = default;
  };
  static constexpr std::size_t kRecentPackets = 64;

  struct ArrivedPacket {
    LidarPacket packet;  ///< its points in time order
    PacketKey key;
    std::size_t reordered = 0;

    friend TimeNs begin_of(const ArrivedPacket& p) { return p.key.first; }
    friend TimeNs end_of(const ArrivedPacket& p) { return p.key.last; }
    friend bool are_copies(const ArrivedPacket& a, const ArrivedPacket& b) { return a.key == b.key; }
  };
  /// So that functions of it are found by argument-dependent lookup.
  struct ArrivedSample : ImuSample {
    friend TimeNs begin_of(const ArrivedSample& s) { return s.t; }
    friend TimeNs end_of(const ArrivedSample& s) { return s.t; }
    friend bool are_copies(const ArrivedSample& a, const ArrivedSample& b) { return a.t == b.t; }
  };

  bool seen_before(const PacketKey& key) const;
  template <class T, class U>
  void admit(Channel<T>& own, Channel<U>& other, std::type_identity_t<T>&& arrived);
  template <class T, class U>
  void keep_after_jump(Channel<T>& own, const Channel<U>& other, std::type_identity_t<T>&& arrived);
  template <class T, class U>
  void note_usual(Channel<T>& own, const Channel<U>& other, TimeNs t);
  // What the sensors differ in.
  bool is_copy(const ArrivedPacket& arrived) const { return seen_before(arrived.key); }
  static bool is_copy(const ArrivedSample&) { return false; }  // take() compares it with what was taken
  std::uint64_t& copies(const ArrivedPacket&) { return counters_.duplicate_packets; }
  std::uint64_t& copies(const ArrivedSample&) { return counters_.imu_duplicate; }
  std::uint64_t& time_jumps(const ArrivedPacket&) { return counters_.packet_time_jumps; }
  std::uint64_t& time_jumps(const ArrivedSample&) { return counters_.imu_time_jumps; }
  bool comes_second(const ArrivedPacket&) const { return recent_count_ == 1 && last_cut_ == kTimeMin; }
  bool comes_second(const ArrivedSample&) const { return counters_.imu == 1 && last_cut_ == kTimeMin; }
  void forget_before(ArrivedPacket& arrived);
  void forget_before(const ArrivedSample& arrived);
  void accept(ArrivedPacket&& arrived) { take(std::move(arrived)); }
  void accept(ArrivedSample&& arrived) { screen(arrived); }
  void reset_clock();
  void screen(const ImuSample& sample);
  void take(std::span<const ImuSample> judged);
  void take(ArrivedPacket&& arrived);
  void take(const ImuSample& sample);
  void note_sweeps(std::span<const TimedPoint> points);
  void forget_sweeps(TimeNs t);
  /// Between readings, of a time span and what lies around it [ns]; from or to its end where there are none.
  TimeNs longest_imu_step(TimeNs begin, TimeNs end) const;
  void learn_cut_steps(TimeNs end);
  ImuSample imu_at(std::size_t after, TimeNs t) const;
  /// Nothing at or before this time is taken any more.
  TimeNs closed_until() const { return std::max(released_, last_cut_); }

  TimeOrdered<TimedPoint> points_;
  TimeOrdered<ImuSample> imu_;
  std::vector<Sweep> sweeps_;  ///< in order of arrival
  std::vector<ImuSample> window_imu_;
  double force_scale_ = 1;
  std::array<PacketKey, kRecentPackets> recent_packets_{};
  std::size_t recent_count_ = 0;
  PacketSorter sorter_;
  Channel<ArrivedPacket> packets_{"LiDAR"};
  Channel<ArrivedSample> samples_{"IMU"};
  ImuScreen screen_;
  int usual_since_jump_ = 0;  ///< measurements of the sensor whose clock has not
  TimeNs first_usual_ = 0;
  TimeNs clock_shift_ = 0;
  std::vector<ClockJump> clock_jumps_;
  StepMedian imu_steps_;                 ///< of what has arrived
  StepMedian cut_steps_;                 ///< of the readings up to the last cut, in time order: however they arrive
  std::optional<TimeNs> last_cut_step_;  ///< the last of them
  std::optional<TimeNs> first_point_, first_imu_;
  TimeNs released_ = kTimeMin, last_cut_ = kTimeMin;
  /// From the last cut to the last release beyond it, if that was ever so: no window reaches back to it.
  TimeNs skipped_from_ = kTimeMin, skipped_until_ = kTimeMin;
  std::uint32_t next_index_ = 0;
  bool finished_ = false;
  bool imu_left_out_ = false;
  TimeNs imu_patience_ = kTimeMax;
  StreamCounters counters_;
};

}  // namespace aslio::stream
