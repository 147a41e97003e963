#include "aslio/experiment/study_status.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cmath>
#include <fstream>
#include <iterator>
#include <map>
#include <set>

#include "aslio/core/csv.hpp"
#include "aslio/core/errors.hpp"
#include "aslio/experiment/study_results.hpp"
#include "aslio/io/writers.hpp"
#include "aslio/statistics/order.hpp"
#include "folder_lock.hpp"
#include "study_files.hpp"

namespace aslio::experiment {

namespace {

namespace fs = std::filesystem;

constexpr const char* kPlanFile = "plan.csv";
constexpr std::size_t kShown = 20;  // lines of a list

std::size_t place_of(std::vector<std::string>& names, const std::string& name) {
  const auto at = std::find(names.begin(), names.end(), name);
  const auto index = static_cast<std::size_t>(at - names.begin());
  if (at == names.end()) names.push_back(name);
  return index;
}

/// Names of the runs begun and not finished in the folder of some data, with the time of their beginning.
std::map<std::string, fs::file_time_type> begun_in(const fs::path& folder) {
  constexpr std::string_view kPartial = ".partial-";
  std::map<std::string, fs::file_time_type> out;
  std::error_code error;
  for (auto at = fs::directory_iterator(folder, error); !error && at != fs::directory_iterator(); at.increment(error)) {
    const std::string name = at->path().filename().string();
    const std::size_t end = name.rfind(kPartial);
    if (name.front() != '.' || end == std::string::npos || !is_leftover(name, name.substr(0, end + kPartial.size()))) {
      continue;
    }
    const auto log = fs::last_write_time(at->path() / "log.txt", error);
    out.emplace(name.substr(1, end - 1), error ? fs::file_time_type::clock::now() : log);
    error.clear();
  }
  return out;
}

class StatusReader {
 public:
  explicit StatusReader(const fs::path& output)
      : output_(output), plan_(read_csv(output / kPlanFile)), planned_(fs::last_write_time(output / kPlanFile)) {}

  StudyStatus read() {
    status_.at_work = FolderLock::is_held(output_, true) || on_cluster();
    const std::size_t data = plan_.column("data"), sequence = plan_.column("sequence"), run = plan_.column("run"),
                      method = plan_.column("method"), key = plan_.column("key");
    for (const auto& row : plan_.rows) {
      if (row[data] != data_) look_into(output_ / "runs" / row[data]);
      data_ = row[data];
      const std::size_t s = place_of(status_.sequences, row[sequence]), m = place_of(status_.methods, row[method]);
      status_.cells.resize(status_.sequences.size());
      for (auto& cells : status_.cells) cells.resize(status_.methods.size());
      add(row[run], row[key], m, status_.cells[s][m]);
    }
    for (const auto& cells : status_.cells) {
      for (const RunCounts& c : cells) {
        status_.total.good += c.good;
        status_.total.failed += c.failed;
        status_.total.running += c.running;
        status_.total.waiting += c.waiting;
      }
    }
    status_.at_work |= recordings_at_work_;
    estimate();
    return std::move(status_);
  }

 private:
  /// A call with --recording holds the folder of its runs alone.
  void look_into(const fs::path& folder) {
    begun_ = begun_in(folder);
    held_ = status_.at_work || FolderLock::is_held(folder, false);
    recordings_at_work_ |= held_;
  }

  bool on_cluster() const {
    std::error_code ignored;
    return fs::exists(output_ / "slurm" / "waiting", ignored);
  }

  void add(const std::string& run, const std::string& key, std::size_t method, RunCounts& counts) {
    const std::string name = data_ + "/" + run;
    const auto begun = begun_.find(run);
    const bool running = begun != begun_.end() && held_;  // maybe again, beside an outcome that did not stand
    if (const auto outcome = running ? std::nullopt : finished(output_ / "runs" / data_ / run, key)) {
      StudyRow row;
      row.outcome = *outcome;
      ++(row.good() ? counts.good : counts.failed);
      if (!row.good()) status_.failures.push_back(fmt::format("{}: {} ({})", name, outcome->status, outcome->reason));
      times_[method].push_back(outcome->wall_s);
    } else if (running) {
      ++counts.running;
      const std::chrono::duration<double> since = fs::file_time_type::clock::now() - begun->second;
      status_.running.push_back(fmt::format("{}, for {:.0f} s", name, since.count()));
      ++left_[method];
    } else {
      ++counts.waiting;
      ++left_[method];
    }
  }

  /// Under the key of the plan; or of one made since, when a file that its pipeline names has come.
  std::optional<StudyOutcome> finished(const fs::path& folder, const std::string& key) const {
    if (auto outcome = read_outcome(folder, key)) return outcome;
    std::error_code error;
    const auto written = fs::last_write_time(folder / "run_key.json", error);
    return !error && written >= planned_ ? read_outcome(folder, {}) : std::nullopt;
  }

  void estimate() {
    std::vector<double> all;
    for (const auto& [method, times] : times_) all.insert(all.end(), times.begin(), times.end());
    if (all.empty() || left_.empty()) return;
    double sum = 0;
    for (const auto& [method, count] : left_) {
      const auto known = times_.find(method);
      const double each = *statistics::median(known != times_.end() ? known->second : all);
      sum += each * static_cast<double>(count);
    }
    int jobs = 1;
    if (!plan_.rows.empty()) {
      const std::string& cell = plan_.rows.front()[plan_.column("jobs")];
      std::from_chars(cell.data(), cell.data() + cell.size(), jobs);  // what is no number leaves one job
    }
    status_.left_s = sum / std::max(1, jobs);
  }

  fs::path output_;
  CsvTable plan_;
  fs::file_time_type planned_;
  StudyStatus status_;
  std::string data_;
  std::map<std::string, fs::file_time_type> begun_;
  bool held_ = false, recordings_at_work_ = false;
  std::map<std::size_t, std::vector<double>> times_;  ///< of finished runs, by method [s]
  std::map<std::size_t, std::size_t> left_;           ///< by method
};

std::string cell_text(const RunCounts& c) {
  std::string text = fmt::format("{}/{}", c.good + c.failed, c.all());
  if (c.running > 0) text += fmt::format(" {}r", c.running);
  if (c.failed > 0) text += fmt::format(" {}x", c.failed);
  return text;
}

std::string list(const std::string& title, const std::vector<std::string>& lines) {
  if (lines.empty()) return {};
  std::string text = "\n" + title + "\n";
  for (std::size_t i = 0; i < std::min(kShown, lines.size()); ++i) text += "  " + lines[i] + "\n";
  if (lines.size() > kShown) text += fmt::format("  and {} more\n", lines.size() - kShown);
  return text;
}

}  // namespace

void write_plan(const Study& study, const std::vector<StudyRun>& runs, int jobs, const fs::path& output, bool keep) {
  const auto text = [&](const std::string& at_once) {
    std::string all = "study,data,sequence,run,method,identity,key,scale,jobs\n";
    for (const StudyRun& run : runs) {
      const StudyData& data = study.data[run.data];
      all += fmt::format("{},{},{},{},{},{},{},{},{}\n", study.name, data.name, data.sequence, run.folder,
                         study.methods[run.method].name, data.identity, run.key, data.scale, at_once);
    }
    return all;
  };
  if (keep) {
    std::ifstream file(output / kPlanFile);
    const std::string there(std::istreambuf_iterator<char>(file), {}), last = there.substr(0, there.rfind('\n'));
    if (!there.empty() && there == text(last.substr(last.rfind(',') + 1))) return;
  }
  io::AtomicFile file(output / kPlanFile);
  file.write(text(fmt::to_string(jobs)));
  file.close();
}

std::optional<std::string> require_same_study(const Study& study, const fs::path& output) {
  std::error_code ignored;
  if (!fs::exists(output / kPlanFile, ignored)) return std::nullopt;
  const CsvTable plan = read_csv(output / kPlanFile);
  const auto& header = plan.header;
  if (plan.rows.empty() || std::find(header.begin(), header.end(), "study") == header.end()) return std::nullopt;
  const std::size_t name = plan.column("study"), data = plan.column("data"), scale = plan.column("scale");
  if (const std::string& there = plan.rows.front()[name]; there != study.name) {
    throw ConfigError(
        fmt::format("--output {}: holds the study '{}', and '{}' would be mixed with it: name another folder",
                    output.string(), there, study.name));
  }
  for (const auto& row : plan.rows) {
    for (const StudyData& now : study.data) {
      if (now.name != row[data] || now.scene.empty() || row[scale] == fmt::format("{}", now.scale)) continue;
      return fmt::format(
          "note: {} was made with --scale {}, and this call has {}: its scenes are simulated and run again",
          output.string(), row[scale], now.scale);
    }
  }
  return std::nullopt;
}

StudyStatus read_status(const fs::path& output) {
  std::error_code ignored;
  if (!fs::exists(output / kPlanFile, ignored)) {
    throw ConfigError(fmt::format("{}: holds no study (there is no {}); name the --output of `aslio experiment`",
                                  output.string(), kPlanFile));
  }
  return StatusReader(output).read();
}

std::string to_text(const StudyStatus& s) {
  std::size_t first = 8;
  std::vector<std::size_t> widths;
  for (const std::string& sequence : s.sequences) first = std::max(first, sequence.size());
  for (std::size_t m = 0; m < s.methods.size(); ++m) {
    widths.push_back(s.methods[m].size());
    for (const auto& cells : s.cells) widths[m] = std::max(widths[m], cell_text(cells[m]).size());
  }
  std::string text = fmt::format("{:<{}}", "sequence", first);
  const auto out = std::back_inserter(text);
  for (std::size_t m = 0; m < s.methods.size(); ++m) fmt::format_to(out, "  {:<{}}", s.methods[m], widths[m]);
  text += '\n';
  for (std::size_t q = 0; q < s.sequences.size(); ++q) {
    fmt::format_to(out, "{:<{}}", s.sequences[q], first);
    for (std::size_t m = 0; m < s.methods.size(); ++m)
      fmt::format_to(out, "  {:<{}}", cell_text(s.cells[q][m]), widths[m]);
    text += '\n';
  }
  fmt::format_to(out, "\n{} runs: {} finished, {} failed, {} running, {} waiting; {}\n", s.total.all(), s.total.good,
                 s.total.failed, s.total.running, s.total.waiting, s.at_work ? "at work" : "nobody is at work");
  if (s.left_s) {
    const auto left = std::lround(*s.left_s);
    fmt::format_to(out, "{}:{:02}:{:02} left, simulations not counted\n", left / 3600, left / 60 % 60, left % 60);
  }
  return text + list("running", s.running) + list("failed", s.failures);
}

}  // namespace aslio::experiment
