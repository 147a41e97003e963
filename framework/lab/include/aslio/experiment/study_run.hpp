#pragma once
/// Runs a study: every simulation and every run a child process of this program.

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "aslio/experiment/study.hpp"
#include "aslio/experiment/study_results.hpp"

namespace aslio::experiment {

struct StudyOptions {
  std::filesystem::path output;
  /// Simulated data, shared between studies; absent: inside `output`, and gone when they have served.
  std::optional<std::filesystem::path> data;
  int jobs = 1;  ///< child processes at once
  bool keep_data = false;
  bool retry = false;                    ///< failed and crashed runs, and those that met a limit, are made again
  std::string only;                      ///< glob of select_runs()
  std::string program;                   ///< identity of this program, for plan_runs()
  std::vector<std::string> run_options;  ///< further options of every run, as `--plugin FILE`
  /// This recording alone, without tables, beside others at work in `output`: a job of a cluster. Empty: all.
  std::string recording;
  /// Started for every simulation and every run, with the arguments of `aslio simulate` and `aslio run`.
  std::filesystem::path executable = "/proc/self/exe";  ///< the file that runs, even when it has been replaced since
};

/// Where a study stands.
struct StudyProgress {
  /// A run, a simulation, or a task of a cluster.
  struct Active {
    std::string name;    ///< "indoor_1_3/as_lio_plus", "indoor_1_4: simulation"
    double since_s = 0;  ///< it began
  };
  std::size_t total = 0, done = 0, failed = 0;  ///< runs of this call
  std::optional<double> left_s;                 ///< by the pace so far
  std::vector<Active> active;
};

/// How a study talks to whoever started it.
class StudyMonitor {
 public:
  virtual ~StudyMonitor() = default;
  virtual void on_line(const std::string& line) = 0;
  /// Some times a second while it is at work.
  virtual void on_progress(const StudyProgress& /*progress*/) {}
  /// True ends the children and the study; what is finished stays.
  virtual bool stop_requested() = 0;
};

struct StudyResult {
  std::vector<StudyRun> runs;
  std::vector<std::optional<StudyRow>> rows;  ///< by run; nothing where it has not been made
  bool interrupted = false;

  std::size_t failures() const;
};

/// Whether a call with these options keeps an earlier outcome.
bool stands(const StudyOutcome& outcome, const Study& study, const StudyOptions& options);

/// By run: its row stands, and so do those of the runs whose files it reads, which ended by themselves.
std::vector<bool> standing_runs(const Study& study, const StudyOptions& options, const std::vector<StudyRun>& runs,
                                const std::vector<std::optional<StudyRow>>& rows);

/// What an earlier call with the same data, configuration and program has left in `output`. Rows whose outcome does
/// not stand are made again. `recording`: of this one alone, unless empty.
std::vector<std::optional<StudyRow>> rows_so_far(const Study& study, const std::vector<StudyRun>& runs,
                                                 const std::filesystem::path& output,
                                                 const std::string& recording = {});

/// Makes the runs that are not finished, writes results.csv, statistics.csv, study.json and table.md whenever the runs
/// over a recording are done. A run that fails, crashes or exceeds a limit is a row. Throws ConfigError for an output
/// folder that cannot be used (another study is at work there), DataError when it cannot be written.
StudyResult run_study(const Study& study, const StudyOptions& options, StudyMonitor& monitor);

}  // namespace aslio::experiment
