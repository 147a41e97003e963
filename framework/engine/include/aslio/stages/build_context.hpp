#pragma once

#include <spdlog/logger.h>

#include <cstdint>
#include <memory>

#include "aslio/core/sensor.hpp"
#include "aslio/exec/executor.hpp"

namespace aslio {

/// What the pipeline gives to every stage it builds. The references outlive the stage.
struct BuildContext {
  exec::Executor& exec;
  const SensorModel& sensor;
  std::shared_ptr<spdlog::logger> log;
  /// Phase of strides; the pipeline moves the first window by it, too: replicates that should agree differ in it.
  std::uint64_t order_seed = 0;
  /// For a run that goes on after it was lost: the first data of the stage are not the first of the recording.
  bool anew = false;
};

}  // namespace aslio
