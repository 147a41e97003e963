#pragma once
/// One run: a pipeline over a recording, with everything it leaves in its output folder (docs/cli.md).

#include <spdlog/logger.h>

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "aslio/experiment/dataset.hpp"
#include "aslio/experiment/summary.hpp"
#include "aslio/io/reference.hpp"
#include "aslio/io/source.hpp"
#include "aslio/plugin/registry.hpp"

namespace aslio::experiment {

/// A shared object whose stages the catalog holds.
struct PluginFile {
  std::filesystem::path path;
  std::string sha256;
};

struct RunOptions {
  std::filesystem::path pipeline;
  std::vector<std::string> overrides;  ///< `key.path=value`, in order
  std::filesystem::path input, sensor, output;
  std::vector<std::filesystem::path> more_inputs;  ///< that are one recording with `input`
  int threads = 1;
  io::Section section;
  std::optional<std::filesystem::path> dataset;   ///< the file that named input, sensor or reference; for the manifest
  std::optional<PublishedSequence> published;     ///< that the input is; for the manifest, and to compare counts
  std::optional<io::ReferenceSpec> reference;     ///< fills Summary::evaluation
  std::optional<std::filesystem::path> save_map;  ///< .ply or .pcd
  bool closed_loop = false;                       ///< else Summary::end_to_end_m would be no error, and is left out
  bool dense = false;                             ///< also trajectory_dense.tum
  bool stop_when_diverged = false;                ///< by its own word, or from the reference
  std::uint64_t order_seed = 0;                   ///< BuildContext::order_seed
  std::vector<PluginFile> plugins;
  std::vector<std::string> command_line;  ///< for the manifest
  /// Opens the input in place of io::open_source(), for data that are in no file (tools/soak); `input` is then a name,
  /// and has no digest.
  std::function<std::unique_ptr<io::MeasurementSource>(const io::SensorConfig&)> open_input = {};

  /// `input` and `more_inputs`.
  std::vector<std::filesystem::path> inputs() const {
    std::vector<std::filesystem::path> all{input};
    all.insert(all.end(), more_inputs.begin(), more_inputs.end());
    return all;
  }
};

/// Where a run stands.
struct Progress {
  double data_s = 0;                 ///< data time since the first point
  std::optional<double> duration_s;  ///< of the whole input, where known
  double wall_s = 0;
  std::optional<double> overlap;  ///< of the last update
  double rate_hz = 0;             ///< of the last whole window
};

/// How a run talks to whoever started it. Called from the thread of run().
class RunMonitor {
 public:
  virtual ~RunMonitor() = default;
  /// Everything has been checked and the first measurement is about to be read.
  virtual void on_start(const io::SourceNotes& notes) = 0;
  virtual void on_progress(const Progress& progress) = 0;
  /// Something to know about the pipeline: before on_start().
  virtual void on_notice(const std::string& /*notice*/) {}
  /// Asked between measurements: true ends the run with status `interrupted`.
  virtual bool stop_requested() = 0;
};

struct RunResult {
  Summary summary;
  bool bad_data = false;                   ///< the status is due to what was read or could not be written
  std::vector<std::string> late_warnings;  ///< of the input, found after RunMonitor::on_start()
};

/// Runs and writes all files of `options.output`, each of which appears whole or not at all and replaces that of an
/// earlier run; the results of that are removed first, and summary.json is written last. What fails in the middle is in
/// the result, and what there is has been written. Throws before any data is read: ConfigError for a configuration,
/// option or output folder that cannot be used or would overwrite an input, DataError for an input (which leaves a
/// summary.json that says so) or a reference that cannot.
RunResult run(const RunOptions& options, const plugin::Catalog& catalog, RunMonitor& monitor,
              std::shared_ptr<spdlog::logger> log);

}  // namespace aslio::experiment
