#pragma once
/// The odometry loop. It reads like docs/architecture.md, section "The loop", and like the paper.

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "aslio/pipeline/initialiser.hpp"
#include "aslio/pipeline/tracking.hpp"
#include "aslio/pipeline/update_record.hpp"
#include "aslio/stages/insertion.hpp"
#include "aslio/stages/overlap.hpp"
#include "aslio/stream/measurement_stream.hpp"

namespace aslio::pipeline {

/// A pipeline file (`schema: aslio/pipeline/1`): which stages, with which parameters.
struct PipelineConfig {
  config::Nested<WindowStrategy> window;
  config::Nested<OverlapMetric> overlap;
  config::Nested<HistoryPolicy> history;
  std::vector<config::Nested<Sampler>> samplers;
  config::Nested<Map> map;
  config::Nested<Insertion> insertion;
  config::Nested<Estimator> estimator;
  InitialisationParams initialisation;
  double max_speed = 30.0;   ///< [m/s], beyond it the run has diverged
  double max_silence = 1.0;  ///< [s] without an accepted update, beyond it the run has diverged

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
  /// Takes a measurement and runs every update that has become possible.
  void push(Measurement&& measurement);
  /// The source has ended: runs what is left.
  void finish();

  const std::optional<Divergence>& divergence() const;
  TrackingStatus tracking() const;
  /// Nothing before the first state has been found.
  const std::optional<Initialisation>& initialisation() const;
  const stream::MeasurementStream& stream() const;
  const Map& map() const;
  const OverlapMetric& overlap() const;

 private:
  class Loop;
  std::unique_ptr<Loop> loop_;
};

}  // namespace aslio::pipeline
