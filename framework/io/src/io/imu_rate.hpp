#pragma once

#include <span>
#include <vector>

#include "aslio/io/source.hpp"
#include "stamp_clock.hpp"

namespace aslio::io {

/// IMU data by which units and rate are judged; the norm of gravity is judged on the first second.
inline constexpr TimeNs kJudgedImuSpan = 5 * kSecond;
inline constexpr std::size_t kJudgedImuSamples = 20'000;  ///< at most

/// The samples of that data, of a topic of a bag. Those whose stamps are far off do not count.
class ImuBeginning {
 public:
  /// As sent. False once there are enough.
  bool add(const ImuSample& sample, TimeNs recorded);
  /// At the end of the messages, or of what is wanted of them.
  void finish();

  const std::vector<ImuSample>& samples() const { return samples_; }
  const StampClock& clock() const { return clock_; }

 private:
  void wait(const ImuSample& sample, TimeNs recorded);
  void judge_clock();
  void take(const ImuSample& sample, TimeNs recorded);

  std::vector<ImuSample> samples_;
  std::vector<TimeNs> recorded_;  ///< of the samples that wait for the clock to be judged
  TimeNs begun_ = 0;              ///< when the first was recorded
  StampClock clock_;
  bool clock_judged_ = false, enough_ = false;
};

/// States the rate of the IMU, and what a slow one means.
void note_imu_rate(std::span<const ImuSample> samples, SourceNotes& notes);

}  // namespace aslio::io
