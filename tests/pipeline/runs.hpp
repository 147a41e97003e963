#pragma once
/// Pipelines under test: recordings in memory, the shipped configurations, and a run that keeps what observers see.

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "aslio/config/override.hpp"
#include "aslio/core/trajectory.hpp"
#include "aslio/io/source.hpp"
#include "aslio/pipeline/odometry.hpp"
#include "aslio/plugin/registry.hpp"
#include "plugins/build_environment.hpp"

namespace aslio::test {

using Recording = std::vector<Measurement>;

/// All measurements up to data time `until`.
Recording record(io::MeasurementSource& source, TimeNs until = kTimeMax);

/// The same points in packets of `period` [ns], each packet where its last point would have been complete.
Recording repacked(const Recording& recording, TimeNs period);

/// The stages of the library.
const plugin::Catalog& built_in_stages();

/// configs/pipelines/<name>.yaml with `overrides` ("history.rho=0").
pipeline::PipelineConfig shipped(const std::string& name, const std::vector<std::string>& overrides = {},
                                 const config::StageLookup& stages = built_in_stages());

/// A run of one pipeline; keeps a copy of every record (without the pointer into the estimator).
class Run final : public pipeline::UpdateObserver {
 public:
  Run(const pipeline::PipelineConfig& config, const SensorModel& sensor, int threads = 1);

  /// As the command does: nothing is pushed once the run has ended.
  void push(const Measurement& measurement);
  void finish() { odometry.finish(); }
  /// Pushes everything and finishes.
  Run& play(const Recording& recording);

  void on_update(const pipeline::UpdateRecord& record) override;

  std::vector<std::uint64_t> digests() const;
  /// Poses at the ends of the updates.
  Trajectory trajectory() const;
  /// Updates per second over the updates that end within (begin, end].
  double rate(TimeNs begin, TimeNs end) const;
  std::size_t count(UpdateStatus status) const;
  /// The first update after the run had begun anew `segment` times. Pre: there is one.
  const pipeline::UpdateRecord& first_of(std::uint32_t segment) const;
  /// Distance [m] and angle [rad] of the last pose from the truth, in the frame of first_of(segment).
  std::pair<double, double> error_at_end(const std::function<Pose(TimeNs)>& truth, std::uint32_t segment = 0) const;

  std::vector<pipeline::UpdateRecord> updates;
  StateMatrix P = StateMatrix::Zero();  ///< of the last update

 private:
  SensorModel sensor_;
  exec::Executor exec_;

 public:
  pipeline::Odometry odometry;
};

}  // namespace aslio::test
