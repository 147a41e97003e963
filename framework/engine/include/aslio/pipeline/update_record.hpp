#pragma once

#include <cstdint>
#include <string_view>

#include "aslio/pipeline/monitor.hpp"
#include "aslio/stages/estimator.hpp"

namespace aslio::pipeline {

enum class TrackingStatus : std::uint8_t { initialising, ok, degraded, lost, recovering };
enum class RunStatus : std::uint8_t { ok, degraded, truncated, interrupted, diverged, failed };

std::string_view name(UpdateStatus status);
std::string_view name(TrackingStatus status);
std::string_view name(RunStatus status);

/// Digest of the bits of a state: equal iff (but for collisions) the states are bit-identical.
std::uint64_t state_digest(const NavState& state);

/// Everything known of one update; what observers see and updates.csv / timings.csv hold.
struct UpdateRecord {
  WindowPlan plan;
  std::uint32_t sequence = 0;
  std::uint32_t segment = 0;  ///< number of earlier new starts of the run
  UpdateStatus status = UpdateStatus::initialising;
  TrackingStatus tracking = TrackingStatus::initialising;
  std::uint32_t n_fresh = 0;    ///< raw points in the fresh interval
  std::uint32_t n_history = 0;  ///< history points offered
  bool without_view = false;    ///< refused for want of points: of a message that was empty, say
  bool bridged = false;         ///< its points stood in for IMU readings that were missing or not believed (WID-1)
  bool bias_step = false;       ///< it showed that the gyro's bias had stepped (MOT-13)
  OverlapScore overlap;
  int iterations = 0;
  std::uint32_t n_matches = 0;  ///< accepted fresh and history residuals
  std::array<double, 6> spectrum{};
  double gyro_rms = 0;  ///< of the measured turn rate over the window's IMU samples [rad/s]; NaN without any
  double residual_rms = 0;
  InsertCount inserted;
  std::size_t map_points = 0;
  std::uint64_t digest = 0;  ///< of the bits of the posterior state
  NavState state;
  const Update* update = nullptr;  ///< valid during the observer's call only
  StageTimes times;                ///< thread CPU seconds
  MonitorSignals monitor;
};

/// Sees every update after it has been committed. Must not throw.
class UpdateObserver {
 public:
  virtual ~UpdateObserver() = default;
  virtual void on_update(const UpdateRecord& record) = 0;
};

}  // namespace aslio::pipeline
