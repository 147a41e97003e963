#include "aslio/report/study_folder.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "aslio/core/csv.hpp"
#include "aslio/core/errors.hpp"
#include "aslio/core/input_file.hpp"
#include "aslio/experiment/study_results.hpp"
#include "aslio/io/json.hpp"

namespace aslio::report {

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr std::array<std::string_view, 5> kFixedColumns = {"data", "sequence", "seed", "order_seed", "method"};

std::optional<std::size_t> index_of(const std::vector<std::string>& names, std::string_view name) {
  const auto at = std::find(names.begin(), names.end(), name);
  return at != names.end() ? std::optional(static_cast<std::size_t>(at - names.begin())) : std::nullopt;
}

void add_once(std::vector<std::string>& names, const std::string& name) {
  if (!index_of(names, name)) names.push_back(name);
}

/// Nothing for an empty cell; throws DataError for anything else that is no finite number.
std::optional<double> figure_of(const std::string& text, const std::string& where) {
  if (text.empty()) return std::nullopt;
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size()) {
    throw DataError(fmt::format("{}: '{}' is no number", where, text.substr(0, 60)));
  }
  return std::isfinite(value) ? std::optional(value) : std::nullopt;
}

/// A name that is one component of a path, so that nothing outside the folder is read.
const std::string& component(const std::string& name, const std::string& where) {
  if (name.empty() || name == "." || name == ".." || name.find('/') != std::string::npos ||
      name.find('\0') != std::string::npos) {
    throw DataError(fmt::format("{}: '{}' is no name of a folder", where, name.substr(0, 60)));
  }
  return name;
}

/// A part of the name of a folder, too.
const std::string& digits(const std::string& number, const std::string& where) {
  if (number.find_first_not_of("0123456789") != std::string::npos) {
    throw DataError(fmt::format("{}: '{}' is no order_seed", where, number.substr(0, 60)));
  }
  return number;
}

struct Header {
  std::size_t status = 0;
};

Header read_header(const std::vector<std::string>& names, const fs::path& file) {
  const bool begins =
      names.size() > kFixedColumns.size() && std::equal(kFixedColumns.begin(), kFixedColumns.end(), names.begin());
  const auto status = index_of(names, "status");
  if (!begins || !status || *status + 1 >= names.size() || names[*status + 1] != "reason") {
    throw DataError(
        fmt::format("{}:1: the columns are not those of `aslio experiment` (data, sequence, seed, "
                    "order_seed, method, .. status, reason, ..): name its output folder",
                    file.string()));
  }
  return {*status};
}

FolderRun run_of(const std::vector<std::string>& cells, const Header& header, const fs::path& folder,
                 const std::string& where) {
  FolderRun run{.data = component(cells[0], where),
                .sequence = cells[1],
                .seed = cells[2],
                .order_seed = digits(cells[3], where),
                .method = component(cells[4], where),
                .axes = {},
                .status = cells[header.status],
                .reason = cells[header.status + 1],
                .figures = {},
                .folder = {}};
  for (std::size_t i = kFixedColumns.size(); i < header.status; ++i) run.axes.push_back(cells[i]);
  for (std::size_t i = header.status + 2; i < cells.size(); ++i) run.figures.push_back(figure_of(cells[i], where));
  const bool plain = run.order_seed.empty() || run.order_seed == "0";
  run.folder = folder / "runs" / run.data / (plain ? run.method : run.method + "_order_" + run.order_seed);
  return run;
}

void read_runs(StudyFolder& study, const fs::path& file, const std::string& text) {
  const CsvTable table = parse_csv(text, file);
  if (table.header.empty()) throw DataError(fmt::format("{}: empty; run the study first", file.string()));
  const Header header = read_header(table.header, file);
  const auto at = [](std::size_t i) { return static_cast<std::ptrdiff_t>(i); };
  study.axes.assign(table.header.begin() + at(kFixedColumns.size()), table.header.begin() + at(header.status));
  study.figures.assign(table.header.begin() + at(header.status + 2), table.header.end());
  for (std::size_t i = 0; i < table.rows.size(); ++i) {
    study.runs.push_back(
        run_of(table.rows[i], header, study.folder, fmt::format("{}:{}", file.string(), table.lines[i])));
  }
}

/// The text of a member; empty where it is none.
std::string text_of(const Json& json, const char* name) {
  const auto at = json.find(name);
  return at != json.end() && at->is_string() ? at->get<std::string>() : std::string();
}

/// The members of a list that are texts.
std::vector<std::string> texts_of(const Json& json, const char* name) {
  std::vector<std::string> out;
  const auto at = json.find(name);
  if (at == json.end() || !at->is_array()) return out;
  for (const Json& item : *at) {
    if (item.is_string()) out.push_back(item.get<std::string>());
  }
  return out;
}

void take_method(StudyFolder& study, const Json& json) {
  if (!json.is_object()) return;
  const auto method = study.method(text_of(json, "name")), other = study.method(text_of(json, "baseline"));
  if (!method) return;
  const std::string label = text_of(json, "label");
  if (!label.empty()) study.labels[*method] = label;
  if (other) study.baseline[*method] = other;
}

void take_rules(StudyFolder& study, const Json& expectation) {
  if (!expectation.is_object()) return;
  const auto rules = expectation.find("rules");
  if (rules == expectation.end() || !rules->is_array()) return;
  for (const Json& rule : *rules) {
    if (!rule.is_object()) continue;
    const std::string open = text_of(rule, "open");
    study.expectation.push_back(fmt::format("{}: **{}**{}", text_of(rule, "text"), text_of(rule, "verdict"),
                                            open.empty() ? open : fmt::format(" ({})", open)));
  }
}

/// Throws DataError for a file that is there and is none of ours.
void read_study_json(StudyFolder& study) {
  const fs::path file = study.folder / "study.json";
  const auto text = read_file(file);
  if (!text) {
    if (!read_file(study.folder / "results.csv")) return;  // single runs
    study.incomplete =
        "study.json is missing: the folder is of an older version. Run `aslio experiment` with it again, which keeps "
        "the runs and writes it.";
    return;
  }
  const auto json = io::parse_json(*text);
  if (!json || !json->is_object() || text_of(*json, "schema") != experiment::kStudyJsonSchema) {
    throw DataError(
        fmt::format("{}: is no JSON of schema {}: run `aslio experiment` with this output folder again, which "
                    "keeps the runs and writes it",
                    file.string(), experiment::kStudyJsonSchema));
  }
  study.name = text_of(*json, "name");
  study.question = text_of(*json, "question");
  study.prediction = text_of(*json, "prediction");
  study.rule = text_of(*json, "rule");
  if (const auto planned = json->find("planned"); planned != json->end() && planned->is_number_unsigned()) {
    study.planned = planned->get<std::size_t>();
  }
  for (const std::string& metric : texts_of(*json, "metrics")) {
    if (study.figure(metric)) add_once(study.metrics, metric);
  }
  if (const auto methods = json->find("methods"); methods != json->end() && methods->is_array()) {
    for (const Json& method : *methods) take_method(study, method);
  }
  if (const auto expectation = json->find("expectation"); expectation != json->end()) take_rules(study, *expectation);
  study.identical = texts_of(*json, "identical");
}

/// A study of an older version has none; numbers that are none are left out.
void read_statistics(StudyFolder& study) {
  const fs::path file = study.folder / "statistics.csv";
  const CsvTable table = parse_csv(read_file(file).value_or(""), file);
  const auto text = [&](const std::vector<std::string>& cells, std::string_view name) -> std::string {
    const auto at = index_of(table.header, name);
    return at ? cells[*at] : std::string();
  };
  for (const auto& row : table.rows) {
    if (text(row, "baseline").empty()) continue;
    const auto value = [&](std::string_view name) -> std::optional<double> {
      const std::string cell = text(row, name);
      double number = 0;
      const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), number);
      return error == std::errc{} && end == cell.data() + cell.size() && !std::isnan(number) ? std::optional(number)
                                                                                             : std::nullopt;
    };
    study.statistics.push_back({.metric = text(row, "metric"),
                                .method = text(row, "method"),
                                .low = value("low"),
                                .high = value("high"),
                                .effect = value("effect"),
                                .p = value("p"),
                                .p_holm = value("p_holm"),
                                .p_sequences = value("p_sequences")});
  }
}

void read_texts(StudyFolder& study) {
  for (const FolderRun& run : study.runs) {
    add_once(study.data, run.data);
    add_once(study.sequences, run.sequence);
    add_once(study.methods, run.method);
  }
  study.baseline.resize(study.methods.size());
  study.labels = study.methods;
  study.verdict = read_file(study.folder / "verdict.md").value_or("");
  read_study_json(study);
  if (study.name.empty()) study.name = fs::weakly_canonical(study.folder).filename().string();
  if (study.metrics.empty()) {
    for (const char* metric : {"ate_m", "ate_deg", "end_to_end_m"}) {
      if (study.figure(metric)) study.metrics.emplace_back(metric);
    }
  }
}

/// Folders of single runs: the folder itself, or those in it.
std::vector<fs::path> run_folders(const fs::path& folder) {
  std::error_code error, ignored;
  if (fs::exists(folder / "summary.json", error)) return {folder};
  std::set<fs::path> found;
  for (auto at = fs::directory_iterator(folder, error); !error && at != fs::directory_iterator(); at.increment(error)) {
    if (fs::exists(at->path() / "summary.json", ignored)) found.insert(at->path());
  }
  return {found.begin(), found.end()};
}

/// Outcome of a run; of one whose summary.json tells none a failure with the reason: it must not be missing from a
/// page.
experiment::StudyOutcome outcome_of(const fs::path& folder) {
  if (auto outcome = experiment::read_summary_outcome(folder)) return *outcome;
  const auto text = read_file(folder / "summary.json");
  const auto json = io::parse_json(text.value_or(""));
  const char* problem = !text                       ? "it is no file that can be opened"
                        : text->empty()             ? "it is empty"
                        : json && json->is_object() ? "it names no status"
                                                    : "it is no JSON object";
  return {.status = "failed",
          .reason = fmt::format("summary.json cannot be read: {}; make the run again", problem),
          .wall_s = 0,
          .final = false};
}

/// Runs that no study has made: each sub-folder is a method on one and the same recording.
StudyFolder single_runs(const fs::path& folder) {
  StudyFolder study;
  study.folder = folder;
  std::vector<experiment::StudyRow> rows;
  for (const fs::path& path : run_folders(folder)) {
    const experiment::StudyOutcome outcome = outcome_of(path);
    rows.push_back(experiment::read_row(path, outcome));
    const std::string name = fs::weakly_canonical(path).filename().string();
    study.runs.push_back({.data = "recording",
                          .sequence = "recording",
                          .seed = "",
                          .order_seed = "0",
                          .method = name,
                          .axes = {},
                          .status = outcome.status,
                          .reason = outcome.reason,
                          .figures = {},
                          .folder = path});
    for (const auto& figure : rows.back().figures) add_once(study.figures, figure.first);
  }
  if (study.runs.empty()) {
    throw DataError(
        fmt::format("{}: holds neither results.csv nor a run with summary.json; name the output folder of "
                    "`aslio experiment` or of `aslio run`",
                    folder.string()));
  }
  for (std::size_t i = 0; i < rows.size(); ++i) {
    for (const std::string& name : study.figures) study.runs[i].figures.push_back(rows[i].figure(name));
  }
  return study;
}

}  // namespace

std::optional<std::string> read_file(const fs::path& path) {
  if (!why_no_input(path).empty()) return std::nullopt;
  std::ifstream stream(path, std::ios::binary);
  if (!stream) return std::nullopt;
  std::ostringstream text;
  text << stream.rdbuf();
  return std::move(text).str();
}

std::optional<std::size_t> StudyFolder::method(std::string_view name) const { return index_of(methods, name); }
std::optional<std::size_t> StudyFolder::figure(std::string_view name) const { return index_of(figures, name); }

StudyFolder read_study_folder(const fs::path& folder) {
  const fs::path file = folder / "results.csv";
  StudyFolder study;
  study.folder = folder;
  if (const auto text = read_file(file)) {
    read_runs(study, file, *text);
  } else {
    study = single_runs(folder);
  }
  read_texts(study);
  // One that has just begun has a table of what is to come.
  if (study.runs.empty() && !study.planned) {
    throw DataError(fmt::format("{}: holds no run; run the study first", file.string()));
  }
  read_statistics(study);
  return study;
}

}  // namespace aslio::report
