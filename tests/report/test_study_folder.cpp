/// Reading a study back, its tables and its page.

#include <fmt/format.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <fstream>
#include <nlohmann/json.hpp>

#include "aslio/core/csv.hpp"
#include "aslio/core/errors.hpp"
#include "aslio/core/sha256.hpp"
#include "aslio/report/encode.hpp"
#include "aslio/report/page.hpp"
#include "aslio/report/run_series.hpp"
#include "aslio/report/table.hpp"
#include "study_fixture.hpp"
#include "temporary_folder.hpp"

using namespace aslio::report;
using namespace aslio::test;
using Catch::Matchers::Contains;
using Catch::Matchers::StartsWith;

namespace {

constexpr const char* kAgainstA =
    R"({"schema": "aslio/study_results/1", "name": "s", "metrics": ["ate_m"], "methods": [{"name": "b", "baseline": "a"}]})";

struct Fixture {
  TemporaryFolder folder;
  Fixture() { write_study(folder.path()); }
  StudyFolder study() const { return read_study_folder(folder.path()); }
};

std::string problem(const std::filesystem::path& folder) {
  try {
    read_study_folder(folder);
  } catch (const aslio::DataError& error) {
    return error.what();
  }
  return {};
}

const Bundle kBundle = {"run();", "p { color: red; }"};

/// What the page knows of the study.
nlohmann::json data_of(const std::string& page) {
  const std::size_t begin = page.find("id=\"study\">") + 11;
  return nlohmann::json::parse(page.substr(begin, page.find("</script>", begin) - begin));
}

}  // namespace

TEST_CASE("a study is read from what it left") {
  const Fixture fixture;
  const StudyFolder study = fixture.study();
  CHECK(study.name == "fixture");
  CHECK_THAT(study.question, Contains("Which is better?"));
  CHECK(study.rule == "At most 0 of 45 runs. Lower median.");
  REQUIRE(study.expectation.size() == 2);
  CHECK(study.expectation[0] == "it pays: **does not hold**");
  CHECK(study.planned == 12);
  CHECK(study.metrics == std::vector<std::string>{"ate_m", "ate_deg"});
  CHECK(study.methods == std::vector<std::string>{"fixed_10", "as_lio_plus", kHostile});
  CHECK(study.labels == std::vector<std::string>{"10 Hz, fixed", "as_lio_plus", kHostile});
  CHECK(study.sequences == std::vector<std::string>{"loop", "turn"});
  CHECK(study.baseline[1] == 0);
  CHECK_FALSE(study.baseline[0].has_value());
  REQUIRE(study.runs.size() == 11);
  CHECK(study.runs[1].reason == "few points");
  CHECK(study.runs[1].figures[0] == 0.02);
  CHECK_FALSE(study.runs.back().figures[0].has_value());
  CHECK(study.runs[8].folder == fixture.folder.path() / "runs" / "loop_1" / kHostile);
}

TEST_CASE("a study that has just begun has a report without runs") {
  const TemporaryFolder folder;
  write_text(folder.path() / "results.csv", "data,sequence,seed,order_seed,method,status,reason\n");
  write_text(folder.path() / "study.json",
             R"({"schema": "aslio/study_results/1", "name": "young", "question": "Which?", "planned": 12, "done": 0})");
  const StudyFolder study = read_study_folder(folder.path());
  CHECK(study.runs.empty());
  CHECK(study.planned == 12);
  CHECK_THAT(make_page(study, kBundle, {}), Contains("\"planned\":12") && Contains("\"runs\":[]"));
  CHECK_THAT(to_markdown(study), Contains("0 of 12 runs"));
  CHECK_NOTHROW(to_latex(study));
}

TEST_CASE("what is no study is refused with its place") {
  const TemporaryFolder folder;
  CHECK_THAT(problem(folder.path()), Contains("neither results.csv nor a run"));
  write_text(folder.path() / "results.csv", "a,b\n1,2\n");
  CHECK_THAT(problem(folder.path()), Contains("results.csv:1: the columns are not those"));
  const std::string header = "data,sequence,seed,order_seed,method,status,reason,ate_m\n";
  write_text(folder.path() / "results.csv", header);
  CHECK_THAT(problem(folder.path()), Contains("holds no run"));
  write_text(folder.path() / "results.csv", header + "a,a,1,0,m,ok,,0.1,3\n");
  CHECK_THAT(problem(folder.path()), Contains("results.csv:2: has 9 cells, the first line 8"));
  write_text(folder.path() / "results.csv", header + "a,a,1,0,m,ok,,fast\n");
  CHECK_THAT(problem(folder.path()), Contains("'fast' is no number"));
  write_text(folder.path() / "results.csv", header + "../../etc,a,1,0,m,ok,,1\n");
  CHECK_THAT(problem(folder.path()), Contains("'../../etc' is no name of a folder"));
  write_text(folder.path() / "results.csv", header + "a,a,1,x/../../etc,m,ok,,1\n");
  CHECK_THAT(problem(folder.path()), Contains("'x/../../etc' is no order_seed"));
}

TEST_CASE("runs without a study are methods over one recording") {
  const TemporaryFolder folder;
  for (const char* method : {"a", "b"}) {
    std::filesystem::create_directories(folder.path() / method);
    write_text(folder.path() / method / "summary.json",
               R"({"status": "ok", "reason": "", "updates": 7, "metrics": {"ate_m": 0.5}, "cpu_s": 2, "data_s": 10})");
  }
  const StudyFolder study = read_study_folder(folder.path());
  CHECK(study.methods == std::vector<std::string>{"a", "b"});
  CHECK(study.runs[1].figures[*study.figure("ate_m")] == 0.5);
  CHECK(read_study_folder(folder.path() / "b").methods == std::vector<std::string>{"b"});
}

TEST_CASE("a run whose summary cannot be read is a failure with its reason, not missing") {
  const TemporaryFolder folder;
  const std::vector<std::pair<std::string, std::string>> cases = {{"cut", "{"}, {"empty", ""}, {"mute", "{\"a\": 1}"}};
  for (const auto& [name, text] : cases) {
    std::filesystem::create_directories(folder.path() / name);
    write_text(folder.path() / name / "summary.json", text);
  }
  std::filesystem::create_directories(folder.path() / "folder/summary.json");
  std::filesystem::create_directories(folder.path() / "good");
  write_text(folder.path() / "good/summary.json", R"({"status": "ok", "metrics": {"ate_m": 0.5}})");
  const StudyFolder study = read_study_folder(folder.path());
  REQUIRE(study.methods == std::vector<std::string>{"cut", "empty", "folder", "good", "mute"});
  CHECK(study.runs[3].status == "ok");
  for (const auto& [run, reason] :
       {std::pair(0, "it is no JSON object"), std::pair(1, "it is empty"),
        std::pair(2, "it is no file that can be opened"), std::pair(4, "it names no status")}) {
    CHECK(study.runs[static_cast<std::size_t>(run)].status == "failed");
    CHECK_THAT(study.runs[static_cast<std::size_t>(run)].reason,
               Contains(std::string("summary.json cannot be read: ") + reason + "; make the run again"));
  }
  CHECK(study.runs[0].figures == std::vector<std::optional<double>>{std::nullopt});
  CHECK_THAT(to_markdown(study), Contains("| recording | cut | failed |"));
  const StudyFolder alone = read_study_folder(folder.path() / "cut");
  CHECK(alone.methods == std::vector<std::string>{"cut"});
  CHECK(alone.runs[0].status == "failed");
  // Told once.
  CHECK(data_of(make_page(alone, kBundle))["runs"][0]["reason"] == alone.runs[0].reason);
}

TEST_CASE("files of a run that cannot be read are told beside its status, and the rest is shown") {
  const Fixture fixture;
  const auto run = fixture.folder.path() / "runs/loop_1/fixed_10",
             other = fixture.folder.path() / "runs/loop_2/as_lio_plus";
  write_text(run / "trajectory.tum", "\x7f\xff garbage\n");
  write_text(run / "updates.csv", "t_ns,status,sod\n1700000001000000000,ok,0.5\n17000000020000");
  write_text(run / "timings.csv", "no telemetry\n1\n");
  write_text(run / "manifest.json", "{");
  write_text(other / "updates.csv", "t_ns,status,sod\n100,ok,0.5\n200,ok\n300,ok,0.5\n");
  std::vector<std::string> unreadable;
  const auto json = data_of(make_page(fixture.study(), kBundle, {}, &unreadable));
  CHECK(json["runs"][0]["status"] == "ok");
  REQUIRE(unreadable.size() == 5);
  CHECK(unreadable[0] == (run / "manifest.json").string() + ": it is no JSON object");
  CHECK_THAT(unreadable[1], StartsWith(run.string() + ": trajectory.tum:1: 2 columns"));
  CHECK_THAT(unreadable[4], StartsWith(other.string() + ": updates.csv: 1 of 3 lines"));
  const std::string reason = json["runs"][0]["reason"];
  INFO(reason);
  CHECK_THAT(reason, Contains("trajectory.tum:1: 2 columns where TUM has 8") &&
                         Contains("the trajectory is left out") &&
                         Contains("updates.csv: it is cut off in the middle of a line") &&
                         Contains("timings.csv: its first line names no column t_ns") &&
                         Contains("manifest.json: it is no JSON object"));
  CHECK(reason.find(fixture.folder.path().string()) == std::string::npos);  // the page is for any machine
  CHECK(json["runs"][0]["series"]["channels"].contains("sod"));
  CHECK_FALSE(json["runs"][0]["series"].contains("path"));
  CHECK(json["runs"][1]["reason"] == "few points");
  for (const auto& at : json["runs"]) {
    if (at["data"] == "loop_2" && at["method"] == "as_lio_plus") {
      CHECK_THAT(at["reason"].get<std::string>(),
                 Contains("few points; updates.csv: 1 of 3 lines have another number"));
    }
    if (at["data"] == "turn_1")
      CHECK_THAT(at["reason"].get<std::string>(), !Contains("cannot") && !Contains("left out"));
  }
}

TEST_CASE("the empty trajectory of a run that failed is nothing to note") {
  const TemporaryFolder folder;
  write_text(folder.path() / "trajectory.tum", "");
  FolderRun run;
  run.folder = folder.path();
  run.status = "failed";
  CHECK(series_json(run, {}).is_null());
  run.status = "ok";
  CHECK_THAT(series_json(run, {})["notes"][0].get<std::string>(), Contains("trajectory.tum: holds no pose"));
}

TEST_CASE("failures are worse than any figure, and keep apart how they failed") {
  const Fixture fixture;
  const auto tables = make_tables(fixture.study(), {"ate_m", "no_such", "cpu_s_per_s"});
  REQUIRE(tables.size() == 2);
  const MetricTable& ate = tables[0];
  CHECK(ate.metric.unit == "mm");
  CHECK(number(ate.metric, 0.0255) == "25.5");
  const auto& loop = ate.lines[0].cells;
  CHECK(loop[1].mark == Mark::value);
  CHECK(loop[1].median == Approx(0.025));
  CHECK(loop[1].min == Approx(0.02));
  CHECK(loop[1].max == Approx(0.03));
  CHECK(loop[1].rank == Rank::best);
  CHECK(loop[0].rank == Rank::second);
  CHECK(loop[2].mark == Mark::diverged);
  CHECK((loop[2].runs == 2 && loop[2].diverged == 1 && loop[2].failed == 0));
  CHECK(ate.lines[1].cells[2].mark == Mark::failed);
  REQUIRE(ate.comparisons.size() == 1);
  CHECK((ate.comparisons[0].sequences.won == 1 && ate.comparisons[0].sequences.lost == 1));
  CHECK((ate.comparisons[0].pairs.won == 2 && ate.comparisons[0].pairs.lost == 2));
  CHECK(*ate.comparisons[0].ratio == Approx(0.5 * (0.5 + 0.1 / 0.06)));
}

TEST_CASE("order seeds and two failures count as in table.md") {
  const TemporaryFolder folder;
  std::string csv = "data,sequence,seed,order_seed,method,status,reason,ate_m\n";
  for (const char* line : {"0,a,ok,,0.2", "0,b,ok,,0.1", "1,a,ok,,0.2", "1,b,ok,,0.1", "2,a,ok,,0.2", "2,b,failed,,"}) {
    csv += std::string("loop_1,loop,1,") + line + "\n";
  }
  write_text(folder.path() / "results.csv", csv + "loop_2,loop,2,0,a,failed,,\nloop_2,loop,2,0,b,failed,,\n");
  write_text(folder.path() / "study.json", kAgainstA);
  const MetricTable ate = make_tables(read_study_folder(folder.path()), {"ate_m"}).at(0);
  REQUIRE(ate.comparisons.size() == 1);
  const Comparison& c = ate.comparisons[0];
  CHECK((c.pairs.won == 1 && c.pairs.lost == 0 && c.pairs.tied == 1));
  CHECK(*c.ratio == Approx((0.5 + 1) / 2));
  const Cell& cell = ate.lines.at(0).cells.at(1);
  CHECK((cell.runs == 4 && cell.failed + cell.diverged == 2));
  CHECK(cell.mark != Mark::value);  // median of 0.1 and a failure
  CHECK((cell.min == Approx(0.1) && cell.max == Approx(0.1)));
}

TEST_CASE("a cell without a figure has no range, and sequences are compared over the recordings that both have") {
  const TemporaryFolder folder;
  std::string csv = "data,sequence,seed,order_seed,method,status,reason,ate_m\n";
  // One recording, two of its three order seeds failed.
  for (const char* line : {"0,b,ok,,0.1", "1,b,failed,,", "2,b,failed,,", "0,a,ok,,0.2"}) {
    csv += std::string("loop_1,loop,1,") + line + "\n";
  }
  // b is lower on the one both have; over all of its own, of other seeds, it is higher.
  for (const char* line : {"1,0,a,ok,,0.2", "1,0,b,ok,,0.1", "2,0,b,ok,,0.9", "3,0,b,ok,,0.9"}) {
    csv += std::string("turn_") + line[0] + ",turn," + line + "\n";
  }
  write_text(folder.path() / "results.csv", csv);
  write_text(folder.path() / "study.json", kAgainstA);
  const StudyFolder study = read_study_folder(folder.path());
  const MetricTable ate = make_tables(study, {"ate_m"}).at(0);
  const std::size_t b = study.methods.at(0) == "b" ? 0 : 1;
  const Cell& failed = ate.lines.at(0).cells.at(b);
  CHECK((failed.mark == Mark::failed && failed.recordings == 1 && failed.with_figure == 0));
  CHECK_THAT(to_markdown(study), Contains("x 2x"));
  CHECK_THAT(to_markdown(study), !Contains("0.00"));
  // Of loop both have the order seed 0.
  CHECK((ate.comparisons.at(0).sequences.won == 2 && ate.comparisons.at(0).sequences.lost == 0));
}

TEST_CASE("comparisons carry the statistics of the study") {
  const Fixture fixture;
  const auto tables = make_tables(fixture.study(), {"ate_m", "ate_deg"});
  const auto& more = tables[0].comparisons[0].more;
  REQUIRE(more.size() == 5);
  CHECK((more[0].name == "95 % of ratio" && more[0].text == "0.4 to x"));
  CHECK((more[1].text == "-0.50" && more[2].text == "< 0.001" && more[3].text == "0.125"));
  CHECK((more[4].name == "p (sequences)" && more[4].text == "0.250"));
  CHECK(tables[1].comparisons[0].more.empty());
  CHECK_THAT(to_markdown(fixture.study()), Contains("| as_lio_plus | 10 Hz, fixed | 1 / 1 / 0 | 2 / 2 / 0 | 1.08 | 0.4 "
                                                    "to x | -0.50 | &lt; 0.001 | 0.125 | 0.250 |"));
  CHECK(fixture.study().identical == std::vector<std::string>{"a and b do not differ"});
}

TEST_CASE("Markdown marks the best, the second and the failures") {
  const Fixture fixture;
  const std::string text = to_markdown(fixture.study());
  INFO(text);
  CHECK_THAT(text, Contains("## ATE [mm]") && Contains("## Expectation\n\n- it pays: **does not hold**\n"));
  CHECK_THAT(text, Contains("| loop | <u>55.0</u> (50.0-60.0) | **25.0** (20.0-30.0) | - (400.0-400.0) 1- |"));
  CHECK_THAT(text, Contains("x: total failure") && Contains("-: severe divergence midway"));
  CHECK_THAT(text, Contains("| loop_2 | &lt;img src=x onerror=fail()&gt;&amp;\"' | diverged |"));
  CHECK(text.find("<img") == std::string::npos);
  CHECK(text.find("<script") == std::string::npos);
}

TEST_CASE("CSV is a line per run and figure, and no formula") {
  const Fixture fixture;
  const std::string text = to_csv(fixture.study());
  CHECK(text.starts_with(
      "data,sequence,seed,order_seed,method,status,reason,metric,value\nloop_1,loop,1,0,fixed_10,ok,,ate_m,0.05\n"));
  CHECK_THAT(text, Contains("crashed,'=cmd(),,\n"));
  const auto table = aslio::parse_csv(text, "to_csv");  // every line as long as the first
  CHECK((table.header.size() == 9 && table.rows.size() == 10 * 4 + 1));
}

TEST_CASE("a course is placed in the world of the truth") {
  const Fixture fixture;
  const StudyFolder study = fixture.study();
  const DataTruth truth = read_truth(study, "loop_1");
  REQUIRE(truth.truth.has_value());
  const auto series = series_json(study.runs[1], truth);
  CHECK(series["aligned"] == true);
  for (const char* name : {"sod", "rate_hz", "gyro_deg_s", "matches", "residual_cm", "weakest", "cpu_ms", "error_cm"}) {
    CHECK(series["channels"].contains(name));
  }
  CHECK(series["stages_ms"]["solve"].get<double>() == Approx(0.5));
  CHECK(series["weak"].size() == 7);
  const auto has = [&](const char* state) {
    return std::any_of(series["weak"].begin(), series["weak"].end(),
                       [&](const auto& stretch) { return stretch[2] == state; });
  };
  CHECK((has("initialising") && has("degenerate") && has("alarm") && has("lost")));
  CHECK(data_json(study, "loop_1", truth).contains("overlap"));
  const auto map = map_json(study.runs[1], truth, 1000);
  REQUIRE_FALSE(map.is_null());
  CHECK(map["voxel"].get<double>() > 0.1);
  CHECK(map_json(study.runs[0], truth, 1000).is_null());
  CHECK(series_json(study.runs.back(), truth).is_null());
}

TEST_CASE("where the truth tells nothing, no error is drawn") {
  const Fixture fixture;
  const StudyFolder study = fixture.study();
  const DataTruth whole = read_truth(study, "loop_1");
  const auto all = series_json(study.runs[1], whole);
  CHECK_FALSE(all["path"].contains("known"));
  DataTruth half = whole;
  const auto samples = whole.truth->samples();
  half.truth = aslio::Trajectory({samples.begin() + static_cast<std::ptrdiff_t>(samples.size() / 2), samples.end()});
  const auto partly = series_json(study.runs[1], half);
  CHECK(partly["aligned"] == true);
  CHECK(partly["path"].contains("known"));
  const auto drawn = [](const auto& series) {
    return series["channels"]["error_cm"]["t"].template get<std::string>().size();
  };
  CHECK(10 * drawn(partly) < 8 * drawn(all));
  CHECK_FALSE(partly["channels"]["error_cm"].contains("breaks"));

  std::vector<aslio::StampedPose> outer(samples.begin(), samples.end());
  const auto third = static_cast<std::ptrdiff_t>(outer.size() / 3);
  outer.erase(outer.begin() + third, outer.end() - third);
  DataTruth torn = whole;
  torn.truth = aslio::Trajectory(std::move(outer));
  CHECK(series_json(study.runs[1], torn)["channels"]["error_cm"].contains("breaks"));
}

TEST_CASE("what measured a single run is found by its manifest") {
  const Fixture fixture;
  const StudyFolder study = fixture.study();
  const auto folder = fixture.folder.path();
  std::filesystem::rename(folder / "data/loop_1/truth.tum", folder / "reference.tum");
  const auto named = [&](const nlohmann::json& manifest) {
    for (const auto& run : study.runs)
      if (run.data == "loop_1") write_text(run.folder / "manifest.json", manifest.dump());
    return read_truth(study, "loop_1").truth.has_value();
  };
  const nlohmann::json path = (folder / "reference.tum").string();
  CHECK(named({{"reference", {{"path", path}}}, {"dataset", nullptr}}));
  CHECK_FALSE(named({{"reference", {{"path", (folder / "gone.tum").string()}}}}));
  CHECK_FALSE(named({{"reference", {{"path", folder.string()}}}}));
  CHECK_FALSE(named({{"reference", {{"path", 5}}}}));
  CHECK_FALSE(named({{"reference", nullptr}}));
  CHECK_FALSE(named(nlohmann::json::array()));
  // Of a run before manifests named it.
  for (const char* name : {"loop_1.bag", "none.yaml"}) write_text(folder / name, "");
  write_text(folder / "dataset.yaml",
             "schema: aslio/dataset/1\ninput: loop_1.bag\nsensor: none.yaml\nreference: reference.tum\n");
  CHECK(named({{"dataset", (folder / "dataset.yaml").string()}}));
}

TEST_CASE("a line breaks where values are missing in its middle") {
  const TemporaryFolder folder;
  // Straight lines on both sides of what is missing: a single one would pass all of it.
  std::string text = "t_ns,status,sod,gyro_rms_rad_s\n";
  for (int i = 0; i < 30; ++i) {
    const bool missing = i < 3 || (10 <= i && i < 20) || i == 29;
    text += fmt::format("{},ok,{},1\n", 100'000'000LL * (i + 1), missing ? "nan" : "0.5");
  }
  write_text(folder.path() / "updates.csv", text);
  FolderRun run;
  run.folder = folder.path();
  const auto series = series_json(run, {.truth = {}, .origin = 100'000'000});
  const auto& sod = series["channels"]["sod"];
  CHECK(sod["t"] == packed_numbers(std::vector{0.3, 0.9, 2.0, 2.8}, 1e-4));
  CHECK(sod["breaks"] == packed_integers(std::vector<std::int64_t>{2}));
  CHECK_FALSE(series["channels"]["gyro_deg_s"].contains("breaks"));
}

TEST_CASE("one update that is far off does not take the resolution of the others") {
  const TemporaryFolder folder;
  std::string text = "t_ns,status,sod\n1000,ok,\n1010,ok,1\n";  // a rate of 10^8 Hz
  for (int i = 1; i <= 300; ++i) text += std::to_string(1010 + 100'000'000LL * i) + ",ok,0.5\n";
  write_text(folder.path() / "updates.csv", text);
  FolderRun run;
  run.folder = folder.path();
  const auto series = series_json(run, {.truth = {}, .origin = 1000});
  CHECK(series["channels"]["rate_hz"]["unit"].get<double>() < 0.05);  // [Hz], of 10
}

TEST_CASE("telemetry cut short loses its last line only") {
  const TemporaryFolder folder;
  write_text(folder.path() / "u.csv", "t_ns,status,sod\n100,ok,0.5\n200,ok,\n300,ok,nan\n150,ok,1\n400,o");
  const auto columns = read_columns(folder.path() / "u.csv");
  REQUIRE(columns.has_value());
  CHECK(columns->t == std::vector<aslio::TimeNs>{100, 200, 300});
  CHECK(columns->numbers.at("sod")[0] == 0.5);
  CHECK(std::isnan(columns->numbers.at("sod")[1]));
  CHECK_FALSE(read_columns(folder.path() / "none.csv").has_value());
}

TEST_CASE("of two columns of one name the first counts, and a time that no clock shows is left out") {
  FolderRun run;
  const TemporaryFolder folder;
  run.folder = folder.path();
  write_text(run.folder / "updates.csv", "t_ns,a,a\n-9000000000000000000,1,1\n100,2,3\n9000000000000000000,1,1\n");
  CHECK(read_columns(run.folder / "updates.csv").value().t == std::vector<aslio::TimeNs>{100});
  CHECK(read_columns(run.folder / "updates.csv").value().numbers.at("a") == std::vector<double>{2});
  CHECK_THAT(series_json(run, {}).dump(), Contains("names the column a twice") && Contains("2 of 3 lines have"));
}

TEST_CASE("a page holds everything, and nothing hostile outside its data") {
  const Fixture fixture;
  const std::string page = make_page(fixture.study(), kBundle);
  CHECK((page == make_page(fixture.study(), kBundle)));
  CHECK_THAT(page.substr(0, 900),
             Contains("default-src 'none'; script-src 'sha256-") && Contains("style-src 'sha256-"));
  CHECK(page.find("http://") == std::string::npos);
  CHECK(page.find("https://") == std::string::npos);
  // One script of data and one that runs: no text has opened or closed another.
  std::size_t scripts = 0, ends = 0;
  for (std::size_t at = page.find("<script"); at != std::string::npos; at = page.find("<script", at + 1)) ++scripts;
  for (std::size_t at = page.find("</script"); at != std::string::npos; at = page.find("</script", at + 1)) ++ends;
  CHECK((scripts == 2 && ends == 2));
  CHECK(page.find("<img") == std::string::npos);
  CHECK(page.find("<!--") == std::string::npos);
  const auto json = data_of(page);
  CHECK(json["runs"].size() == 11);
  CHECK(json["shown"] == 10);
  CHECK(json["configs"].size() == 2);
  CHECK(json["courses"]["loop_1"].contains("map"));
}

TEST_CASE("a page that is full shows the first recording of every sequence before the second") {
  const Fixture fixture;
  const StudyFolder study = fixture.study();
  const auto all = data_of(make_page(study, kBundle, {.bytes = 120'000, .map_points = 100}));
  const std::size_t shown = all["shown"];
  INFO(shown);
  REQUIRE((shown > 1 && shown < 10));
  CHECK(all["left_out"].empty());
  CHECK(all["runs"][0].contains("series"));
  CHECK_FALSE(all["runs"][7].contains("series"));
}

TEST_CASE("without its script the page tells what to install") {
  const TemporaryFolder folder;
  write_text(folder.path() / "missing.txt", "no answer\nmore\n");
  try {
    read_bundle(folder.path());
    FAIL("no error");
  } catch (const aslio::DataError& error) {
    CHECK_THAT(error.what(),
               Contains("no answer.") && Contains("npm_config_registry") && Contains("--format md,tex,csv"));
  }
  write_text(folder.path() / "report.js", "'</script>'");
  write_text(folder.path() / "report.css", "");
  CHECK_THROWS_AS(read_bundle(folder.path()), aslio::DataError);
}

TEST_CASE("a page keeps its limit, and says what it has left out for that") {
  const TemporaryFolder folder;
  std::string lines = "data,sequence,seed,order_seed,method,status,reason,ate_m\n";
  for (int k = 1; k <= 60; ++k) {
    const std::string name = "x_" + std::to_string(k);
    lines += name + ",x," + std::to_string(k) + ",0,m,ok,,0.1\n";
    const auto run = folder.path() / "runs" / name / "m";
    std::filesystem::create_directories(run);
    write_text(run / "manifest.json", "{\"cpu\": \"" + std::string(2000, 'c') +
                                          "\", \"input\": {\"start_s\": 0, \"path\": \"" + name +
                                          std::string(1000, 'p') + "\"}}\n");
    write_text(run / "resolved.yaml", "schema: aslio/pipeline/1\nfile: " + name + std::string(1000, 'r') + "\n");
  }
  write_text(folder.path() / "results.csv", lines);
  const StudyFolder study = read_study_folder(folder.path());
  const std::string whole = make_page(study, kBundle, {});
  CHECK_THAT(whole, Contains("\"left_out\":[]"));
  CHECK(whole.size() < 170'000);  // 60 x 1000 twice, and the CPU once
  CHECK_THAT(whole, Contains("\"manifest\":{\"input\":{\"path\":\"x_7p"));
  const std::string smaller = make_page(study, kBundle, {.bytes = 110'000});
  CHECK(smaller.size() <= 110'000);
  CHECK_THAT(smaller, Contains("the manifests of single runs") && !Contains("x_7ppp") && Contains("x_7rrr"));
  const std::string small = make_page(study, kBundle, {.bytes = 40'000});
  CHECK(small.size() <= 40'000);
  CHECK_THAT(small, Contains("all but the first run of a method") && Contains("x_1rrr") && !Contains("x_7rrr"));
  CHECK_THAT(make_page(study, kBundle, {.bytes = 1'000}), Contains("larger than --limit"));
}
