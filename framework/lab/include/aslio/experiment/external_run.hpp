#pragma once
/// One run of a method that is not of this program, with the files that `aslio run` leaves, as far as they apply.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "aslio/evaluation/evaluation.hpp"
#include "aslio/experiment/dataset.hpp"
#include "aslio/experiment/external_method.hpp"
#include "aslio/pipeline/tracking.hpp"

namespace aslio::experiment {

struct ExternalOptions {
  ExternalMethod method;  ///< with absolute paths, as placed_in() makes them
  Dataset dataset;
  std::filesystem::path output;
  std::string data_name, sequence;  ///< for {data} and {sequence}
  std::uint64_t seed = 0;           ///< for {seed}
  std::vector<std::string> command_line;
};

/// What was measured.
struct ExternalSummary {
  pipeline::RunStatus status = pipeline::RunStatus::failed;
  std::string reason;
  bool bad_data = false;  ///< the status is due to what was read or could not be written
  double coverage = 0;    ///< share of the data's time with poses
  double data_s = 0, path_length_m = 0;
  std::size_t poses = 0;
  std::optional<double> cpu_s, wall_s,
      peak_rss_mb;  ///< of the program; nothing where there was none, or it is not seen
  std::optional<evaluation::Evaluation> evaluation;
  std::optional<double> end_to_end_m, failed_at;
  std::string evaluation_error;
  std::vector<std::string> notes;  ///< of the reader, the trajectory and the measuring
};

/// Reads the recording for its extent, writes it again where the method asks for that, runs the program in the output
/// folder, and measures the trajectory. Leaves trajectory.tum and trajectory_lidar.tum (poses of IMU and LiDAR),
/// program.log, resolved.yaml, manifest.json and, last, summary.json. A program that fails, hangs on after a stop or
/// writes nothing is a result with its reason. Throws ConfigError or DataError before it is started.
///
/// `stop`: asked now and then; true ends the program, and the run is `interrupted`.
ExternalSummary run_external(const ExternalOptions& options, const std::function<bool()>& stop);

/// summary.json as text: the keys of a run that apply.
std::string to_json(const ExternalSummary& summary);

}  // namespace aslio::experiment
