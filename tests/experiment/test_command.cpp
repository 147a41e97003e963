/// `aslio experiment` from end to end, on a few seconds of data.

#include <signal.h>

#include <catch2/catch.hpp>

#include "study_files.hpp"

using namespace aslio::test;
using Catch::Matchers::Contains;

namespace fs = std::filesystem;

namespace {

/// Two seeds, a fixed window and its schedule replayed a second later.
std::string study_text() {
  return head() + "datasets: [{scene: small.yaml, seeds: 1-2, name: q}]\nmethods:\n" + method("fixed", "fixed_window") +
         method("replayed", "fixed_window",
                "set: {window: {type: replay, file: '{run:fixed}/updates.csv', shift: 1, warmup: 0}}") +
         "baseline: fixed\nmetrics: [ate_m]\n";
}

struct Bench {
  TemporaryFolder folder;
  explicit Bench(const std::string& text) {
    write_small_scene(folder);
    write_text(folder / "study.yaml", text);
  }
  std::vector<std::string> arguments(const std::vector<std::string>& more, const std::string& output = "out") const {
    std::vector<std::string> out = {"experiment", folder / "study.yaml", "--output", folder / output};
    out.insert(out.end(), more.begin(), more.end());
    return out;
  }
  Ended run(const std::vector<std::string>& more = {}, const std::string& output = "out") const {
    return run_aslio(arguments(more, output));
  }
};

/// results.csv without what a clock or the kernel decides.
std::vector<std::vector<std::string>> figures(const fs::path& output) {
  std::vector<std::vector<std::string>> out;
  for (const char* name : {"data", "method", "status", "ate_m", "end_to_end_m", "updates", "rate_hz"}) {
    out.push_back(column(output / "results.csv", name));
  }
  return out;
}

}  // namespace

TEST_CASE("a study runs to its tables, and a second call repeats nothing") {
  const Bench bench(study_text());
  const Ended dry = bench.run({"--dry-run"});
  CHECK(dry.code == 0);
  CHECK_THAT(dry.out, Contains("q_1/fixed: to run\n") && Contains("4 runs to do, 0 finished"));
  CHECK_FALSE(fs::exists(bench.folder / "out"));

  const Ended first = bench.run();
  INFO(first.err);
  REQUIRE(first.code == 0);
  CHECK_THAT(first.err, Contains("q_1: simulated in") && Contains("[4/4] q_2/replayed: ok, ate_m "));
  CHECK(column(bench.folder / "out/results.csv", "data") == std::vector<std::string>{"q_1", "q_1", "q_2", "q_2"});
  CHECK(column(bench.folder / "out/results.csv", "status") == std::vector<std::string>(4, "ok"));
  for (const char* file : {"summary.json", "updates.csv", "timings.csv", "trajectory.tum", "run_key.json"}) {
    INFO(file);
    CHECK(fs::exists(bench.folder / "out/runs/q_2/replayed" / file));
  }
  // Same rhythm, other moments.
  const auto updates = column(bench.folder / "out/results.csv", "updates");
  CHECK(std::abs(std::stoi(updates[0]) - std::stoi(updates[1])) <= 1);
  CHECK(content(bench.folder / "out/runs/q_1/fixed/updates.csv") !=
        content(bench.folder / "out/runs/q_1/replayed/updates.csv"));
  // The data have gone, the truth stays.
  CHECK_FALSE(fs::exists(bench.folder / "out/simulated"));
  CHECK(fs::exists(bench.folder / "out/data/q_1/truth.tum"));
  CHECK(fs::exists(bench.folder / "out/data/q_2/overlap.csv"));

  // One run loses its mark, another its summary in the middle of writing: the first alone is known as unfinished.
  const std::string table = content(bench.folder / "out/table.md");
  fs::remove(bench.folder / "out/runs/q_2/replayed/run_key.json");
  const Ended second = bench.run();
  INFO(second.err);
  CHECK(second.code == 0);
  CHECK_THAT(second.err, Contains("[4/4] q_2/replayed") && !Contains("q_1"));
  CHECK(content(bench.folder / "out/table.md") == table);
  CHECK_THAT(bench.run({"--dry-run"}).out, Contains("0 runs to do, 4 finished"));
}

TEST_CASE("tables do not depend on the number of jobs, and shared data are not made twice") {
  const Bench bench(study_text());
  const std::string shared = bench.folder / "shared";
  const Ended one = bench.run({"--data", shared, "--keep-data"}, "one");
  INFO(one.err);
  REQUIRE(one.code == 0);
  CHECK(fs::exists(bench.folder / "shared/q_1/dataset.yaml"));
  const Ended two = bench.run({"--data", shared, "--jobs", "2"}, "two");
  INFO(two.err);
  REQUIRE(two.code == 0);
  CHECK_THAT(two.err, !Contains("simulated"));
  CHECK(fs::exists(bench.folder / "shared/q_2/dataset.yaml"));  // they lay there before
  CHECK(figures(bench.folder / "one") == figures(bench.folder / "two"));
  CHECK(content(bench.folder / "one/table.md") == content(bench.folder / "two/table.md"));
}

TEST_CASE("an interrupted study keeps what is finished and goes on from there") {
  const Bench bench(study_text());
  const Ended ended = run_aslio(bench.arguments({}), [](pid_t child, const std::string& err) {
    if (err.find("[1/4]") == std::string::npos) return false;
    ::kill(child, SIGTERM);
    return true;
  });
  INFO(ended.err);
  CHECK(ended.code == 130);
  CHECK_THAT(ended.err, Contains("interrupted"));
  CHECK(fs::exists(bench.folder / "out/runs/q_1/fixed/run_key.json"));
  const Ended rest = bench.run();
  INFO(rest.err);
  CHECK(rest.code == 0);
  CHECK_THAT(rest.err, !Contains("q_1/fixed"));
  CHECK(column(bench.folder / "out/results.csv", "status") == std::vector<std::string>(4, "ok"));
}

TEST_CASE("a schedule that has changed is replayed again, and large outputs stay, and lost runs end on demand") {
  const Bench bench(
      head() +
      "datasets: [{scene: small.yaml, name: q}]\noutputs: [dense, map, world]\nstop_when_diverged: true\nmethods:\n" +
      method("fixed", "fixed_window") +
      method("replayed", "fixed_window", "set: {window: {type: replay, file: '{data}/mine.csv'}}"));
  const Ended first = bench.run();  // the schedule is not there
  INFO(first.err);
  CHECK(first.code == 1);
  for (const char* file : {"runs/q_1/fixed/trajectory_dense.tum", "runs/q_1/fixed/map.ply", "data/q_1/world.ply"}) {
    INFO(file);
    CHECK(fs::exists(bench.folder / "out" / file));
  }
  CHECK_THAT(content(bench.folder / "out/runs/q_1/fixed/manifest.json"), Contains("--stop-when-diverged"));
  const std::string updates = content(bench.folder / "out/runs/q_1/fixed/updates.csv");
  write_text(bench.folder / "out/data/q_1/mine.csv", updates);
  CHECK_THAT(bench.run().err, Contains("[2/2] q_1/replayed: ok"));
  CHECK_THAT(bench.run({"--dry-run"}).out, Contains("0 runs to do, 2 finished"));
  std::size_t cut = 0;  // half of the schedule
  for (std::size_t k = 0; k < 8; ++k) cut = updates.find('\n', cut) + 1;
  write_text(bench.folder / "out/data/q_1/mine.csv", updates.substr(0, cut));
  CHECK_THAT(bench.run({"--dry-run"}).out, Contains("1 runs to do, 1 finished"));
  CHECK_THAT(bench.run().err, Contains("[2/2] q_1/replayed: ok"));
}

TEST_CASE("options of the command that are wrong are told") {
  const Bench bench(study_text());
  CHECK_THAT(bench.run({"--seeds", "3-1"}).err, Contains("--seeds 3-1"));
  CHECK(bench.run({"--seeds", "3-1"}).code == 2);
  CHECK(bench.run({"--jobs", "0"}).code == 2);
  write_text(bench.folder / "file", "");
  // Also where nothing is to run, and before anything is simulated for data that have no place.
  const std::string file = bench.folder / "file";
  for (const auto& more : {std::vector<std::string>{}, std::vector<std::string>{"--dry-run"}}) {
    for (const char* output : {"file", "file/below"}) {
      const Ended ended = bench.run(more, output);
      INFO(output << " " << more.size());
      CHECK(ended.code == 2);
      CHECK(ended.out.empty());
      CHECK_THAT(ended.err,
                 Contains("--output ") && Contains(file + " is not a folder; name a folder that exists or can"));
    }
    auto data = more;
    data.insert(data.end(), {"--data", file});
    const Ended ended = bench.run(data);
    CHECK(ended.code == 2);
    CHECK(ended.out.empty());
    CHECK_THAT(ended.err, Contains("--data ") && Contains(file + " is not a folder; name a folder that exists or can"));
    CHECK_FALSE(fs::exists(bench.folder / "out"));
  }
}
