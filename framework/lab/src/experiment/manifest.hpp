#pragma once
/// manifest.json: everything needed to make a run again, and to know what was run.

#include <array>
#include <string>
#include <vector>

#include "aslio/experiment/run.hpp"
#include "aslio/experiment/study.hpp"

namespace aslio::experiment {

/// Processes that ran or waited on this machine, mean over 1, 5 and 15 minutes; negative where it does not tell.
std::array<double, 3> machine_load();

struct Manifest {
  std::string input_sha256, pipeline_sha256, sensor_sha256;
  std::string reference_resolved;   ///< the keys of that file, as resolved_text()
  std::string reference_sha256;     ///< of the file that measured the run; empty without one
  double input_hash_s = 0;          ///< wall-clock time it took; not part of the run's cpu_s
  std::string sensor_resolved;      ///< YAML
  std::vector<std::string> stages;  ///< "family/type" in use
  std::string program_sha256;
  std::array<double, 3> load_average = machine_load();  ///< before the run
};

std::string to_json(const Manifest& manifest, const RunOptions& options);

/// The manifest of a run of a study. `text`: what the run has written of itself, or nothing when it did not come so
/// far. `command`: with its final folder. `program`: SHA-256.
std::string study_manifest(const std::string& text, const StudyData& data, const std::vector<std::string>& command,
                           const std::string& program);

}  // namespace aslio::experiment
