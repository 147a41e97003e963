#pragma once
/// The noise of ranges that a run sees, and what follows from it (docs/equations.md NOI-1, NOI-2).

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "aslio/config/binder.hpp"
#include "aslio/core/sensor.hpp"
#include "aslio/core/types.hpp"

namespace aslio::pipeline {

struct RangeNoiseParams {
  std::optional<double> tuned_for;  ///< [m]; nothing: the lengths of the stages are absolute
  bool adapt = true;

  static void describe(config::Binder& b, RangeNoiseParams& p);
};

/// Measures the noise of ranges from the points alone: neither map nor pose takes part, so that a map which refuses
/// noisy planes cannot hide their noise. Points that follow each other on a line of the scanner lie on a smooth curve
/// where the surface is smooth; what they scatter about it is noise. What differs from beam to beam is not seen. eq.
/// NOI-1. Same input, same bits; no allocation.
class RangeNoiseMeter {
 public:
  explicit RangeNoiseMeter(const SensorModel& sensor) : sensor_(sensor) {}

  /// Points in the order of time. Looks at one quarter of the time.
  void observe(std::span<const TimedPoint> points);
  /// Noise over that which the sensor file declares; nothing before enough was seen.
  std::optional<double> ratio() const;

 private:
  static constexpr std::size_t kGroup = 12, kLines = 256, kBins = 400;
  /// Points of one line that follow each other at an even pace.
  struct Run {
    TimeNs last = 0, step = 0;
    std::size_t count = 0;
    std::array<double, kGroup> range{};
  };

  void add(const TimedPoint& point);
  void judge(const std::array<double, kGroup>& range);
  void count(double ratio);

  SensorModel sensor_;
  std::array<Run, kLines> runs_{};
  std::array<std::uint32_t, kBins> histogram_{};  ///< of the logarithm of a group's scatter over the declared noise
  std::uint32_t groups_ = 0;
};

/// By how much the lengths of a pipeline that are about the noise of points are to grow: what the sensor file declares
/// over what they were chosen for, and what is seen over what is declared where the two differ clearly. Goes in steps.
/// eq. NOI-2.
class RangeNoise {
 public:
  RangeNoise(const RangeNoiseParams& params, const SensorModel& sensor);

  void observe(std::span<const TimedPoint> points);
  /// Exactly 1 for a pipeline that names no noise, and for noise as declared where that is what it was chosen for.
  double scale() const { return declared_ * seen_; }
  /// One standard deviation [m], at a range of which the sensor file's growth adds nothing.
  std::optional<double> range_sigma_seen() const;

 private:
  RangeNoiseParams params_;
  double range_sigma_, declared_, seen_ = 1;
  RangeNoiseMeter meter_;
};

}  // namespace aslio::pipeline
