/// study.json as the report reads it: the texts of a study, or a refusal.

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <string>

#include "aslio/core/errors.hpp"
#include "aslio/report/page.hpp"
#include "aslio/report/run_series.hpp"
#include "aslio/report/study_folder.hpp"
#include "aslio/report/table.hpp"
#include "report/study_fixture.hpp"
#include "temporary_folder.hpp"

using namespace aslio;
using namespace aslio::report;
using namespace aslio::test;
using Catch::Contains;

namespace {

constexpr const char* kOneRun = "data,sequence,seed,order_seed,method,status,reason,ate_m\nloop_1,loop,1,0,a,ok,,0.2\n";

std::string refusal_of(const std::filesystem::path& folder) {
  try {
    (void)read_study_folder(folder);
  } catch (const DataError& error) {
    return error.what();
  }
  return {};
}

}  // namespace

TEST_CASE("a study.json that is none of ours is refused with a remedy") {
  const TemporaryFolder folder;
  write_text(folder.path() / "results.csv", kOneRun);
  for (const char* text : {"no JSON", "[]", "{}", R"({"schema": "aslio/study_results/9"})"}) {
    CAPTURE(text);
    write_text(folder.path() / "study.json", text);
    CHECK_THAT(refusal_of(folder.path()), Contains("study.json: is no JSON of schema aslio/study_results/1") &&
                                              Contains("run `aslio experiment` with this output folder again"));
  }
}

TEST_CASE("what has another type in study.json is left out") {
  const TemporaryFolder folder;
  write_text(folder.path() / "results.csv", kOneRun);
  write_text(
      folder.path() / "study.json",
      R"({"schema": "aslio/study_results/1", "name": 7, "planned": -1, "metrics": 3, "methods": [4, {"name": "a"}], )"
      R"("expectation": [], "identical": [1]})");
  const StudyFolder study = read_study_folder(folder.path());
  CHECK_FALSE(study.planned.has_value());
  CHECK(study.labels == std::vector<std::string>{"a"});
  CHECK((study.expectation.empty() && study.identical.empty()));
}

TEST_CASE("the folder of an older study is incomplete and says what completes it") {
  const TemporaryFolder folder;
  write_text(folder.path() / "results.csv", kOneRun);
  const StudyFolder older = read_study_folder(folder.path());
  CHECK_THAT(older.incomplete, Contains("study.json is missing") && Contains("Run `aslio experiment` with it again"));
  CHECK(older.question.empty());  // which the study has not asked
  CHECK_THAT(make_page(older, Bundle()), Contains("\"incomplete\":\"study.json is missing"));
  CHECK_THAT(to_markdown(older), Contains("Incomplete") && Contains("study.json is missing"));
  write_text(folder.path() / "study.json", R"({"schema": "aslio/study_results/1", "name": "whole"})");
  CHECK(read_study_folder(folder.path()).incomplete.empty());
}

TEST_CASE("an overlap.csv that is damaged is named, and the page lacks its line alone") {
  const TemporaryFolder folder;
  write_text(folder.path() / "results.csv", kOneRun);
  write_text(folder.path() / "study.json", R"({"schema": "aslio/study_results/1", "name": "s"})");
  write_text(folder.path() / "statistics.csv", "metric,method,baseline\nate_m,a,b\nate_m,a\n");
  CHECK_THAT(refusal_of(folder.path()), Contains("statistics.csv:3: has 2 cells, the first line 3"));
  std::filesystem::remove(folder.path() / "statistics.csv");
  std::filesystem::create_directories(folder.path() / "data/loop_1");
  write_text(folder.path() / "data/loop_1/overlap.csv", "t,true_overlap\n1,0.5\n2,\"0.6\n");
  const StudyFolder study = read_study_folder(folder.path());
  const auto json = data_json(study, "loop_1", DataTruth());
  CHECK_FALSE(json.contains("overlap"));
  CHECK_THAT(json["unreadable"].get<std::string>(), Contains("overlap.csv:3: a quote is not closed"));
}
