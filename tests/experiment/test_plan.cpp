/// The runs of a study: their order, their keys, and what a glob selects.

#include <catch2/catch.hpp>

#include "aslio/core/errors.hpp"
#include "aslio/experiment/study_status.hpp"
#include "study_files.hpp"

using namespace aslio::test;
using namespace aslio::experiment;

namespace {

/// Two data x order seeds 0 and 7 x (as_lio_plus, fixed, shifted).
std::string plan_text() {
  return head() + "datasets: [{scene: scene_a.yaml, seeds: 1-2}]\nmethods:\n" + method("as_lio_plus", "as_lio_plus") +
         method("fixed", "fixed_window") +
         method("shifted", "as_lio_plus",
                "set: {window: {type: replay, file: '{run:as_lio_plus}/updates.csv', shift: 5}}") +
         "order_seeds: [0, 7]\n";
}

std::vector<std::string> selection(const Study& study, const std::string& glob) {
  const auto runs = plan_runs(study, "program");
  const auto selected = select_runs(study, runs, glob);
  std::vector<std::string> out;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    if (selected[i]) out.push_back(study.data[runs[i].data].name + "/" + runs[i].folder);
  }
  return out;
}

}  // namespace

TEST_CASE("runs come by data, order seed and method, and know the runs they use") {
  const StudyFiles files;
  const Study study = files.load(plan_text());
  const auto runs = plan_runs(study, "program");
  REQUIRE(runs.size() == 12);
  CHECK(selection(study, "") == std::vector<std::string>{"scene_a_1/as_lio_plus", "scene_a_1/fixed",
                                                         "scene_a_1/shifted", "scene_a_1/as_lio_plus_order_7",
                                                         "scene_a_1/fixed_order_7", "scene_a_1/shifted_order_7",
                                                         "scene_a_2/as_lio_plus", "scene_a_2/fixed",
                                                         "scene_a_2/shifted", "scene_a_2/as_lio_plus_order_7",
                                                         "scene_a_2/fixed_order_7", "scene_a_2/shifted_order_7"});
  CHECK(runs[11].uses == std::vector<std::size_t>{9});
  CHECK(overrides_of(study, runs, runs[11], "/out put/ru\"ns") ==
        std::vector<std::string>{
            "window={type: replay, file: \"/out put/ru\\\"ns/scene_a_2/as_lio_plus_order_7/updates.csv\", "
            "shift: 5}"});
}

TEST_CASE("the folder of the kept truth stands for its placeholder in every value") {
  const StudyFiles files;
  const Study study =
      files.load(head() + "datasets: [{scene: scene_a.yaml, seeds: 2}]\nmethods:\n" +
                 method("oracle", "as_lio_plus", "set: {window: {type: replay, file: '{data}/a.csv'}}"));
  const auto runs = plan_runs(study, "program");
  CHECK(overrides_of(study, runs, runs[0], "/out put/runs") ==
        std::vector<std::string>{"window={type: replay, file: \"/out put/data/scene_a_2/a.csv\"}"});
}

TEST_CASE("a glob selects by data, method or both, with the runs that are used") {
  const StudyFiles files;
  const Study study = files.load(plan_text());
  CHECK(selection(study, "scene_a_2/fix*") == std::vector<std::string>{"scene_a_2/fixed", "scene_a_2/fixed_order_7"});
  CHECK(selection(study, "scene_a_1").size() == 6);
  CHECK(selection(study, "*_2/shifted") == std::vector<std::string>{"scene_a_2/as_lio_plus", "scene_a_2/shifted"});
  CHECK(selection(study, "shifted").size() == 8);
  CHECK(selection(study, "nothing").empty());
  for (const char* some : {"", "shifted", "*_order_7", "scene_a_2"}) CHECK_NOTHROW(require_selection(study, some));
  CHECK_THROWS_WITH(require_selection(study, "nothing"), Catch::Matchers::Contains("matches none of 12 runs"));
}

TEST_CASE("a call for some of the runs leaves the plan of all, and one for none of them is refused") {
  const StudyFiles files;
  const Study study = files.load(head() + "datasets: [{scene: scene_a.yaml, seeds: 1-2}]\nmethods:\n" +
                                 method("a", "fixed_window") + method("b", "as_lio_plus"));
  StudyOptions options;
  options.output = files.folder / "out";
  options.program = "program";
  options.executable = ASLIO_CHILD_PROGRAM;
  options.only = "c";
  Quiet monitor;
  CHECK_THROWS_AS(run_study(study, options, monitor), aslio::ConfigError);
  CHECK_FALSE(std::filesystem::exists(options.output));
  options.only = "scene_a_1/a";
  run_study(study, options, monitor);
  const StudyStatus status = read_status(options.output);
  CHECK(status.total.good == 1);
  CHECK(status.total.waiting == 3);
}

TEST_CASE("the key of a run changes with what the run depends on, and with nothing else") {
  const StudyFiles files;
  const auto keys = [&](const std::string& text, const std::string& program = "program") {
    std::vector<std::string> out;
    const Study study = files.load(text);
    for (const StudyRun& run : plan_runs(study, program)) out.push_back(run.key);
    return out;
  };
  const auto replaced = [](std::string text, const std::string& from, const std::string& to) {
    return text.replace(text.find(from), from.size(), to);
  };
  const std::string text = plan_text();
  const auto before = keys(text);
  for (std::size_t i = 0; i < before.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) CHECK(before[i] != before[j]);
  }
  CHECK(keys(replaced(text, "Which?", "Which of them?")) == before);
  CHECK(keys(text, "other program")[0] != before[0]);

  // Another as_lio_plus is another `shifted`, which replays it; `fixed` stays.
  const auto other = keys(replaced(text, "as_lio_plus.yaml}", "as_lio_plus.yaml, set: {window.seg_step: 0.2}}"));
  CHECK(other[0] != before[0]);
  CHECK(other[1] == before[1]);
  CHECK(other[2] != before[2]);

  write_text(files.folder / "scene_a.yaml", "first, changed\n");
  CHECK(keys(text)[1] != before[1]);
}

TEST_CASE("the key of a run goes with the content of the schedule that it replays") {
  const StudyFiles files;
  const auto keys = [&](const std::string& file) {
    const Study study = files.load(
        head() + "datasets: [{scene: scene_a.yaml, seeds: 2}]\nmethods:\n" + method("fixed", "fixed_window") +
        method("replayed", "as_lio_plus", "set: {window: {type: replay, file: '" + file + "'}}"));
    std::vector<std::string> out;
    for (const StudyRun& run : plan_runs(study, "program", files.folder / "out/runs")) out.push_back(run.key);
    return out;
  };
  const std::string written = files.folder / "schedule.csv", kept = "out/data/scene_a_2/oracle.csv";
  write_text(written, "t_ns\n100\n200\n");
  const auto first = keys(written);
  write_text(written, "t_ns\n100\n300\n");
  const auto second = keys(written);
  CHECK(second[0] == first[0]);
  CHECK(second[1] != first[1]);

  // One that a script puts beside the kept truth, where there is none at first.
  const auto without = keys("{data}/oracle.csv");
  CHECK(keys("{data}/oracle.csv") == without);
  std::filesystem::create_directories((files.folder / kept).parent_path());
  write_text(files.folder / kept, "t_ns\n100\n200\n");
  const auto with = keys("{data}/oracle.csv");
  CHECK(with[0] == without[0]);
  CHECK(with[1] != without[1]);
  write_text(files.folder / kept, "t_ns\n100\n300\n");
  CHECK(keys("{data}/oracle.csv")[1] != with[1]);
}

TEST_CASE("what a killed study left of a run goes, and what belongs to a run of a longer name stays") {
  const StudyFiles files;
  const Study study =
      files.load(head() + "datasets: [{scene: scene_a.yaml}]\nmethods:\n" + method("a", "fixed_window"));
  StudyOptions options;
  options.output = files.folder / "out";
  options.program = "program";
  options.executable = ASLIO_CHILD_PROGRAM;
  const std::filesystem::path runs = options.output / "runs/scene_a_1", data = options.output / "simulated";
  for (const auto& folder : {runs / ".a.partial-1", runs / ".a.partial-b.partial-1", data / ".partial-scene_a_1-0a-1",
                             data / ".partial-scene_a_1-b-0a-1"}) {
    std::filesystem::create_directories(folder);
  }
  options.recording = "scene_a_1";
  Quiet monitor;
  CHECK(run_study(study, options, monitor).failures() == 0);
  CHECK_FALSE(std::filesystem::exists(runs / ".a.partial-1"));
  CHECK(std::filesystem::exists(runs / ".a.partial-b.partial-1"));
  CHECK_FALSE(std::filesystem::exists(data / ".partial-scene_a_1-0a-1"));
  CHECK(std::filesystem::exists(data / ".partial-scene_a_1-b-0a-1"));
}

TEST_CASE("large outputs, and whether lost runs go on, are part of the key") {
  const StudyFiles files;
  const std::string text = head() + "datasets: [{scene: scene_a.yaml}]\nmethods:\n" + method("fixed", "fixed_window");
  const auto key = [&](const std::string& outputs) { return plan_runs(files.load(text + outputs), "program")[0].key; };
  CHECK(key("outputs: [dense]\n") != key(""));
  CHECK(key("outputs: [dense]\n") != key("outputs: [map]\n"));
  CHECK(key("stop_when_diverged: true\n") != key(""));
  CHECK_THAT(
      files.complaint(
          text + method("again", "fixed_window", "set: {window: {type: replay, file: '{run:fixed}/updates.csv'}}") +
          "stop_when_diverged: true\n"),
      Catch::Matchers::Contains("{run:fixed}: does not go with stop_when_diverged"));
  CHECK(key("stop_when_diverged: false\n") == key(""));
  CHECK_THAT(files.complaint(text + "outputs: [pictures]\n"), Catch::Matchers::Contains("pictures"));
}
