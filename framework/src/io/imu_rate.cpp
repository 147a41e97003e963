#include "imu_rate.hpp"

#include <fmt/format.h>

namespace aslio::io {

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
