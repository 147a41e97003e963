#pragma once
/// The odometry loop. It reads like docs/architecture.md, section "The loop", and like the paper.

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "aslio/pipeline/initialiser.hpp"
#include "aslio/pipeline/range_noise.hpp"
#include "aslio/pipeline/tracking.hpp"
#include "aslio/pipeline/update_record.hpp"
#include "aslio/stages/insertion.hpp"
#include "aslio/stages/overlap.hpp"
#include "aslio/stream/measurement_stream.hpp"

namespace aslio::pipeline {

/// A pipeline file (`schema: aslio/pipeline/1`): which stages, with which parameters.
struct PipelineConfig {
  /// What becomes of a run that is lost.
  enum class WhenLost : std::uint8_t { restart, end };

  config::Nested<WindowStrategy> window;
  config::Nested<OverlapMetric> overlap;
  config::Nested<HistoryPolicy> history;
  std::vector<config::Nested<Sampler>> samplers;
  config::Nested<Map> map;
  config::Nested<Insertion> insertion;
  config::Nested<Estimator> estimator;
  InitialisationParams initialisation;
  RangeNoiseParams range_noise;
  TrackingLimits limits;
  WhenLost when_lost = WhenLost::restart;

  static void describe(config::Binder& b, PipelineConfig& p);
};

struct StageSet;  // pipeline/stage_set.hpp

class Odometry {
 public:
  Odometry(const PipelineConfig& config, const BuildContext& context);
  /// Takes stages that have been built from `config`.
  Odometry(const PipelineConfig& config, const BuildContext& context, StageSet stages);
  ~Odometry();

  void add_observer(UpdateObserver& observer);
  /// Takes a measurement and runs every update that has become possible. Nothing once has_ended().
  void push(Measurement&& measurement);
  /// The source has ended: runs what is left.
  void finish();

  /// The first loss, or nullptr. A run that was lost has diverged, also when it has started again.
  const Divergence* divergence() const;
  /// All of them, in the order of time.
  const std::vector<Divergence>& losses() const;
  /// Lost for good: no update will follow, whatever is pushed.
  bool has_ended() const;
  TrackingStatus tracking() const;
  /// What the monitor has seen so far.
  const MonitorReport& monitor() const;
  /// Of the first start. Nothing before its state has been found.
  const std::optional<Initialisation>& initialisation() const;
  const stream::MeasurementStream& stream() const;
  /// Valid until the next push(): a run that starts again has other stages.
  const Map& map() const;
  const OverlapMetric& overlap() const;
  /// Of the whole run, losses included.
  const RangeNoise& range_noise() const;

 private:
  class Pipeline;
  std::unique_ptr<Pipeline> pipeline_;
};

}  // namespace aslio::pipeline
