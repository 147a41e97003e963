#include "aslio/pipeline/stage_set.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "aslio/core/thrown.hpp"

namespace aslio::pipeline {

namespace {

template <class S>
std::unique_ptr<S> build(const std::string& key, const config::Nested<S>& slot, const BuildContext& context) {
  try {
    return slot.make(context);
  } catch (const ConfigError& error) {
    throw StageError(key, fmt::format("{}: {}", key, error.what()));
  } catch (const DataError& error) {
    throw StageDataError(key, fmt::format("{}: {}", key, error.what()));
  } catch (...) {  // of a plugin: anything
    throw StageError(key, fmt::format("{}: stage '{}' cannot be made: {}", key, slot.type(), what_was_thrown()));
  }
}

SamplerChain build_chain(const std::vector<config::Nested<Sampler>>& members, const BuildContext& context) {
  std::vector<std::unique_ptr<Sampler>> chain;
  chain.reserve(members.size());
  for (std::size_t i = 0; i < members.size(); ++i) {
    chain.push_back(build(fmt::format("samplers.{}", i), members[i], context));
  }
  return SamplerChain(std::move(chain));
}

std::string content(const Map& map) { return map.content() == MapContent::surfaces ? "surfaces" : "points"; }

/// What an estimator takes, and what the stages before it give.
void require_input(const PipelineConfig& config, const StageSet& stages, bool has_samplers) {
  const std::string& estimator = config.estimator.type();
  if (stages.window && stages.window->gives_cuts() && !stages.estimator->uses_cuts()) {
    throw StageError("window", fmt::format("window: '{}' names parts of a window, and estimator '{}' does not use "
                                           "them: set imu_rate: emit: updates, or choose the estimator smoother",
                                           config.window.type(), estimator));
  }
  if (stages.window && stages.window->decides_by_imu() && !stages.estimator->uses_imu()) {
    throw StageError("window", fmt::format("window: '{}' decides by IMU data, and estimator '{}' uses none: choose "
                                           "another window, or an estimator that uses them",
                                           config.window.type(), estimator));
  }
  if (has_samplers && stages.estimator->uses_features() && !stages.samplers.gives_features()) {
    throw StageError("samplers",
                     fmt::format("samplers: none of them finds edges and planes, and estimator '{}' matches nothing "
                                 "else: add {{type: curvature_features}}, or choose another estimator",
                                 estimator));
  }
  if (stages.history && stages.history->gives_points() && !stages.estimator->uses_history()) {
    throw StageError("history", fmt::format("history: '{}' gives points of earlier updates, and estimator '{}' takes "
                                            "none: set history to {{type: none}}, or choose another estimator",
                                            config.history.type(), estimator));
  }
}

void require_features(const PipelineConfig& config, const SamplerChain& samplers) {
  const std::size_t lacking = samplers.first_without_features();
  if (lacking == samplers.size()) return;
  throw StageError(
      fmt::format("samplers.{}", lacking),
      fmt::format("samplers.{}: '{}' picks points by their class, and no sampler before it gives them one: "
                  "put {{type: curvature_features}} before it, or let it take all points",
                  lacking, config.samplers[lacking].type()));
}

void require_fit(const PipelineConfig& config, const StageSet& stages, bool has_samplers) {
  if (has_samplers) require_features(config, stages.samplers);
  if (stages.estimator) require_input(config, stages, has_samplers);
  if (!stages.map) return;
  if (stages.insertion && stages.insertion->needs_nearest_points() && stages.map->content() == MapContent::surfaces) {
    throw StageError("insertion",
                     fmt::format("insertion: '{}' asks the map for nearest points, and map '{}' holds surfaces: choose "
                                 "another insertion (on_new, on_exit, whole_window) or a map of points",
                                 config.insertion.type(), config.map.type()));
  }
  if (!stages.estimator || stages.map->content() == stages.estimator->map_content()) return;
  const bool surfaces = stages.map->content() == MapContent::surfaces;
  throw StageError("map", fmt::format("map: '{}' holds {}, and the residual of the estimator asks for {}: set "
                                      "estimator.residual.planes to '{}', or choose another map",
                                      config.map.type(), content(*stages.map), surfaces ? "points" : "surfaces",
                                      surfaces ? "map" : "neighbours"));
}

}  // namespace

StageSet build_stages(const PipelineConfig& config, const BuildContext& context,
                      std::span<const std::string> left_out) {
  const auto make = [&]<class S>(const std::string& key, const config::Nested<S>& slot) -> std::unique_ptr<S> {
    if (std::find(left_out.begin(), left_out.end(), key) != left_out.end()) return nullptr;
    return build(key, slot, context);
  };
  StageSet stages;
  stages.window = make("window", config.window);
  stages.overlap = make("overlap", config.overlap);
  stages.history = make("history", config.history);
  const bool has_samplers = std::find(left_out.begin(), left_out.end(), "samplers") == left_out.end();
  if (has_samplers) stages.samplers = build_chain(config.samplers, context);
  stages.map = make("map", config.map);
  stages.insertion = make("insertion", config.insertion);
  stages.estimator = make("estimator", config.estimator);
  require_fit(config, stages, has_samplers);
  return stages;
}

StageSet build_stages(const config::Loaded<PipelineConfig>& pipeline, const BuildContext& context,
                      std::span<const std::string> left_out) {
  const auto placed = [&](const auto& error) {
    return fmt::format("{}: {}", config::place_of(pipeline.tree, error.key()).text(), error.what());
  };
  try {
    return build_stages(pipeline.value, context, left_out);
  } catch (const StageError& error) {
    throw ConfigError(placed(error));
  } catch (const StageDataError& error) {
    throw DataError(placed(error));
  }
}

void check_stages(const config::Loaded<PipelineConfig>& pipeline, std::span<const std::string> left_out) {
  exec::Executor executor(1);
  SensorModel sensor;  // any: what its limits would exclude is for a run to say
  sensor.min_range = 0;
  sensor.max_range = 1e5;
  const BuildContext context{executor, sensor, std::make_shared<spdlog::logger>("check"), 0};
  try {
    build_stages(pipeline, context, left_out);
  } catch (const DataError& error) {
    throw ConfigError(error.what());  // nothing else was read
  }
}

}  // namespace aslio::pipeline
