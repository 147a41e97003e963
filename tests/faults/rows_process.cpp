// Faults 62 to 72: the disk, signals, plugins, time and memory.
#include <signal.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <chrono>
#include <memory>
#include <thread>

#include "faults/table.hpp"

namespace aslio::test::faults {
namespace {

namespace fs = std::filesystem;

void unchanged(Measurements&) {}

std::function<Outcome()> with(How how) {
  return [how = std::move(how)] { return run_with(&unchanged, how); };
}

bool has(const Outcome& o, const std::string& file) {
  return std::find(o.files.begin(), o.files.end(), file) != o.files.end();
}

/// Once the first lines of updates.csv are on the disk, under its temporary name.
bool is_at_work(const fs::path& out) {
  std::error_code none;
  for (const auto& entry : fs::directory_iterator(out, none)) {
    const std::string name = entry.path().filename();
    if (name.starts_with("updates.csv.") && entry.file_size(none) > 0) return true;
  }
  return false;
}

bool terminate(pid_t process, const fs::path& out) {
  if (!is_at_work(out)) return false;
  ::kill(process, SIGTERM);
  return true;
}

/// Stops the process for most of two seconds of its life.
Outcome run_starved() {
  const auto times = std::make_shared<int>(0);
  return run_with(&unchanged, {.during = [times](pid_t process, const fs::path& out) {
    if (!is_at_work(out)) return false;
    ::kill(process, SIGSTOP);
    std::this_thread::sleep_for(std::chrono::milliseconds(150));
    ::kill(process, SIGCONT);
    return ++*times >= 10;
  }});
}

How with_plugin(const std::string& plugin, const std::string& assignment) {
  return {.set = {assignment}, .options = {"--plugin", plugin}};
}

std::vector<Row> outputs() {
  std::vector<Row> rows;
  rows.push_back({.number = 62,
                  .name = "disk_full",
                  .injected = "no file can grow beyond 10 kB",
                  .expected = {.status = {"failed"}, .exit = {3}, .says = {"File too large"}},
                  .run = with({.file_limit = 10'000}),
                  .also = "no half-written file is left",
                  .check = [](const Outcome& o) {
                    CHECK_FALSE(has(o, "updates.csv"));
                    CHECK_FALSE(has(o, "trajectory.tum"));
                    for (const std::string& file : o.files) CHECK(file.find(".part") == std::string::npos);
                  }});
  rows.push_back({.number = 63,
                  .name = "out_dir_unwritable",
                  .injected = "--output is below /proc",
                  .expected = {.exit = {2}, .says = {"--output /proc/aslio"}},
                  .run = with({.output = "/proc/aslio"})});
  rows.push_back({.number = 64,
                  .name = "sigterm_mid_run",
                  .injected = "SIGTERM in the middle of the run",
                  .expected = {.status = {"interrupted"}, .exit = {130}, .says = {"interrupted"}},
                  .run = with({.during = &terminate}),
                  .also = "the output up to that moment is written",
                  .check = [](const Outcome& o) {
                    CHECK(has(o, "manifest.json"));
                    CHECK(!o.times.empty());
                    CHECK(o.summary.at("coverage").get<double>() < 0.95);
                  }});
  return rows;
}

std::vector<Row> plugins() {
  std::vector<Row> rows;
  rows.push_back({.number = 65,
                  .name = "plugin_throws",
                  .injected = "a window of a plugin throws; and another one throws an int",
                  .expected = {.status = {"failed"}, .exit = {1}, .says = {"a stage failed", "on purpose"}},
                  .run = with(with_plugin(ASLIO_FAULTY_PLUGIN, "window={type: faulty, fault: throws}")),
                  .also = "the int is named with its type, and exit 1",
                  .check = [](const Outcome&) {
                    const Outcome o = run_with(
                        keep({0, 1}), with_plugin(ASLIO_FAULTY_PLUGIN, "window={type: faulty, fault: throws_int}"));
                    CHECK(o.exit_code == 1);
                    CHECK(o.status() == "failed");
                    CHECK_THAT(o.reason(), Catch::Matchers::Contains("of type 'int'"));
                  }});
  rows.push_back({.number = 66,
                  .name = "plugin_returns_nan",
                  .injected = "a residual of a plugin is not a number at every point",
                  .expected = {.status = {"failed", "diverged"}, .exit = {1}, .says = {"finite"}},
                  .run = with(with_plugin(ASLIO_FAULTY_PLUGIN, "estimator.residual={type: faulty}"))});
  rows.push_back({.number = 67,
                  .name = "plugin_abi_mismatch",
                  .injected = "a plugin of another ABI version",
                  .expected = {.exit = {2}, .says = {"wrong_version.so", "ABI version"}},
                  .run = with({.options = {"--plugin", ASLIO_TEST_PLUGINS "/wrong_version.so"}})});
  return rows;
}

std::vector<Row> time_and_memory() {
  std::vector<Row> rows;
  rows.push_back(
      {.number = 68,
       .name = "cpu_starved_4x",
       .injected = "the process is stopped ten times, 0.15 s each",
       .expected = {.status = {"ok"}},
       .run = &run_starved,
       .also = "the clean trajectory, to the last byte",
       .check = &check_same_as_clean,
       .note = "a recording waits for the program: it drops and queues nothing, and nothing may depend on the run "
               "time."});
  rows.push_back({.number = 69,
                  .name = "two_runs_same_bag",
                  .injected = "the clean walk once more",
                  .expected = {.status = {"ok"}},
                  .run = with({}),
                  .also = "the same trajectory, to the last byte",
                  .check = &check_same_as_clean});
  rows.push_back({.number = 70,
                  .name = "1_and_2_threads",
                  .injected = "the clean walk with `--threads 2`",
                  .expected = {.status = {"ok"}},
                  .run = with({.options = {"--threads", "2"}}),
                  .also = "the trajectory of one thread, to the last byte",
                  .check = &check_same_as_clean});
  rows.push_back({.number = 71,
                  .name = "soak",
                  .injected = "the clean walk against its first half",
                  .expected = {.status = {"ok"}},
                  .run = with({}),
                  .also = "the second half adds less than 20 MB (the map grows) to the memory; over ten minutes: test "
                          "\"soak\" (label `slow`)",
                  .check =
                      [](const Outcome& o) {
                        const Outcome half = run_with(keep({0, 6}));
                        CHECK(o.summary.at("peak_rss_mb").get<double>() <
                              half.summary.at("peak_rss_mb").get<double>() + 20);
                      },
                  .note = "`tools/soak HOURS` measures the slope per hour of data; a day does not fit into a test."});
  rows.push_back({.number = 72,
                  .name = "map_cap_reached",
                  .injected = "`map.radius: 6`: the map forgets points farther than 6 m",
                  .expected = {.status = {"ok", "degraded"}, .ate_times = 3, .ate_plus = 0.03},
                  .run = with({.set = {"map.radius=6"}}),
                  .also = "no more memory than with the whole map",
                  .check = [](const Outcome& o) {
                    CHECK(o.summary.at("peak_rss_mb").get<double>() <
                          run_clean().summary.at("peak_rss_mb").get<double>() + 1);
                  }});
  return rows;
}

}  // namespace

std::vector<Row> process_rows() {
  std::vector<Row> rows = outputs();
  for (auto* more : {&plugins, &time_and_memory}) {
    for (Row& row : more()) rows.push_back(std::move(row));
  }
  return rows;
}

}  // namespace aslio::test::faults
