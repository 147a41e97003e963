// Which measurements are taken: copies, wild stamps, pauses and clocks that jump.
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

template <class T, class U>
void MeasurementStream::admit(Channel<T>& own, Channel<U>& other, std::type_identity_t<T>&& arrived) {
  const bool copy_of_held = own.holds_copy_of(arrived);  // which confirms nothing
  if (!copy_of_held) {
    for (T& held : own.confirmed_by(arrived)) accept(std::move(held));
  }
  if (copy_of_held || is_copy(arrived)) {
    ++copies(arrived);
    return;
  }
  // Counted before the guard speaks, so that the counter is right also when it throws.
  time_jumps(arrived) += own.implausible(arrived) ? 1 : 0;
  const JumpGuard::Verdict verdict = own.judge(arrived, comes_second(arrived));
  if (verdict == JumpGuard::Verdict::ignore) return;
  if (verdict == JumpGuard::Verdict::jumped) return keep_after_jump(own, other, std::move(arrived));
  note_usual(own, other, begin_of(arrived));
  if (verdict == JumpGuard::Verdict::begin) forget_before(arrived);
  if (verdict != JumpGuard::Verdict::hold_too) time_jumps(arrived) += own.drop_held();
  if (verdict == JumpGuard::Verdict::hold || verdict == JumpGuard::Verdict::hold_too)
    own.hold(std::move(arrived));
  else
    accept(std::move(arrived));
}

template void MeasurementStream::admit(Channel<ArrivedPacket>&, Channel<ArrivedSample>&, ArrivedPacket&&);
template void MeasurementStream::admit(Channel<ArrivedSample>&, Channel<ArrivedPacket>&, ArrivedSample&&);

/// The first packet had a wild stamp, as the three after it agree.
void MeasurementStream::forget_before(ArrivedPacket& arrived) {
  counters_.points -= points_.size();
  points_.forget(points_.size());
  sweeps_.clear();
  first_point_.reset();
  packets_.forget_newest();
  arrived.reordered = 0;  // against the first one
}

void MeasurementStream::forget_before(const ArrivedSample& /*arrived*/) {
  --counters_.imu;
  imu_.forget(imu_.size());
  screen_.forget();
  first_imu_.reset();
  samples_.forget_newest();
}

/// A measurement without a jump: this sensor's clock is as it was, and the other's may be the only one that jumped.
template <class T, class U>
void MeasurementStream::note_usual(Channel<T>& own, const Channel<U>& other, TimeNs t) {
  if (own.jumped()) own.forget_jump();
  if (!other.jumped()) return;
  if (usual_since_jump_++ == 0) first_usual_ = t;
  if (usual_since_jump_ >= kUsual && t - first_usual_ >= kGoesOn) other.fail();
}

template <class T, class U>
void MeasurementStream::keep_after_jump(Channel<T>& own, const Channel<U>& other, std::type_identity_t<T>&& arrived) {
  if (!own.jumped()) usual_since_jump_ = 0;
  const TimeNs kept = own.keep_after_jump(std::move(arrived));
  const bool silent = other.newest() == kTimeMin || kept > kMaxKeptAfterJump;
  if (!imu_left_out_ && silent) own.fail();
  if (!imu_left_out_ && !other.jumped()) return;
  // The clocks of all sensors in use have jumped.
  if (!imu_left_out_ && std::abs(own.jump() - other.jump()) > kJumpsAgree) own.fail();
  reset_clock();
}

/// Points of before have nothing to do with what follows, and time goes on where it ended. IMU samples stay as long as
/// dead reckoning asks for them: most clocks jump while the sensors go on.
void MeasurementStream::reset_clock() {
  const bool by_imu = samples_.jumped();  // which knows it better
  const TimeNs by = by_imu ? samples_.jump() : packets_.jump();
  const TimeNs shift = (by_imu ? std::max<TimeNs>(imu_period(), 1) : 1) - by;
  const TimeNs end = std::max(packets_.newest(), samples_.newest());
  clock_jumps_.push_back({end, by});
  ++counters_.clock_jumps;
  clock_shift_ += shift;
  points_.forget(points_.size());
  sweeps_.clear();
  counters_.packet_time_jumps += packets_.drop_held();
  counters_.imu_time_jumps += samples_.drop_held();
  auto packets = packets_.begin_again();
  auto samples = samples_.begin_again();
  screen_.forget();
  recent_count_ = 0;
  if (last_cut_ == kTimeMin) {  // nothing has begun
    first_point_.reset();
    first_imu_.reset();
    imu_.forget(imu_.size());
  }
  released_ = std::max(released_, end);
  skipped_from_ = last_cut_;
  skipped_until_ = end;
  for (ArrivedPacket& arrived : packets) {
    arrived.packet.stamp += shift;
    for (TimedPoint& p : arrived.packet.points) p.t += shift;
    arrived.key.stamp += shift;
    arrived.key.first += shift;
    arrived.key.last += shift;
    arrived.reordered = 0;  // against those before
    admit(packets_, samples_, std::move(arrived));
  }
  for (ArrivedSample& sample : samples) {
    sample.t += shift;
    admit(samples_, packets_, std::move(sample));
  }
}

}  // namespace aslio::stream
