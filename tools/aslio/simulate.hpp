#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "aslio/simulator/simulation.hpp"

namespace aslio::cli {

struct SimulateArguments {
  std::string scene, output, sensor, world, format = "bag";
  std::string as;  ///< FAMILY/SEQUENCE; empty: a recording of the simulator's own
  std::vector<std::string> overrides;
  int threads = static_cast<int>(std::clamp(std::thread::hardware_concurrency(), 1U, 256U));
  std::uint64_t seed = simulator::SimulationOptions{}.seed;
  double scale = 1;
  std::int64_t parts = 1;
  std::optional<double> duration;  ///< [s]
  bool no_compression = false, quiet = false;
};

}  // namespace aslio::cli
