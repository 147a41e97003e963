#pragma once
/// The stages of a pipeline, built and checked against each other.

#include <memory>
#include <span>
#include <string>

#include "aslio/config/load.hpp"
#include "aslio/core/errors.hpp"
#include "aslio/pipeline/odometry.hpp"

namespace aslio::pipeline {

/// A stage that cannot be built, or does not fit another one.
class StageError : public ConfigError {
 public:
  StageError(std::string key, const std::string& message) : ConfigError(message), key_(std::move(key)) {}
  /// Where the pipeline file names it: "map".
  const std::string& key() const { return key_; }

 private:
  std::string key_;
};

/// A file that a stage reads and cannot understand.
class StageDataError : public DataError {
 public:
  StageDataError(std::string key, const std::string& message) : DataError(message), key_(std::move(key)) {}
  const std::string& key() const { return key_; }

 private:
  std::string key_;
};

struct StageSet {
  std::unique_ptr<WindowStrategy> window;
  std::unique_ptr<OverlapMetric> overlap;
  std::unique_ptr<HistoryPolicy> history;
  SamplerChain samplers;
  std::unique_ptr<Map> map;
  std::unique_ptr<Insertion> insertion;
  std::unique_ptr<Estimator> estimator;
};

/// Builds every stage, but for those under the keys `left_out` (then null). Throws StageError when a stage refuses its
/// parameters or does not fit another, StageDataError.
StageSet build_stages(const PipelineConfig& config, const BuildContext& context,
                      std::span<const std::string> left_out = {});

/// The same; errors name the place in the file, or in the override, where the key was written, as ConfigError and
/// DataError.
StageSet build_stages(const config::Loaded<PipelineConfig>& pipeline, const BuildContext& context,
                      std::span<const std::string> left_out = {});

/// Builds the stages as a run does, and lets them go: throws ConfigError with file, line and key for what a run would
/// refuse before it reads data. Stages under the keys `left_out` read files that are made later.
void check_stages(const config::Loaded<PipelineConfig>& pipeline, std::span<const std::string> left_out = {});

}  // namespace aslio::pipeline
