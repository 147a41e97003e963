/// A study whose runs go wrong in every way, and one that is killed itself. The runs are those of child_program.cpp.

#include <fcntl.h>
#include <signal.h>
#include <sys/file.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <chrono>
#include <functional>
#include <map>
#include <sstream>
#include <thread>

#include "aslio/core/errors.hpp"
#include "aslio/experiment/study_run.hpp"
#include "aslio/experiment/study_status.hpp"
#include "study_files.hpp"

using namespace aslio::test;
using namespace aslio::experiment;
using Catch::Matchers::Contains;

namespace fs = std::filesystem;

namespace {

StudyOptions options(const fs::path& output, int jobs = 2) {
  StudyOptions out;
  out.output = output;
  out.jobs = jobs;
  out.program = "program";
  out.executable = ASLIO_CHILD_PROGRAM;
  return out;
}

std::string methods(const std::vector<std::string>& names) {
  std::string text = "methods:\n";
  for (const std::string& name : names) text += method(name, "fixed_window");
  return text;
}

/// Runs the study in a process of its own, which is killed when `until` says so. Its exit code; 256 and the signal for
/// one that was killed.
int run_apart(const Study& study, const StudyOptions& how, const std::function<bool()>& until = nullptr,
              std::optional<rlim_t> file_size = std::nullopt) {
  const pid_t id = ::fork();
  if (id == 0) {
    if (file_size) {
      ::signal(SIGXFSZ, SIG_IGN);  // as the real program does
      const rlimit bound{*file_size, *file_size};
      ::setrlimit(RLIMIT_FSIZE, &bound);
    }
    int code = 0;
    try {
      Quiet monitor;
      code = run_study(study, how, monitor).failures() > 0 ? 1 : 0;
    } catch (const aslio::DataError&) {
      code = 3;
    } catch (...) {
      code = 99;  // must not get out: this is a copy of the whole test
    }
    ::_exit(code);
  }
  int status = 0;
  pid_t ended = 0;
  while (until && ended == 0 && !until()) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    ended = ::waitpid(id, &status, WNOHANG);
  }
  if (ended == 0) {
    if (until) ::kill(id, SIGKILL);
    ::waitpid(id, &status, 0);
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : 256 + WTERMSIG(status);
}

/// The tables of a study without what a clock or the kernel decides.
std::vector<std::string> tables(const fs::path& output) {
  std::vector<std::string> out = {content(output / "table.md"), content(output / "statistics.csv")};
  std::istringstream lines(content(output / "results.csv"));
  std::string line;
  std::getline(lines, line);
  std::istringstream names(line);
  std::vector<std::string> header;
  for (std::string name; std::getline(names, name, ',');) header.push_back(name);
  for (const std::string& name : header) {
    if (name == "cpu_s_per_s" || name == "peak_rss_mb") continue;
    for (const std::string& cell : column(output / "results.csv", name)) out.push_back(name + "=" + cell);
  }
  return out;
}

std::function<bool()> after(std::chrono::milliseconds limit) {
  return [end = std::chrono::steady_clock::now() + limit] { return std::chrono::steady_clock::now() >= end; };
}

/// Marks of finished runs.
std::vector<fs::path> finished_in(const fs::path& output) {
  std::vector<fs::path> out;
  std::error_code error;
  for (const char* data : {"scene_a_1", "scene_a_2", "scene_a_3"}) {
    for (const char* run : {"one", "two"}) {
      const fs::path mark = output / "runs" / data / run / "run_key.json";
      if (fs::exists(mark, error)) out.push_back(mark);
    }
  }
  return out;
}

std::string two_methods() {
  return head() + "datasets: [{scene: scene_a.yaml, seeds: 1-6}, {scene: scene_b.yaml, seeds: 1-6}]\n" +
         methods({"one", "two"}) + "baseline: one\nmetrics: [ate_m]\n";
}

}  // namespace

TEST_CASE("a run that goes wrong in any way is a row with its reason, and the study goes on") {
  const StudyFiles files;
  const std::vector<std::pair<std::string, std::string>> expected = {
      {"segv", "crashed: ended by signal 11 (Segmentation fault)"},
      {"hang", "timeout: longer than 5 s"},
      {"hoard", "memory: more than 200 MB"},
      {"not_a_number", "failed: its summary.json is none (exit code 0)"},
      {"garbage", "failed: its summary.json is none (exit code 0)"},
      {"unknown", "failed: its summary.json has the unknown status 'splendid'"},
      {"liar", "failed: its summary.json says ok, its exit code is 1"},
      {"degraded_liar", "failed: its summary.json says degraded, its exit code is 0"},
      {"unmeasured", "failed: it could not be measured: truth.tum:3: no number"},
      {"mute", "failed: exit code 1 without a complaint"},
      {"forks", "ok: "},
      {"good", "ok: "},
      {"degraded", "degraded: "}};
  std::vector<std::string> names;
  for (const auto& row : expected) names.push_back(row.first);
  const Study study = files.load(head() + "datasets: [{scene: scene_a.yaml}]\n" + methods(names) +
                                 "metrics: [ate_m]\ntime_limit: 5\nmemory_limit: 200\n");
  Quiet monitor;
  const StudyResult result = run_study(study, options(files.folder / "out"), monitor);
  CHECK(result.failures() == 10);
  for (std::size_t i = 0; i < expected.size(); ++i) {
    const StudyOutcome found = result.rows.at(i).value().outcome;
    CHECK(std::pair(expected[i].first, found.status + ": " + found.reason) == expected[i]);
  }
  const std::string table = content(files.folder / "out/table.md");
  CHECK_THAT(table, Contains("| x | x | x | x | x | x | x | 0.") && Contains("| scene_a_1 | liar | failed |"));
  // Nothing that a run has started outlives it.
  const pid_t left = std::stoi(content(files.folder / "out/runs/scene_a_1/forks/left_behind.txt"));
  for (int i = 0; i < 200 && ::kill(left, 0) == 0; ++i) std::this_thread::sleep_for(std::chrono::milliseconds(10));
  const std::string state = content("/proc/" + std::to_string(left) + "/stat");
  CHECK((state.empty() || state.find(") Z ") != std::string::npos));
}

TEST_CASE("a study that is killed ten times ends with the tables of one that was not") {
  const StudyFiles files;
  const Study study = files.load(two_methods());
  REQUIRE(run_apart(study, options(files.folder / "whole")) == 0);
  // 24 runs of 15 ms and 12 simulations on two at a time: some 250 ms in all.
  std::uint32_t random = 12345;
  int killed = 0;
  for (int i = 0; i < 10; ++i) {
    random = random * 1664525U + 1013904223U;
    const std::chrono::milliseconds limit(5 + (random >> 16U) % 40);
    killed += run_apart(study, options(files.folder / "killed"), after(limit)) == 256 + SIGKILL ? 1 : 0;
  }
  CHECK(killed == 10);
  REQUIRE(run_apart(study, options(files.folder / "killed")) == 0);
  CHECK(tables(files.folder / "killed") == tables(files.folder / "whole"));
  // Nothing is left of what was begun.
  for (const auto& entry : fs::recursive_directory_iterator(files.folder / "killed")) {
    INFO(entry.path());
    CHECK(entry.path().string().find(".partial-") == std::string::npos);
  }
  CHECK_FALSE(fs::exists(files.folder / "killed/simulated"));
}

TEST_CASE("data are gone before the last run that needed them is told as finished") {
  const StudyFiles files;
  const Study study = files.load(two_methods());

  /// Looks at what a kill at this very moment would leave for good: no later call asks for data without runs.
  class Looking final : public StudyMonitor {
   public:
    explicit Looking(fs::path output) : output_(std::move(output)) {}
    void on_line(const std::string& line) override {
      for (const StudyRun& run : runs) {
        if (line.find("] " + names[run.data] + "/" + run.folder + ": ok") == std::string::npos) continue;
        if (++told[names[run.data]] < 2) continue;
        ++looked;
        if (fs::exists(output_ / "simulated" / names[run.data])) ++left;
      }
    }
    bool stop_requested() override { return false; }
    std::vector<StudyRun> runs;
    std::vector<std::string> names;  ///< of the data
    std::map<std::string, int> told;
    int looked = 0, left = 0;

   private:
    fs::path output_;
  } looking(files.folder / "out");
  looking.runs = plan_runs(study, "program", fs::absolute(files.folder / "out") / "runs");
  for (const StudyData& data : study.data) looking.names.push_back(data.name);
  CHECK(run_study(study, options(files.folder / "out"), looking).failures() == 0);
  CHECK(looking.looked == 12);
  CHECK(looking.left == 0);
}

TEST_CASE("data that a kill left half removed go with the next call") {
  const StudyFiles files;
  const Study study = files.load(two_methods());
  const fs::path left = files.folder / "out/simulated/.partial-scene_a_1-0123abcd-4194999";
  fs::create_directories(left);
  write_text(left / "truth.tum", "1");
  REQUIRE(run_apart(study, options(files.folder / "out")) == 0);
  CHECK_FALSE(fs::exists(files.folder / "out/simulated"));
}

TEST_CASE("what a killed study has finished is not repeated") {
  const StudyFiles files;
  const Study study = files.load(two_methods());
  const fs::path output = files.folder / "out";
  REQUIRE(run_apart(study, options(output), [&] { return finished_in(output).size() >= 3; }) == 256 + SIGKILL);
  std::vector<std::pair<fs::path, fs::file_time_type>> finished;
  for (const fs::path& mark : finished_in(output)) finished.emplace_back(mark, fs::last_write_time(mark));
  REQUIRE(finished.size() >= 3);
  REQUIRE(run_apart(study, options(files.folder / "out")) == 0);
  for (const auto& [path, time] : finished) CHECK(fs::last_write_time(path) == time);
}

TEST_CASE("a finished run whose summary is lost, torn or cannot be read is made again") {
  const StudyFiles files;
  const Study study = files.load(head() + "datasets: [{scene: scene_a.yaml}]\n" +
                                 methods({"torn", "lost", "whole", "no_file", "no_key_file"}) + "metrics: [ate_m]\n");
  const fs::path output = files.folder / "out", runs = output / "runs/scene_a_1";
  Quiet monitor;
  REQUIRE(run_study(study, options(output), monitor).failures() == 0);
  const auto before = tables(output);
  write_text(runs / "torn/summary.json", "");
  fs::remove(runs / "lost/summary.json");
  for (const char* file : {"no_file/summary.json", "no_key_file/run_key.json"}) {
    fs::remove(runs / file);
    fs::create_directories(runs / file);
  }
  const auto left = rows_so_far(study, plan_runs(study, "program", fs::absolute(output) / "runs"), output);
  CHECK_FALSE(left[0].has_value());
  CHECK_FALSE(left[1].has_value());
  CHECK(left[2].has_value());
  CHECK_FALSE(left[3].has_value());
  CHECK_FALSE(left[4].has_value());
  monitor.lines.clear();
  CHECK(run_study(study, options(output), monitor).failures() == 0);
  for (const char* run : {"torn", "lost", "no_file", "no_key_file"}) {
    CHECK_THAT(monitor.lines, Contains(std::string("scene_a_1/") + run + ": ok"));
  }
  CHECK_THAT(monitor.lines, !Contains("/whole"));
  CHECK(tables(output) == before);
}

TEST_CASE("a finished run whose file another run reads is made again when the file is gone") {
  const StudyFiles files;
  const std::string replay = "set: {window: {type: replay, file: '{run:first}/updates.csv'}}";
  const Study study =
      files.load(head() + "datasets: [{scene: scene_a.yaml}]\nmethods:\n" + method("first", "as_lio_plus") +
                 method("shifted", "as_lio_plus", replay) + method("alone", "fixed_window") + "metrics: [ate_m]\n");
  const fs::path output = files.folder / "out", runs = output / "runs/scene_a_1";
  Quiet monitor;
  REQUIRE(run_study(study, options(output), monitor).failures() == 0);
  const auto before = tables(output);
  // What nobody reads may go.
  fs::remove(runs / "first/trajectory.tum");
  fs::remove(runs / "alone/updates.csv");
  monitor.lines.clear();
  CHECK(run_study(study, options(output), monitor).failures() == 0);
  CHECK(monitor.lines.empty());
  fs::remove(runs / "first/updates.csv");
  fs::remove_all(runs / "shifted");
  const auto left = rows_so_far(study, plan_runs(study, "program", fs::absolute(output) / "runs"), output);
  CHECK_FALSE(left[0].has_value());
  CHECK(left[2].has_value());
  const StudyResult again = run_study(study, options(output), monitor);
  INFO(monitor.lines);
  CHECK(again.failures() == 0);
  CHECK_THAT(monitor.lines,
             Contains("[2/3] scene_a_1/first: ok") && Contains("[3/3] scene_a_1/shifted: ok") && !Contains("alone"));
  CHECK(tables(output) == before);
  // Neither can be read.
  for (const bool folder : {true, false}) {
    INFO((folder ? "a folder" : "an empty file"));
    fs::remove(runs / "first/updates.csv");
    if (folder) {
      fs::create_directory(runs / "first/updates.csv");
    } else {
      write_text(runs / "first/updates.csv", "");
    }
    monitor.lines.clear();
    CHECK(run_study(study, options(output), monitor).failures() == 0);
    CHECK_THAT(monitor.lines, Contains("scene_a_1/first: ok"));
    CHECK(tables(output) == before);
  }
}

TEST_CASE("a finished run that is not selected keeps its row when the file that another run reads is gone") {
  const StudyFiles files;
  const std::string replay = "set: {window: {type: replay, file: '{run:first}/updates.csv'}}";
  const Study study =
      files.load(head() + "datasets: [{scene: scene_a.yaml}]\nmethods:\n" + method("first", "as_lio_plus") +
                 method("shifted", "as_lio_plus", replay) + method("alone", "fixed_window") + "metrics: [ate_m]\n");
  StudyOptions how = options(files.folder / "out");
  Quiet monitor;
  REQUIRE(run_study(study, how, monitor).failures() == 0);
  const auto before = tables(how.output);
  fs::remove(how.output / "runs/scene_a_1/first/updates.csv");
  monitor.lines.clear();
  how.only = "alone";
  CHECK(run_study(study, how, monitor).failures() == 0);
  CHECK(monitor.lines.empty());
  CHECK(tables(how.output) == before);
  how.only = "shifted";  // needs it
  CHECK(run_study(study, how, monitor).failures() == 0);
  CHECK_THAT(monitor.lines, Contains("scene_a_1/first: ok"));
  CHECK(tables(how.output) == before);
}

TEST_CASE("a run that failed without the file that another reads is not made again for it") {
  const StudyFiles files;
  const std::string replay = "set: {window: {type: replay, file: '{run:segv}/updates.csv'}}";
  const Study study =
      files.load(head() + "datasets: [{scene: scene_a.yaml}]\nmethods:\n" + method("segv", "as_lio_plus") +
                 method("shifted", "as_lio_plus", replay) + "metrics: [ate_m]\n");
  Quiet monitor;
  CHECK(run_study(study, options(files.folder / "out"), monitor).failures() == 2);
  monitor.lines.clear();
  CHECK(run_study(study, options(files.folder / "out"), monitor).failures() == 2);
  CHECK_THAT(monitor.lines, Contains("scene_a_1/shifted: failed") && !Contains("segv: "));
}

TEST_CASE("shared data without their bag, or with one that is cut off, are simulated again") {
  const StudyFiles files;
  const Study study = files.load(head() + "datasets: [{scene: scene_a.yaml}]\n" + methods({"one"}));
  const fs::path shared = files.folder / "shared", data = shared / "scene_a_1", bag = data / "data.bag";
  int call = 0;
  const auto simulates = [&] {
    StudyOptions how = options(files.folder / ("out_" + std::to_string(++call)));
    how.data = shared;
    Quiet monitor;
    CHECK(run_study(study, how, monitor).failures() == 0);
    return monitor.lines.find("scene_a_1: simulated") != std::string::npos;
  };
  REQUIRE(simulates());
  CHECK_FALSE(fs::exists(data));  // those that nobody asks to keep go
  StudyOptions keep = options(files.folder / "out");
  keep.data = shared;
  keep.keep_data = true;
  Quiet monitor;
  REQUIRE(run_study(study, keep, monitor).failures() == 0);
  CHECK_FALSE(simulates());
  const std::string whole = content(data / "identity.txt"), identity = whole.substr(0, whole.find('\n') + 1);
  CHECK(whole == identity + "3000 data.bag\n");
  for (const bool gone : {true, false}) {
    const fs::path aside = files.folder / (gone ? "gone" : "cut");
    fs::copy(data, aside);  // what is made anew is not kept
    if (gone) {
      fs::remove(bag);
    } else {
      fs::resize_file(bag, 1000);
    }
    INFO((gone ? "gone" : "cut"));
    CHECK(simulates());
    CHECK_FALSE(fs::exists(data));
    fs::rename(aside, data);
    CHECK_FALSE(simulates());
  }
  // As earlier versions wrote it.
  write_text(data / "identity.txt", identity);
  CHECK_FALSE(simulates());
  fs::remove(bag);
  CHECK(simulates());
}

TEST_CASE("the tables tell what is there from the first moment of a call") {
  const StudyFiles files;
  const Study study = files.load(head() + "datasets: [{scene: scene_a.yaml}]\n" + methods({"one", "hang"}));
  const fs::path output = files.folder / "out";
  StudyOptions earlier = options(output, 1);
  earlier.only = "one";
  REQUIRE(run_apart(study, earlier) == 0);
  REQUIRE(line_count(output / "results.csv") == 2);
  // Another program: none of these runs is one of its own.
  StudyOptions other = options(output, 1);
  other.program = "another program";
  const fs::path one = output / "runs/scene_a_1/one/run_key.json";
  const std::string mark = content(one);
  REQUIRE(run_apart(study, other, [&] { return fs::exists(one) && content(one) != mark; }) == 256 + SIGKILL);
  CHECK(line_count(output / "results.csv") == 1);
  CHECK_THAT(content(output / "table.md"), Contains("0 of 2 runs."));
}

TEST_CASE("a simulation that fails leaves its reason to a call that waits for the recording") {
  const StudyFiles files;
  write_text(files.folder / "broken.yaml", "third\n");
  const Study study = files.load(head() + "datasets: [{scene: broken.yaml}]\n" + methods({"one"}));
  StudyOptions part = options(files.folder / "out");
  part.recording = "broken_1";
  REQUIRE(run_apart(study, part) == 1);
  const auto runs = plan_runs(study, "program", fs::absolute(part.output) / "runs");
  const auto rows = rows_so_far(study, runs, part.output);
  REQUIRE(rows[0].has_value());
  CHECK(rows[0]->outcome.status == "failed");
  CHECK(rows[0]->outcome.reason == "simulation: there is no way through");
  CHECK_FALSE(rows[0]->outcome.final);
}

TEST_CASE("a recording that another call is at work on is waited for, and what it has finished is taken over") {
  const StudyFiles files;
  const Study study = files.load(head() + "datasets: [{scene: scene_a.yaml, seeds: 1-3}]\n" + methods({"one", "two"}));
  StudyOptions part = options(files.folder / "part");
  part.recording = "scene_a_2";
  REQUIRE(run_apart(study, part) == 0);
  const fs::path output = files.folder / "out", theirs = output / "runs/scene_a_2";
  fs::create_directories(theirs);

  /// Finishes when it is waited for.
  class Other final : public StudyMonitor {
   public:
    Other(fs::path from, fs::path to) : from_(std::move(from)), to_(std::move(to)) {
      lock_ = ::open(to_.c_str(), O_RDONLY | O_DIRECTORY);
      locked = ::flock(lock_, LOCK_EX | LOCK_NB) == 0;
    }
    ~Other() override { ::close(lock_); }
    Other(const Other&) = delete;
    Other& operator=(const Other&) = delete;
    void on_line(const std::string& line) override {
      lines += line + "\n";
      if (lines.find("[4/6]") == std::string::npos || done) return;
      done = true;
      untouched = !fs::exists(to_ / "one") && !fs::exists(to_ / "two");
      fs::copy(from_ / "one", to_ / "one");
      write_text(to_ / "one/theirs.txt", "yes");
      ::flock(lock_, LOCK_UN);
    }
    bool stop_requested() override { return false; }
    std::string lines;
    bool locked = false, done = false, untouched = false;

   private:
    fs::path from_, to_;
    int lock_ = -1;
  } other(part.output / "runs/scene_a_2", theirs);
  REQUIRE(other.locked);
  const StudyResult result = run_study(study, options(output), other);
  INFO(other.lines);
  CHECK(other.done);
  CHECK(other.untouched);
  CHECK_THAT(other.lines, Contains("scene_a_2: another `aslio experiment` is at work on it; waiting"));
  CHECK(result.failures() == 0);
  CHECK(std::all_of(result.rows.begin(), result.rows.end(), [](const auto& row) { return row.has_value(); }));
  CHECK(fs::exists(theirs / "one/theirs.txt"));
  CHECK(fs::exists(theirs / "two/run_key.json"));
}

TEST_CASE("the tables of one job are those of four") {
  const StudyFiles files;
  const Study study = files.load(two_methods());
  REQUIRE(run_apart(study, options(files.folder / "one", 1)) == 0);
  REQUIRE(run_apart(study, options(files.folder / "four", 4)) == 0);
  CHECK(tables(files.folder / "one") == tables(files.folder / "four"));
}

TEST_CASE("a study on a disk that is full goes on when there is room") {
  const StudyFiles files;
  const Study study = files.load(two_methods());
  REQUIRE(run_apart(study, options(files.folder / "whole")) == 0);
  // No file beyond so many bytes: simulations succeed and trajectories do not; then not even simulations.
  CHECK(run_apart(study, options(files.folder / "full"), nullptr, rlim_t{4096}) != 0);
  CHECK(run_apart(study, options(files.folder / "full"), nullptr, rlim_t{1024}) != 0);
  REQUIRE(run_apart(study, options(files.folder / "full")) == 0);
  CHECK(tables(files.folder / "full") == tables(files.folder / "whole"));
}

TEST_CASE("recordings that are worked on apart give the tables of the whole") {
  const StudyFiles files;
  const Study study = files.load(two_methods());
  REQUIRE(run_apart(study, options(files.folder / "whole")) == 0);
  for (const StudyData& data : study.data) {
    StudyOptions one = options(files.folder / "parts");
    one.recording = data.name;
    REQUIRE(run_apart(study, one) == 0);
    const StudyStatus status = read_status(one.output);  // of the whole study, from the first call on
    CHECK(status.total.all() == study.data.size() * study.methods.size());
  }
  CHECK_FALSE(fs::exists(files.folder / "parts/table.md"));
  Quiet monitor;
  CHECK(run_study(study, options(files.folder / "parts"), monitor).failures() == 0);
  CHECK(monitor.lines.empty());
  CHECK(tables(files.folder / "parts") == tables(files.folder / "whole"));
}
