#pragma once
/// manifest.json: everything needed to make a run again, and to know what was run.

#include <string>
#include <vector>

#include "aslio/experiment/run.hpp"

namespace aslio::experiment {

struct Manifest {
  std::string input_sha256, pipeline_sha256, sensor_sha256;
  double input_hash_s = 0;          ///< wall-clock time it took; not part of the run's cpu_s
  std::string sensor_resolved;      ///< YAML
  std::vector<std::string> stages;  ///< "family/type" in use
};

std::string to_json(const Manifest& manifest, const RunOptions& options);

}  // namespace aslio::experiment
