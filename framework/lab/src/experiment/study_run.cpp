// What runs when: one loop that starts and watches child processes.
#include "aslio/experiment/study_run.hpp"

#include <fmt/format.h>
#include <poll.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>

#include "aslio/core/errors.hpp"
#include "aslio/experiment/study_status.hpp"
#include "manifest.hpp"
#include "run_outputs.hpp"
#include "study_arguments.hpp"
#include "study_files.hpp"
#include "study_judge.hpp"
#include "study_process.hpp"
#include "study_store.hpp"
#include "study_uses.hpp"

namespace aslio::experiment {

namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

constexpr int kLook = 50;                   // between looks at the children's memory and time [ms]
constexpr int kLookBlind = 5;               // the same where the kernel does not tell of a child's end [ms]
constexpr double kAsk = 0.2;                // between tries for a recording that another call is at work on [s]
constexpr double kShow = 0.2;               // between reports of progress [s]
constexpr double kGrace = 10;               // for children to end after Ctrl-C [s]
constexpr double kSimulationLimit = 86400;  // [s]
constexpr int kInterruptedExit = 130;       // of a child that has met Ctrl-C itself

double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

class Schedule {
 public:
  Schedule(const Study& study, const StudyOptions& options, StudyMonitor& monitor)
      : study_(study),
        options_(options),
        monitor_(monitor),
        runs_folder_(fs::absolute(options.output) / "runs"),
        store_(options.output, options.data, options.keep_data, asks_for(study, "world")),
        used_(study) {
    if (const auto note = require_same_study(study, options.output)) monitor_.on_line(*note);
    store_.remove_leftovers(options.recording);
    result_.runs = plan_runs(study, options.program, runs_folder_);
    const std::vector<bool> selected = select_runs(study, result_.runs, options.only);
    result_.rows = used_.rows(study, result_.runs, options.output, options.recording, selected);
    data_.resize(study.data.size());
    states_.resize(result_.runs.size(), RunState::skipped);
    const std::vector<bool> standing = standing_runs(study, options, result_.runs, result_.rows);
    for (std::size_t i = 0; i < result_.runs.size(); ++i) {
      if (standing[i]) {
        states_[i] = RunState::finished;
        kept_ += selected[i] ? 1 : 0;
      } else if (selected[i] && is_ours(result_.runs[i].data)) {
        states_[i] = RunState::waiting;
        result_.rows[i].reset();
        ++data_[result_.runs[i].data].left;
        ++total_;
      }
    }
    write_plan(study, result_.runs, options.jobs, options.output, !options.recording.empty());
  }

  StudyResult run() {
    write_tables();  // what is there already: those of an earlier call may be of other runs
    while (true) {
      if (!result_.interrupted && monitor_.stop_requested()) stop();
      reap();
      if (blocked_ && seconds_since(asked_) > kAsk) changed_ = true;
      // Only what has ended makes room, or makes a run possible.
      while (changed_ && !result_.interrupted && active_.size() < static_cast<std::size_t>(options_.jobs)) {
        changed_ = start_next();
      }
      if (active_.empty() && (!blocked_ || result_.interrupted)) break;
      show();
      wait();
    }
    write_tables();
    return std::move(result_);
  }

 private:
  enum class RunState : unsigned char { skipped, waiting, active, finished };
  enum class DataState : unsigned char { waiting, simulating, ready };
  struct DataProgress {
    DataState state = DataState::waiting;
    fs::path dataset;                ///< for `aslio run --dataset`
    std::size_t left = 0;            ///< runs that still need them
    std::optional<FolderLock> lock;  ///< of the folder of their runs
    bool told = false;               ///< that another call has it
  };
  /// A child: a run, or the simulation of data.
  struct Active {
    std::optional<std::size_t> run;
    std::size_t data = 0;
    fs::path folder, log;
    std::unique_ptr<ChildProcess> child;
    std::vector<std::string> command = {};  ///< of a run, with its final folder
    Clock::time_point begun = Clock::now();
  };

  /// Until a child ends, a signal comes, or it is time to look.
  void wait() {
    waited_.clear();
    for (const Active& active : active_) waited_.push_back({active.child->descriptor(), POLLIN, 0});
    const bool told = std::all_of(waited_.begin(), waited_.end(), [](const pollfd& child) { return child.fd >= 0; });
    ::poll(waited_.data(), waited_.size(), told ? kLook : kLookBlind);
  }

  /// A job of an executor works on one recording.
  bool is_ours(std::size_t data) const {
    return options_.recording.empty() || study_.data[data].name == options_.recording;
  }

  void stop() {
    result_.interrupted = true;
    stopped_ = Clock::now();
    for (const Active& active : active_) active.child->interrupt();
  }

  void reap() {
    const bool late = result_.interrupted && seconds_since(stopped_) > kGrace;
    for (std::size_t i = 0; i < active_.size();) {
      if (late) active_[i].child->kill();
      const auto end = active_[i].child->poll();
      if (!end) {
        ++i;
        continue;
      }
      changed_ = true;
      const Active ended = std::move(active_[i]);
      active_.erase(active_.begin() + static_cast<std::ptrdiff_t>(i));
      if (ended.run) {
        finish_run(ended, *end);
      } else {
        finish_simulation(ended, *end);
      }
    }
  }

  /// False: nothing can be started now.
  bool start_next() {
    for (std::size_t i = 0; i < states_.size(); ++i) {
      if (states_[i] != RunState::waiting || !can_start(result_.runs[i])) continue;
      if (const auto outcome = without_whole_files(result_, study_, i)) {
        leave_outcome(i, *outcome);
        close_run(i, StudyRow{.outcome = *outcome, .figures = {}});
      } else {
        start_run(i);
      }
      return true;
    }
    blocked_ = false;
    for (std::size_t d = 0; d < data_.size(); ++d) {
      if (data_[d].state != DataState::waiting || data_[d].left == 0) continue;
      if (take(d)) return data_[d].left == 0 || provide(d);
    }
    return false;
  }

  /// The runs over a recording are made by one call at a time: another may be at work on this one alone.
  bool take(std::size_t d) {
    DataProgress& data = data_[d];
    if (!options_.recording.empty() || data.lock) return true;  // run_study() has locked it
    const fs::path folder = runs_folder_ / study_.data[d].name;
    create_folder(folder);
    data.lock = FolderLock::take(folder, true);
    if (data.lock) {
      if (!data.lock->excludes()) monitor_.on_line(FolderLock::without_locks(folder));
      adopt(d);
      return true;
    }
    if (!data.told)
      monitor_.on_line(fmt::format("{}: another `aslio experiment` is at work on it; waiting", study_.data[d].name));
    data.told = blocked_ = true;
    asked_ = Clock::now();
    return false;
  }

  /// What another call has finished since this one looked.
  void adopt(std::size_t d) {
    for (std::size_t i = 0; i < result_.runs.size(); ++i) {
      StudyRun& run = result_.runs[i];
      if (run.data != d || states_[i] != RunState::waiting || !read_outcome(final_folder(i), {})) continue;
      run.key = run_key(study_, result_.runs, run, options_.program, runs_folder_);
      const auto outcome = used_.outcome(run, final_folder(i));
      if (outcome && stands(*outcome, study_, options_)) close_run(i, read_row(final_folder(i), *outcome));
    }
  }

  bool can_start(const StudyRun& run) const {
    return data_[run.data].state == DataState::ready &&
           std::none_of(run.uses.begin(), run.uses.end(), [&](std::size_t used) {
             return states_[used] == RunState::waiting || states_[used] == RunState::active;
           });
  }

  /// Data that are there are ready at once; others are simulated, unless as many as may be are there already.
  bool provide(std::size_t d) {
    const StudyData& data = study_.data[d];
    if (data.scene.empty()) {
      data_[d].dataset = data.dataset;
    } else if (const auto folder = store_.find(data)) {
      data_[d].dataset = *folder;
    } else {
      if (store_.made() > static_cast<std::size_t>(options_.jobs)) return false;
      start_simulation(d);
      return true;
    }
    data_[d].state = DataState::ready;
    return true;
  }

  void start_simulation(std::size_t d) {
    const StudyData& data = study_.data[d];
    require_unchanged(study_, data.texts);
    const fs::path folder = store_.begin(data), log = folder / "log.txt";
    const long share = ::sysconf(_SC_NPROCESSORS_ONLN) / options_.jobs;
    std::vector<std::string> arguments = {"simulate",  data.scene.string(),
                                          "--output",  folder.string(),
                                          "--seed",    fmt::to_string(*data.seed),
                                          "--scale",   fmt::to_string(data.scale),
                                          "--threads", fmt::to_string(std::clamp(share, 1L, 256L)),
                                          "--quiet"};
    for (const std::string& assignment : data.set) arguments.insert(arguments.end(), {"--set", assignment});
    if (asks_for(study_, "world")) arguments.insert(arguments.end(), {"--save-world", (folder / kWorldFile).string()});
    data_[d].state = DataState::simulating;
    active_.push_back({std::nullopt, d, folder, log, start(arguments, log, kSimulationLimit)});
  }

  /// A child has read `sources` by itself: what it made of other texts than the study's goes.
  void refuse_if_changed(const std::vector<fs::path>& sources, const std::function<void()>& remove) const {
    try {
      require_unchanged(study_, sources);
    } catch (const DataError&) {
      remove();
      throw;
    }
  }

  void finish_simulation(const Active& ended, const ChildEnd& end) {
    const StudyData& data = study_.data[ended.data];
    const bool whole = end.cause == ChildEnd::Cause::exit && end.code == 0;
    if (whole) {
      refuse_if_changed(data.texts, [&] { store_.abandon(data); });
      data_[ended.data].dataset = store_.commit(data, [this](const std::string& line) { monitor_.on_line(line); });
      data_[ended.data].state = DataState::ready;
      monitor_.on_line(fmt::format("{}: simulated in {:.1f} s", data.name, end.wall_s));
      return;
    }
    const std::string reason = end.cause == ChildEnd::Cause::memory_limit
                                   ? fmt::format("more than {:g} MB", study_.config.memory_limit)
                                   : exit_text(end, ended.log);
    store_.abandon(data);
    if (end.cause == ChildEnd::Cause::exit && end.code == kInterruptedExit && !result_.interrupted) stop();
    if (result_.interrupted) return;
    data_[ended.data].state = DataState::ready;
    for (std::size_t i = 0; i < result_.runs.size(); ++i) {
      if (result_.runs[i].data != ended.data || states_[i] != RunState::waiting) continue;
      StudyOutcome outcome{.status = "failed", .reason = "simulation: " + reason, .wall_s = end.wall_s, .final = false};
      leave_outcome(i, outcome);
      close_run(i, StudyRow{.outcome = std::move(outcome), .figures = {}});
    }
  }

  /// Of a run that could not begin: who asked for this recording alone reads it from its folder.
  void leave_outcome(std::size_t i, const StudyOutcome& outcome) const {
    const fs::path folder = final_folder(i);
    std::error_code error;
    fs::remove_all(folder, error);
    create_folder(folder);
    write_outcome(folder, result_.runs[i].key, outcome);
  }

  fs::path final_folder(std::size_t i) const {
    return runs_folder_ / study_.data[result_.runs[i].data].name / result_.runs[i].folder;
  }

  /// What a run reads by itself: pipeline, plugins, the files of a recording. The data of a scene are made already.
  std::vector<fs::path> sources_of(const StudyRun& run) const {
    std::vector<fs::path> files = study_.plugins;
    const StudyMethod& method = study_.methods[run.method];
    if (!method.external) files.push_back(method.pipeline);
    const StudyData& data = study_.data[run.data];
    if (data.scene.empty()) files.insert(files.end(), data.texts.begin(), data.texts.end());
    return files;
  }

  std::unique_ptr<ChildProcess> start(std::vector<std::string> arguments, const fs::path& log, double time_s) const {
    arguments.insert(arguments.begin(), "aslio");
    return std::make_unique<ChildProcess>(ChildCommand{.program = options_.executable,
                                                       .arguments = arguments,
                                                       .log = log,
                                                       .when_left = arguments[1] == "external" ? SIGTERM : SIGKILL},
                                          ChildProcess::Limits{time_s, study_.config.memory_limit});
  }

  void start_run(std::size_t i) {
    StudyRun& run = result_.runs[i];
    require_unchanged(study_, sources_of(run));
    // A file that its pipeline names may have come or changed since the runs were planned.
    run.key = run_key(study_, result_.runs, run, options_.program, runs_folder_);
    // Under another name until it is finished, so that nothing half-written is taken for a run.
    fs::path folder = final_folder(i);
    const std::string partial = fmt::format(".{}.partial-", run.folder);
    remove_leftovers(folder.parent_path(), partial);
    folder.replace_filename(partial + fmt::to_string(::getpid()));
    create_folder(folder);
    std::vector<std::string> arguments =
        run_arguments(study_, result_.runs, i, {data_[run.data].dataset, folder, runs_folder_}, options_.run_options);
    const fs::path log = folder / "log.txt";
    states_[i] = RunState::active;
    active_.push_back({i, run.data, folder, log, start(arguments, log, study_.config.time_limit)});
    for (std::string& word : arguments) name_finally(word, folder, final_folder(i));
    arguments.insert(arguments.begin(), "aslio");
    active_.back().command = std::move(arguments);
  }

  void finish_run(const Active& ended, const ChildEnd& end) {
    const std::size_t i = *ended.run;
    StudyOutcome outcome = judge_run(end, ended.folder, ended.log, study_.config);
    name_finally(outcome.reason, ended.folder, final_folder(i));
    std::error_code error;
    // Ended because we asked it to, or by the Ctrl-C that we shall hear of in a moment.
    if (outcome.status == "interrupted" || (result_.interrupted && !outcome.good())) {
      fs::remove_all(ended.folder, error);
      states_[i] = RunState::waiting;
      if (!result_.interrupted) stop();
      return;
    }
    refuse_if_changed(sources_of(result_.runs[i]), [&] { fs::remove_all(ended.folder, error); });
    remove_parts(ended.folder);
    fs::remove_all(ended.folder / ".input", error);  // of a program of others that was ended at a limit
    leave_manifest(ended, outcome);
    write_outcome(ended.folder, result_.runs[i].key, outcome);
    // The data go before the last run that needed them has its name: a study that is killed in between makes the run
    // again, and one killed the other way round would never ask for these data, nor remove them.
    if (data_[ended.data].left == 1) store_.release(study_.data[ended.data]);
    const fs::path folder = final_folder(i);
    fs::remove_all(folder, error);
    fs::rename(ended.folder, folder, error);
    if (error) throw DataError(fmt::format("{}: cannot be put there: {}", folder.string(), error.message()));
    close_run(i, read_row(folder, outcome));
  }

  /// A program of others may have done anything to its folder.
  void leave_manifest(const Active& ended, StudyOutcome& outcome) const {
    const fs::path manifest = ended.folder / "manifest.json";
    const std::string program = options_.program.substr(0, options_.program.find('\n'));
    const auto write = [&] {
      write_file(manifest, study_manifest(read_text(manifest), study_.data[ended.data], ended.command, program));
    };
    try {
      write();
    } catch (const std::exception& error) {
      if (!study_.methods[result_.runs[*ended.run].method].external) throw;
      outcome = {.status = "failed", .reason = fmt::format("the program has spoilt its folder: {}", error.what())};
      std::error_code ignored;
      fs::remove_all(ended.folder, ignored);
      create_folder(ended.folder);
      write();
    }
  }

  void close_run(std::size_t i, StudyRow row) {
    states_[i] = RunState::finished;
    result_.rows[i] = std::move(row);
    ++done_;
    tell(i);
    const std::size_t d = result_.runs[i].data;
    if (--data_[d].left > 0) return;
    store_.release(study_.data[d]);
    data_[d].lock.reset();
    // Tables of many runs take a while: at most a hundredth of the time goes there.
    if (seconds_since(written_) > 100 * writing_s_) write_tables();
  }

  /// By the pace of this call.
  std::optional<double> left_s() const {
    if (done_ == 0 || done_ >= total_) return std::nullopt;
    return seconds_since(start_) / static_cast<double>(done_) * static_cast<double>(total_ - done_);
  }

  void show() {
    if (seconds_since(shown_) < kShow) return;
    shown_ = Clock::now();
    StudyProgress progress{
        .total = kept_ + total_, .done = kept_ + done_, .failed = failed_, .left_s = left_s(), .active = {}};
    for (const Active& active : active_) {
      const std::string& data = study_.data[active.data].name;
      progress.active.push_back({active.run ? data + "/" + result_.runs[*active.run].folder : data + ": simulation",
                                 seconds_since(active.begun)});
    }
    monitor_.on_progress(progress);
  }

  /// "[3/90] indoor_1_3/as_lio_plus: ok, ate_m 0.0312, 14.2 s; 0:14:20 left".
  void tell(std::size_t i) {
    const StudyRow& row = *result_.rows[i];
    std::string line = fmt::format("[{}/{}] {}/{}: {}", kept_ + done_, kept_ + total_,
                                   study_.data[result_.runs[i].data].name, result_.runs[i].folder, row.outcome.status);
    if (!row.good()) line += fmt::format(" ({})", row.outcome.reason);
    const std::string& metric = study_.config.metrics.front();
    if (const auto value = row.figure(metric)) line += fmt::format(", {} {:.4g}", metric, *value);
    line += fmt::format(", {:.1f} s", row.outcome.wall_s);
    const long s = std::lround(left_s().value_or(0));
    if (s > 0) line += fmt::format("; {}:{:02}:{:02} left", s / 3600, s / 60 % 60, s % 60);
    failed_ += row.good() ? 0 : 1;
    if (failed_ > 0) line += fmt::format("; {} failed", failed_);
    monitor_.on_line(line);
  }

  void write_tables() {
    if (!options_.recording.empty()) return;  // others are at work on the rest
    const auto begin = Clock::now();
    write_study_tables(study_, result_.runs, result_.rows, options_.output);
    written_ = Clock::now();
    writing_s_ = seconds_since(begin);
  }

  const Study& study_;
  const StudyOptions& options_;
  StudyMonitor& monitor_;
  fs::path runs_folder_;
  StudyStore store_;
  UsedFiles used_;
  StudyResult result_;
  std::vector<DataProgress> data_;
  std::vector<RunState> states_;
  std::vector<Active> active_;
  std::vector<pollfd> waited_;
  std::size_t kept_ = 0, total_ = 0, done_ = 0, failed_ = 0;  ///< runs finished before; of this call
  bool changed_ = true;                                       ///< since the last look for something to start
  bool blocked_ = false;                                      ///< another call is at work on what could be started
  Clock::time_point start_ = Clock::now(), stopped_, written_, shown_, asked_;
  double writing_s_ = 0;  ///< the tables took so long last time
};

}  // namespace

std::size_t StudyResult::failures() const {
  return static_cast<std::size_t>(
      std::count_if(rows.begin(), rows.end(), [](const auto& row) { return row && !row->good(); }));
}

std::vector<std::optional<StudyRow>> rows_so_far(const Study& study, const std::vector<StudyRun>& runs,
                                                 const fs::path& output, const std::string& recording) {
  return UsedFiles(study).rows(study, runs, output, recording, std::vector<bool>(runs.size(), true));
}

StudyResult run_study(const Study& study, const StudyOptions& options, StudyMonitor& monitor) {
  require_selection(study, options.only);
  std::error_code error;
  fs::create_directories(options.output, error);
  if (!fs::is_directory(options.output)) {
    throw ConfigError(fmt::format("--output {}: {}; name a folder that exists or can be created",
                                  options.output.string(), error ? error.message() : "it is not a folder"));
  }
  fs::path locked = options.output;
  if (!options.recording.empty()) {
    locked = options.output / "runs" / options.recording;
    create_folder(locked);
  }
  const FolderLock lock = FolderLock::of_output(locked, options.output);
  return Schedule(study, options, monitor).run();
}

}  // namespace aslio::experiment
