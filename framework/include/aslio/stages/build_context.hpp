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
  std::uint64_t order_seed =
      0;  ///< offset of the first window, phase of strides: replicates that should agree differ in it
};

}  // namespace aslio
