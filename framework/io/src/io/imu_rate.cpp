#include "imu_rate.hpp"

#include <fmt/format.h>

#include <utility>

namespace aslio::io {

bool ImuBeginning::add(const ImuSample& sample, TimeNs recorded) {
  if (enough_) return false;
  if (clock_judged_ && clock_.far_off(sample.t, recorded)) {
    enough_ = recorded > begun_ + 2 * kJudgedImuSpan;  // the clock has been set
  } else if (clock_judged_) {
    take(sample, recorded);
  } else {
    wait(sample, recorded);
  }
  return !enough_;
}

void ImuBeginning::wait(const ImuSample& sample, TimeNs recorded) {
  constexpr std::size_t kMaxWaiting = 4000;  // where the times of recording do not go on
  if (samples_.empty()) begun_ = recorded;
  clock_.add(sample.t, recorded);
  samples_.push_back(sample);
  recorded_.push_back(recorded);
  if (recorded - begun_ > kJudgedImuSpan || recorded_.size() >= kMaxWaiting) judge_clock();
}

void ImuBeginning::finish() {
  if (!clock_judged_) judge_clock();
}

void ImuBeginning::judge_clock() {
  clock_judged_ = true;
  clock_.judge();
  const std::vector<ImuSample> waiting = std::exchange(samples_, {});
  for (std::size_t i = 0; i < waiting.size() && !enough_; ++i) {
    if (!clock_.far_off(waiting[i].t, recorded_[i])) take(waiting[i], recorded_[i]);
  }
  recorded_.clear();
}

void ImuBeginning::take(const ImuSample& sample, TimeNs recorded) {
  const TimeNs end = samples_.empty() ? kTimeMax : samples_.front().t + kJudgedImuSpan;
  // A single stamp that is ahead, though not far, ends nothing.
  if (sample.t > end && clock_.offset() && recorded + *clock_.offset() < end - kSecond / 2) return;
  samples_.push_back(sample);
  enough_ = samples_.size() >= kJudgedImuSamples || sample.t > end;
}

void note_imu_rate(std::span<const ImuSample> samples, SourceNotes& notes) {
  constexpr double kSlow = 50.0;  // Hz
  if (samples.size() < 2 || samples.back().t <= samples.front().t) return;
  const double rate = static_cast<double>(samples.size() - 1) / to_seconds(samples.back().t - samples.front().t);
  if (rate >= kSlow) {
    notes.verdicts.push_back(fmt::format("imu rate: {:.1f} Hz", rate));
  } else {
    notes.verdicts.push_back(fmt::format("imu rate: IMU at {:.1f} Hz: interpolated between its samples", rate));
    notes.warnings.push_back(fmt::format(
        "the IMU gives only {:.1f} samples per second: motion between them is interpolated, not measured", rate));
  }
}

}  // namespace aslio::io
