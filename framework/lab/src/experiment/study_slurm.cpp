// A study on a cluster: what is submitted, what has come of it, what is submitted again.
#include "aslio/experiment/study_slurm.hpp"

#include <fmt/format.h>
#include <poll.h>

#include <algorithm>
#include <chrono>
#include <deque>
#include <fstream>
#include <map>

#include "aslio/core/errors.hpp"
#include "aslio/experiment/study_status.hpp"
#include "slurm_queue.hpp"
#include "study_store.hpp"
#include "study_uses.hpp"

namespace aslio::experiment {

namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

constexpr std::size_t kLargestArray = 1000;  // Slurm's MaxArraySize is 1001 unless a site raises it
constexpr double kShowQueue = 0.5;           // between reports of progress [s]
constexpr int kLooksUntilLost = 2;           // without a trace: a shared disk shows files a little later

/// First complaint in the log of a task.
std::string complaint(const fs::path& log) {
  std::ifstream stream(log);
  for (std::string line; std::getline(stream, line);) {
    if (line.starts_with("error: ")) return line.substr(7);
  }
  return {};
}

/// Tells `aslio status` that somebody is at work. Gone at the end, also at that of an error, unless it is to be kept.
class Mark {
 public:
  explicit Mark(fs::path path) : path_(std::move(path)) { std::ofstream(path_) << "for `aslio status`\n"; }
  ~Mark() {
    std::error_code ignored;
    if (!kept_) fs::remove(path_, ignored);
  }
  Mark(const Mark&) = delete;
  Mark& operator=(const Mark&) = delete;
  void keep() { kept_ = true; }

 private:
  fs::path path_;
  bool kept_ = false;
};

class Cluster {
 public:
  Cluster(const Study& study, const StudyOptions& options, const SlurmOptions& slurm, StudyMonitor& monitor)
      : study_(study),
        options_(options),
        slurm_(slurm),
        monitor_(monitor),
        queue_(options.output / "slurm", slurm),
        used_(study) {
    const fs::path runs_folder = fs::absolute(options.output) / "runs";
    result_.runs = plan_runs(study, options.program, runs_folder);
    selected_ = select_runs(study, result_.runs, options.only);
    result_.rows = used_.rows(study, result_.runs, options.output, {}, selected_);
    if (const auto note = require_same_study(study, options.output)) monitor_.on_line(*note);
    write_plan(study, result_.runs, slurm.throttle * options.jobs, options.output);
    attempts_.assign(study.data.size(), 0);
    open_.resize(study.data.size());
    const std::vector<bool> standing = standing_runs(study, options, result_.runs, result_.rows);
    for (std::size_t i = 0; i < result_.runs.size(); ++i) {
      if (!selected_[i] || standing[i]) continue;
      open_[result_.runs[i].data].push_back(i);
      if (result_.rows[i]) refused_.emplace(i, marked_at(i));
      result_.rows[i].reset();
      ++total_;
    }
  }

  StudyResult run() {
    write_study_tables(study_, result_.runs, result_.rows, options_.output);
    adopt();
    for (std::size_t d = 0; d < open_.size(); ++d) {
      const bool in_queue = std::any_of(tasks_.begin(), tasks_.end(), [&](const Task& t) { return t.data == d; });
      if (!open_[d].empty() && !in_queue) waiting_.push_back(d);
    }
    for (const std::size_t d : waiting_) forget(d);
    Mark mark(options_.output / "slurm" / "waiting");
    while (!waiting_.empty() || !tasks_.empty()) {
      submit();
      if (!pause()) {
        result_.interrupted = true;
        break;
      }
      look();
    }
    // The tasks go on by themselves.
    if (result_.interrupted) mark.keep();
    write_study_tables(study_, result_.runs, result_.rows, options_.output);
    return std::move(result_);
  }

 private:
  struct Task {
    std::size_t data = 0;
    SlurmArray array;
    std::size_t index = 0;
    int unseen = 0;  ///< looks at the queue without it
    Clock::time_point since = Clock::now();
  };

  /// Tasks of an earlier call that are still there.
  void adopt() {
    const auto alive = queue_.alive();
    if (!alive) throw DataError("--executor slurm: Slurm's controller cannot be reached; call again when it can");
    if (alive->empty()) return;
    for (const SlurmArray& array : queue_.earlier()) {
      for (std::size_t k = 0; k < array.names.size(); ++k) {
        const auto data = std::find_if(study_.data.begin(), study_.data.end(),
                                       [&](const StudyData& d) { return d.name == array.names[k]; });
        if (data == study_.data.end() || alive->count(array.task(k)) == 0) continue;
        const auto d = static_cast<std::size_t>(data - study_.data.begin());
        if (!open_[d].empty()) tasks_.push_back({d, array, k});
      }
    }
    if (!tasks_.empty()) monitor_.on_line(fmt::format("{} tasks of an earlier call go on", tasks_.size()));
  }

  /// The marks of runs that are to be made again: what has one afterwards has been made.
  void forget(std::size_t d) {
    std::error_code ignored;
    for (const std::size_t i : open_[d]) {
      fs::remove(folder_of(i) / "run_key.json", ignored);
      refused_.erase(i);
    }
  }

  /// When the mark of a finished run was written.
  std::optional<fs::file_time_type> marked_at(std::size_t i) const {
    std::error_code error;
    const auto time = fs::last_write_time(folder_of(i) / "run_key.json", error);
    return error ? std::nullopt : std::optional(time);
  }

  fs::path folder_of(std::size_t i) const {
    return options_.output / "runs" / study_.data[result_.runs[i].data].name / result_.runs[i].folder;
  }

  void submit() {
    while (!waiting_.empty() && tasks_.size() < static_cast<std::size_t>(slurm_.throttle)) {
      const std::size_t count = std::min(waiting_.size(), kLargestArray);
      std::vector<std::string> names;
      for (std::size_t k = 0; k < count; ++k) names.push_back(study_.data[waiting_[k]].name);
      const auto array = queue_.submit(names, options_.jobs);
      if (!array) {
        tell_unreachable();
        return;
      }
      reachable_ = true;
      monitor_.on_line(fmt::format("job {}: {} recordings", array->job, count));
      for (std::size_t k = 0; k < count; ++k) tasks_.push_back({waiting_[k], *array, k});
      waiting_.erase(waiting_.begin(), waiting_.begin() + static_cast<std::ptrdiff_t>(count));
    }
  }

  void tell_unreachable() {
    if (reachable_) monitor_.on_line("Slurm's controller cannot be reached; waiting for it");
    reachable_ = false;
  }

  /// False: to be stopped.
  bool pause() {
    const auto begin = Clock::now();
    while (std::chrono::duration<double>(Clock::now() - begin).count() < slurm_.poll_s) {
      if (monitor_.stop_requested()) return false;
      show();
      ::poll(nullptr, 0, 50);
    }
    return !monitor_.stop_requested();
  }

  void show() {
    if (std::chrono::duration<double>(Clock::now() - shown_).count() < kShowQueue) return;
    shown_ = Clock::now();
    StudyProgress progress{.total = total_, .done = done_, .failed = failed_, .left_s = {}, .active = {}};
    const auto since = [](Clock::time_point then) {
      return std::chrono::duration<double>(Clock::now() - then).count();
    };
    if (done_ > 0 && done_ < total_) {
      progress.left_s = since(start_) / static_cast<double>(done_) * static_cast<double>(total_ - done_);
    }
    for (const Task& task : tasks_) {
      progress.active.push_back(
          {fmt::format("{}: task {}", study_.data[task.data].name, task.array.task(task.index)), since(task.since)});
    }
    monitor_.on_progress(progress);
  }

  void look() {
    const auto alive = queue_.alive();
    if (!alive) {
      tell_unreachable();
    } else {
      reachable_ = true;
    }
    for (std::size_t t = 0; t < tasks_.size();) {
      Task& task = tasks_[t];
      gather(task.data);
      const auto code = task.array.ended(task.index);
      if (!code && alive) task.unseen = alive->count(task.array.task(task.index)) > 0 ? 0 : task.unseen + 1;
      if (!code && task.unseen < kLooksUntilLost) {
        ++t;
        continue;
      }
      const Task ended = std::move(task);
      tasks_.erase(tasks_.begin() + static_cast<std::ptrdiff_t>(t));
      close(ended, code);
    }
  }

  /// Rows of the runs over these data that are there now.
  void gather(std::size_t d) {
    auto& open = open_[d];
    for (auto at = open.begin(); at != open.end();) {
      const std::size_t i = *at;
      StudyRun& run = result_.runs[i];
      // A file that its pipeline names may have come since the runs were planned.
      run.key = run_key(study_, result_.runs, run, options_.program, fs::absolute(options_.output) / "runs");
      const auto outcome = used_.outcome(run, folder_of(i));
      // A task of an earlier call may be at work on these data: what did not stand before it does not stand now.
      const auto refused = refused_.find(i);
      if (!outcome || (refused != refused_.end() && refused->second && refused->second == marked_at(i))) {
        ++at;
        continue;
      }
      result_.rows[i] = read_row(folder_of(i), *outcome);
      at = open.erase(at);
      tell(i);
    }
  }

  void tell(std::size_t i) {
    const StudyRow& row = *result_.rows[i];
    failed_ += row.good() ? 0 : 1;
    std::string line = fmt::format("[{}/{}] {}/{}: {}", ++done_, total_, study_.data[result_.runs[i].data].name,
                                   result_.runs[i].folder, row.outcome.status);
    if (!row.good()) line += fmt::format(" ({})", row.outcome.reason);
    line += fmt::format(", {:.1f} s", row.outcome.wall_s);
    if (failed_ > 0) line += fmt::format("; {} failed", failed_);
    monitor_.on_line(line);
  }

  /// A task that is gone: its runs are there, or it is submitted again, or they have failed.
  void close(const Task& task, std::optional<int> code) {
    gather(task.data);
    auto& open = open_[task.data];
    if (open.empty()) return;
    const std::string& name = study_.data[task.data].name;
    const std::string words = complaint(task.array.folder / fmt::format("log-{}.txt", task.index));
    std::string what = code ? fmt::format("its task ended with exit code {}", *code) : "its task was lost";
    if (!words.empty()) what += ": " + words;
    const bool adopted = std::any_of(open.begin(), open.end(), [this](std::size_t i) { return refused_.count(i) > 0; });
    if (adopted) forget(task.data);
    if (adopted || ++attempts_[task.data] < slurm_.attempts) {
      monitor_.on_line(fmt::format("{}: {}; submitted again", name, what));
      waiting_.push_back(task.data);
      return;
    }
    for (const std::size_t i : open) {
      StudyOutcome outcome{.status = "failed",
                           .reason = fmt::format("{} ({} times)", what, slurm_.attempts),
                           .wall_s = 0,
                           .final = false};
      result_.rows[i] = StudyRow{.outcome = std::move(outcome), .figures = {}};
      tell(i);
    }
    open.clear();
  }

  const Study& study_;
  const StudyOptions& options_;
  const SlurmOptions& slurm_;
  StudyMonitor& monitor_;
  SlurmQueue queue_;
  UsedFiles used_;
  StudyResult result_;
  std::vector<bool> selected_;
  std::vector<std::vector<std::size_t>> open_;  ///< runs to make, by data
  /// Of open runs that had an outcome which does not stand: when it was written.
  std::map<std::size_t, std::optional<fs::file_time_type>> refused_;
  std::vector<int> attempts_;        ///< by data
  std::deque<std::size_t> waiting_;  ///< data to be submitted
  std::vector<Task> tasks_;          ///< submitted
  std::size_t total_ = 0, done_ = 0, failed_ = 0;
  bool reachable_ = true;
  Clock::time_point start_ = Clock::now(), shown_;
};

}  // namespace

StudyResult run_study_on_slurm(const Study& study, const StudyOptions& options, const SlurmOptions& slurm,
                               StudyMonitor& monitor) {
  require_selection(study, options.only);
  std::error_code error;
  fs::create_directories(options.output, error);
  if (!fs::is_directory(options.output)) {
    throw ConfigError(fmt::format("--output {}: {}; name a folder that exists or can be created",
                                  options.output.string(), error ? error.message() : "it is not a folder"));
  }
  const FolderLock lock = FolderLock::of_output(options.output, options.output);
  return Cluster(study, options, slurm, monitor).run();
}

}  // namespace aslio::experiment
