/// Runs that read files of other runs.

#include <catch2/catch.hpp>

#include "aslio/experiment/study_run.hpp"
#include "study_files.hpp"

using namespace aslio::test;
using namespace aslio::experiment;
using Catch::Matchers::Contains;

namespace {

/// `patient` takes a second.
Study with_limit(const StudyFiles& files, const std::string& seconds) {
  return files.load(
      head() + "datasets: [{scene: scene_a.yaml}]\nmethods:\n" + method("patient", "as_lio_plus") +
      method("shifted", "as_lio_plus", "set: {window: {type: replay, file: '{run:patient}/updates.csv'}}") +
      "metrics: [ate_m]\ntime_limit: " + seconds + "\n");
}

StudyRow ended(const std::string& status, double limit = 0) {
  return {.outcome = {.status = status, .reason = "", .wall_s = 1, .final = true, .limit = limit}, .figures = {}};
}

}  // namespace

TEST_CASE("a run is not made of the files of one that was cut off, and is made when that has ended by itself") {
  const StudyFiles files;
  StudyOptions how;
  how.output = files.folder / "out";
  how.program = "program";
  how.executable = ASLIO_CHILD_PROGRAM;
  Quiet monitor;
  const StudyResult cut = run_study(with_limit(files, "0.3"), how, monitor);
  REQUIRE(cut.rows[1].has_value());
  CHECK(cut.rows[0]->outcome.status == "timeout");
  CHECK(cut.rows[1]->outcome.status == "failed");
  CHECK(cut.rows[1]->outcome.reason == "it reads files of patient, which was cut off (timeout: longer than 0.3 s)");
  const StudyResult whole = run_study(with_limit(files, "60"), how, monitor);
  CHECK(whole.rows[0]->outcome.status == "ok");
  CHECK(whole.rows[1]->outcome.status == "ok");
}

TEST_CASE("what read the files of a run that is made again is made again, too") {
  const StudyFiles files;
  const Study study = with_limit(files, "60");
  const auto runs = plan_runs(study, "program");
  const auto standing = [&](std::optional<StudyRow> used, std::optional<StudyRow> user) {
    return standing_runs(study, {}, runs, {std::move(used), std::move(user)});
  };
  CHECK(standing(ended("ok"), ended("ok")) == std::vector<bool>{true, true});
  CHECK(standing(ended("timeout", 5), ended("ok")) == std::vector<bool>{false, false});  // it has more time now
  CHECK(standing(ended("timeout", 60), ended("ok")) == std::vector<bool>{true, false});  // of an older version
  CHECK(standing(ended("crashed"), ended("ok")) == std::vector<bool>{true, false});
  CHECK(standing(ended("diverged"), ended("ok")) == std::vector<bool>{true, true});  // whole files, as they are
  CHECK(standing(std::nullopt, ended("ok")) == std::vector<bool>{false, true});      // its own files have gone
  StudyOptions again;
  again.retry = true;
  CHECK(standing_runs(study, again, runs, {ended("crashed"), ended("failed")}) == std::vector<bool>{false, false});
}
