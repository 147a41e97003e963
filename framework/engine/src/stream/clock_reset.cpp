#include <algorithm>
#include <cstdlib>
#include <utility>

#include "aslio/stream/measurement_stream.hpp"

namespace aslio::stream {
namespace {

/// A sensor that goes on for so long, with so many measurements, has a clock that did not jump with the other's.
constexpr TimeNs kGoesOn = kSecond;
constexpr int kUsual = 3;
/// More is not kept of a sensor whose clock jumped while the other says nothing.
constexpr TimeNs kMaxKeptAfterJump = 10 * kSecond;
/// What the jumps of two clocks that are one may differ by: both are known to no more than the silence before.
constexpr TimeNs kJumpsAgree = kSecond;

}  // namespace

/// A measurement without a jump: this sensor's clock is as it was, and the other's may be the only one that jumped.
void MeasurementStream::note_usual(Jump& own, const Jump& other, const JumpGuard& other_guard, TimeNs other_last,
                                   TimeNs t) {
  if (own.pending) {  // it has come back
    own.pending = false;
    if (&own == &packet_jump_) packets_after_jump_.clear();
    if (&own == &imu_jump_) imu_after_jump_.clear();
  }
  if (!other.pending) return;
  if (usual_since_jump_++ == 0) first_usual_ = t;
  if (usual_since_jump_ >= kUsual && t - first_usual_ >= kGoesOn) other_guard.fail(other_last);
}

void MeasurementStream::keep_after_jump(ArrivedPacket&& arrived) {
  if (!packet_jump_.pending) {
    usual_since_jump_ = 0;
    packet_jump_ = {true, packet_guard_.jumped_to() - last_point_};
  }
  packets_after_jump_.push_back(std::move(arrived));
  const TimeNs kept = packets_after_jump_.back().key.last - packets_after_jump_.front().key.first;
  const bool alone = !imu_left_out_ && (last_imu_ == kTimeMin || kept > kMaxKeptAfterJump);
  if (alone) packet_guard_.fail(last_point_);
  if (imu_left_out_ || imu_jump_.pending) decide_on_jump(packet_guard_, last_point_);
}

void MeasurementStream::keep_after_jump(const ImuSample& sample) {
  if (!imu_jump_.pending) {
    usual_since_jump_ = 0;
    imu_jump_ = {true, imu_guard_.jumped_to() - last_imu_};
  }
  imu_after_jump_.push_back(sample);
  const TimeNs kept = sample.t - imu_after_jump_.front().t;
  if (last_point_ == kTimeMin || kept > kMaxKeptAfterJump) imu_guard_.fail(last_imu_);
  if (packet_jump_.pending) decide_on_jump(imu_guard_, last_imu_);
}

/// Pre: the clocks of all sensors in use have jumped.
void MeasurementStream::decide_on_jump(const JumpGuard& guard, TimeNs last) {
  if (!imu_left_out_ && std::abs(imu_jump_.by - packet_jump_.by) > kJumpsAgree) guard.fail(last);
  reset_clock();
}

/// Points of before have nothing to do with what follows, and time goes on where it ended. IMU samples stay as long as
/// dead reckoning asks for them: most clocks jump while the sensors go on.
void MeasurementStream::reset_clock() {
  const bool by_imu = imu_jump_.pending;  // which knows it better
  const TimeNs by = by_imu ? imu_jump_.by : packet_jump_.by;
  const TimeNs shift = (by_imu ? std::max<TimeNs>(imu_period(), 1) : 1) - by;
  const TimeNs end = std::max(last_point_, last_imu_);
  clock_jumps_.push_back({end, by});
  ++counters_.clock_jumps;
  clock_shift_ += shift;
  points_.forget(points_.size());
  sweeps_.clear();
  drop_held_packets();
  drop_held_imu();
  packet_guard_.forget();
  imu_guard_.forget();
  screen_.forget();
  recent_count_ = 0;
  packet_jump_ = imu_jump_ = {};
  if (last_cut_ == kTimeMin) {  // nothing has begun
    first_point_.reset();
    first_imu_.reset();
    imu_.forget(imu_.size());
  }
  released_ = std::max(released_, end);
  skipped_from_ = last_cut_;
  skipped_until_ = end;
  auto packets = std::exchange(packets_after_jump_, {});
  auto samples = std::exchange(imu_after_jump_, {});
  for (ArrivedPacket& arrived : packets) {
    arrived.packet.stamp += shift;
    for (TimedPoint& p : arrived.packet.points) p.t += shift;
    arrived.key.stamp += shift;
    arrived.key.first += shift;
    arrived.key.last += shift;
    arrived.reordered = 0;  // against those before
    admit(std::move(arrived));
  }
  for (ImuSample& sample : samples) {
    sample.t += shift;
    admit(sample);
  }
}

}  // namespace aslio::stream
