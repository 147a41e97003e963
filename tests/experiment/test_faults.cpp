/// Methods that crash, hang, eat memory, diverge or cannot begin: rows with their reasons.

#include <catch2/catch.hpp>

#include "study_files.hpp"

using namespace aslio::test;
using Catch::Matchers::Contains;

namespace fs = std::filesystem;

namespace {

std::string faulty(const std::string& fault) {
  return method(fault, "fixed_window", "set: {window: {type: faulty, fault: " + fault + "}}");
}

std::string quickstart() {
  return std::string("datasets: [{scene: ") + ASLIO_SOURCE_DIR +
         "/configs/scenes/quickstart.yaml, name: q}]\nmethods:\n";
}

std::vector<std::string> arguments(const TemporaryFolder& folder) {
  return {"experiment", folder / "study.yaml", "--output", folder / "out", "--scale", "0.2",
          "--plugin",   ASLIO_FAULTY_PLUGIN};
}

}  // namespace

TEST_CASE("a method that does not finish is a row with its reason, and the study goes on") {
  const TemporaryFolder folder;
  write_text(folder / "study.yaml",
             head() + quickstart() + faulty("crash") + faulty("memory") +
                 method("blind", "fixed_window", "set: {samplers: [{type: range, min: 400, max: 410}]}") +
                 method("lost", "fixed_window", "set: {window: {type: replay, file: '{data}/no_such_file.csv'}}") +
                 method("good", "fixed_window") + "metrics: [ate_m]\nmemory_limit: 1000\n");
  const Ended ended = run_aslio(arguments(folder));
  INFO(ended.err);
  CHECK(ended.code == 1);
  CHECK(column(folder / "out/results.csv", "status") ==
        std::vector<std::string>{"crashed", "memory", "diverged", "failed", "ok"});
  const std::string table = content(folder / "out/table.md");
  INFO(table);
  CHECK_THAT(table, Contains("| q_1 | crash | crashed | ended by signal 6 (Aborted) |"));
  CHECK_THAT(table, Contains("| q_1 | memory | memory | more than 1000 MB |"));
  CHECK_THAT(table, Contains("| q_1 | blind | diverged | the map is still empty"));
  CHECK_THAT(table, Contains("| q_1 | lost | failed | ") && Contains("no_such_file.csv"));
  CHECK_THAT(table, Contains("| q | x | x | x | x | 0."));

  // What was run stands in the folder of each, of the one that crashed, too.
  for (const char* run : {"crash", "memory", "good"}) {
    INFO(run);
    const std::string manifest = content(folder / "out/runs/q_1" / run / "manifest.json");
    CHECK_THAT(manifest, Contains("\"program\": \"") && Contains("\"load_average\": [") && Contains("\"seed\": 1") &&
                             Contains("\"scale\": 0.2") && Contains("configs/scenes/quickstart.yaml") &&
                             Contains("\"identity\": \"") && Contains(std::string("out/runs/q_1/") + run + "\"") &&
                             !Contains(".partial-"));
  }

  // What the method did it would do again; what could not be read may be there by now.
  std::vector<std::string> again = arguments(folder);
  again.push_back("--dry-run");
  const Ended dry = run_aslio(again);
  CHECK_THAT(dry.out, Contains("q_1/crash: finished") && Contains("q_1/memory: finished") &&
                          Contains("q_1/blind: finished") && Contains("q_1/lost: to run") &&
                          Contains("q_1/good: finished"));
  again.push_back("--retry");
  const fs::path crashed = folder.path() / "out/runs/q_1/crash/run_key.json";
  const auto written = fs::last_write_time(crashed);
  std::vector<std::string> once_more = arguments(folder);
  once_more.insert(once_more.end(), {"--only", "q_1/crash"});
  CHECK(run_aslio(once_more).code == 1);
  CHECK(fs::last_write_time(crashed) == written);
  once_more.push_back("--retry");
  CHECK(run_aslio(once_more).code == 1);
  CHECK(fs::last_write_time(crashed) > written);
  const Ended retry = run_aslio(again);
  CHECK_THAT(retry.out, Contains("q_1/crash: to run") && Contains("q_1/memory: to run") &&
                            Contains("q_1/blind: finished") && Contains("q_1/good: finished"));
}

TEST_CASE("a method that hangs is ended at the time limit") {
  const TemporaryFolder folder;
  write_text(folder / "study.yaml", head() + quickstart() + faulty("hang") + "time_limit: 1\n");
  const Ended ended = run_aslio(arguments(folder));
  INFO(ended.err);
  CHECK(ended.code == 1);
  CHECK_THAT(content(folder / "out/table.md"), Contains("| q_1 | hang | timeout | longer than 1 s |"));
  for (const auto& at : fs::recursive_directory_iterator(folder / "out/runs")) CHECK(at.path().extension() != ".part");

  // It is made again where it has more time, and only there.
  std::vector<std::string> dry = arguments(folder);
  dry.push_back("--dry-run");
  const auto with_limit = [&](const std::string& limit) {
    write_text(folder / "study.yaml", head() + quickstart() + faulty("hang") + "time_limit: " + limit + "\n");
    return run_aslio(dry).out;
  };
  CHECK_THAT(with_limit("1"), Contains("q_1/hang: finished"));
  CHECK_THAT(with_limit("0.5"), Contains("q_1/hang: finished"));
  CHECK_THAT(with_limit("2"), Contains("q_1/hang: to run"));
}

TEST_CASE("a method that is too slow leaves what it had at the time limit, and nothing half-written") {
  const TemporaryFolder folder;
  write_text(folder / "study.yaml", head() + quickstart() + faulty("slow") + "time_limit: 6\n");
  const Ended ended = run_aslio(arguments(folder));
  INFO(ended.err);
  CHECK_THAT(content(folder / "out/table.md"), Contains("| q_1 | slow | timeout | longer than 6 s |"));
  const fs::path runs = folder.path() / "out/runs/q_1";
  CHECK(fs::file_size(runs / "slow/trajectory.tum") > 100);
  CHECK_THAT(content(runs / "slow/summary.json"), Contains("interrupted"));
  std::size_t files = 0;
  for (const auto& at : fs::recursive_directory_iterator(runs)) {
    CHECK(at.path().extension() != ".part");
    ++files;
  }
  CHECK(files > 4);
}

TEST_CASE("a simulation that fails is the reason of every run that needed it") {
  const TemporaryFolder folder;
  write_text(folder / "mesh.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  write_text(folder / "scene.yaml",
             "schema: aslio/scene/1\nworld: {type: mesh, file: mesh.obj}\n"
             "route: [{x: 1900, y: 0}, {x: 1910, y: 0}, {x: 1910, y: 10}, {x: 1900, y: 10}]\n");
  write_text(folder / "study.yaml", head() + "datasets: [{scene: scene.yaml}]\nmethods:\n" +
                                        method("fixed", "fixed_window") + method("as_lio_plus", "as_lio_plus"));
  const Ended ended = run_aslio({"experiment", folder / "study.yaml", "--output", folder / "out"});
  INFO(ended.err);
  CHECK(ended.code == 1);
  CHECK(column(folder / "out/results.csv", "status") == std::vector<std::string>(2, "failed"));
  CHECK_THAT(content(folder / "out/results.csv"), Contains("simulation: "));
  CHECK_FALSE(fs::exists(folder / "out/simulated"));
}
