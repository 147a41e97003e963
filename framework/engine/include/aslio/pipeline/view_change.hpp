#pragma once
/// How much of the view changes from one sweep to the next.

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "aslio/core/sensor.hpp"
#include "aslio/stages/estimator.hpp"

namespace aslio::pipeline {

/// Compares mean ranges in the same directions of W. A sensor that moves sees them change little by little; one that
/// was moved, or whose data were cut, sees most of them change at once (docs/equations.md MON-2). No allocation.
class ViewChange {
 public:
  explicit ViewChange(const SensorModel& sensor);

  /// Takes the raw points of a window that ends at `t`, with the attitude that `poses` gives them. The change, once a
  /// slot is full (a sweep, at least 0.1 s): mean over the directions seen in both slots of |ln(range / range before)|,
  /// each at most kMax. Nothing before, after a time without points, or where fewer than kMin directions are seen in
  /// both.
  std::optional<double> add(std::span<const TimedPoint> points, const TrajectoryModel& poses, TimeNs t);
  /// Whether a slot ended with the window that was added last.
  bool ended() const { return ended_; }
  /// What was seen is no longer before what comes.
  void forget();

 private:
  static constexpr int kSide = 32;                 ///< cells of the octahedral map per axis: 6 deg
  static constexpr std::size_t kMaxPoints = 2000;  ///< of a window
  static constexpr TimeNs kShortestSlot = kSecond / 10;
  static constexpr TimeNs kSlack = kSecond / 200;  ///< that a window may be shorter than a slot
  static constexpr TimeNs kPose = kSecond / 200;   ///< points of so long share an attitude
  static constexpr double kMax = 0.5;
  static constexpr int kMin = 20;
  struct Cell {
    float sum = 0;  ///< of ln(range)
    std::uint32_t n = 0;
  };
  std::optional<double> compare() const;

  SensorModel sensor_;
  TimeNs slot_;   ///< [ns]
  TimeNs blind_;  ///< after so long without points the view may have changed for good [ns]
  std::array<Cell, kSide * kSide> now_{}, before_{};
  TimeNs slot_begin_ = kTimeMin, last_point_ = kTimeMin;
  bool ended_ = false;
};

}  // namespace aslio::pipeline
