// Outcomes of runs, and results.csv.
#include "aslio/experiment/study_results.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <nlohmann/json.hpp>

#include "aslio/experiment/measure.hpp"
#include "aslio/io/writers.hpp"
#include "read_json.hpp"

namespace aslio::experiment {

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr const char* kKeyFile = "run_key.json";

std::string text_of(const Json& json, const char* key) {
  const auto at = json.find(key);
  return at != json.end() && at->is_string() ? at->get<std::string>() : std::string();
}

std::optional<double> number_of(const Json& json, const char* key) {
  const auto at = json.find(key);
  return at != json.end() && at->is_number() ? std::optional(at->get<double>()) : std::nullopt;
}

std::string cell(const std::string& text) {
  if (text.find_first_of(",\"\n\r") == std::string::npos) return text;
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"') out += '"';
    out += c == '\n' || c == '\r' ? ' ' : c;
  }
  return out + '"';
}

/// Names of all figures, in the order in which the rows bring them up.
std::vector<std::string> figure_names(const std::vector<std::optional<StudyRow>>& rows) {
  std::vector<std::string> names;
  for (const auto& row : rows) {
    if (!row) continue;
    for (const auto& [name, value] : row->figures) {
      if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
    }
  }
  return names;
}

}  // namespace

std::optional<double> StudyRow::figure(std::string_view name) const {
  const auto at = std::find_if(figures.begin(), figures.end(), [&](const auto& f) { return f.first == name; });
  return at != figures.end() ? std::optional(at->second) : std::nullopt;
}

bool StudyOutcome::stands(const StudyConfig& config) const {
  if (!final) return false;
  if (status == "timeout") return config.time_limit > 0 && config.time_limit <= limit;
  if (status == "memory") return config.memory_limit > 0 && config.memory_limit <= limit;
  return true;
}

bool failed_late(std::string_view status, const std::optional<double>& failed_at) {
  return failed_at ? *failed_at >= kEarlyShare : status == "diverged";
}

void write_outcome(const fs::path& folder, const std::string& key, const StudyOutcome& outcome) {
  const Json json = {{"key", key},
                     {"status", outcome.status},
                     {"reason", outcome.reason},
                     {"wall_s", outcome.wall_s},
                     {"final", outcome.final},
                     {"limit", outcome.limit}};
  io::AtomicFile file(folder / kKeyFile);
  file.write(json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n");
  file.close_durably();
}

std::optional<StudyOutcome> read_outcome(const fs::path& folder, const std::string& key) {
  const auto json = read_json(folder / kKeyFile);
  if (!json || (!key.empty() && text_of(*json, "key") != key)) return std::nullopt;
  const auto final = json->find("final");
  const StudyOutcome outcome{.status = text_of(*json, "status"),
                             .reason = text_of(*json, "reason"),
                             .wall_s = number_of(*json, "wall_s").value_or(0),
                             .final = final != json->end() && final->is_boolean() && final->get<bool>(),
                             .limit = number_of(*json, "limit").value_or(0)};
  if (outcome.status.empty()) return std::nullopt;
  const bool has_summary = outcome.status != "crashed" && outcome.status != "timeout" && outcome.status != "memory";
  if (outcome.final && has_summary && !read_json(folder / "summary.json")) return std::nullopt;
  return outcome;
}

std::optional<StudyOutcome> read_summary_outcome(const fs::path& folder) {
  const auto json = read_json(folder / "summary.json");
  if (!json) return std::nullopt;
  StudyOutcome outcome{
      .status = text_of(*json, "status"), .reason = text_of(*json, "reason"), .wall_s = 0, .final = false};
  if (outcome.status.empty()) return std::nullopt;
  const auto metrics = json->find("metrics");
  if (outcome.reason.empty() && metrics != json->end() && metrics->is_object())
    outcome.reason = text_of(*metrics, "error");
  return outcome;
}

StudyRow read_row(const fs::path& folder, const StudyOutcome& outcome) {
  StudyRow row{.outcome = outcome, .figures = {}};
  // What it got to before a limit depends on the machine.
  if (outcome.limit) return row;
  const auto json = read_json(folder / "summary.json");
  if (!json) return row;
  const auto add = [&row](const std::string& name, std::optional<double> value) {
    if (value) row.figures.emplace_back(name, *value);
  };
  if (const auto metrics = json->find("metrics"); metrics != json->end() && metrics->is_object()) {
    for (const auto& [name, value] : metrics->items()) {
      if (value.is_number()) add(name, value.get<double>());
    }
  }
  for (const char* name : {"coverage", "updates", "weak_share", "peak_rss_mb", "path_length_m"}) {
    add(name, number_of(*json, name));
  }
  if (const auto rate = json->find("rate_hz"); rate != json->end() && rate->is_object()) {
    add("rate_hz", number_of(*rate, "median"));
  }
  const auto cpu = number_of(*json, "cpu_s"), data = number_of(*json, "data_s");
  if (cpu && data && *data > 0) add("cpu_s_per_s", *cpu / *data);
  return row;
}

std::string results_csv(const Study& study, const std::vector<StudyRun>& runs,
                        const std::vector<std::optional<StudyRow>>& rows) {
  const std::vector<std::string> figures = figure_names(rows);
  std::string text = "data,sequence,seed,order_seed,method";
  const auto out = std::back_inserter(text);
  for (const std::string& axis : study.axes) fmt::format_to(out, ",{}", cell(axis));
  text += ",status,reason";
  for (const std::string& name : figures) fmt::format_to(out, ",{}", cell(name));
  text += '\n';
  for (std::size_t i = 0; i < runs.size(); ++i) {
    if (!rows[i]) continue;
    const StudyData& data = study.data[runs[i].data];
    const StudyMethod& method = study.methods[runs[i].method];
    fmt::format_to(out, "{},{},{},{},{}", data.name, data.sequence, data.seed ? fmt::to_string(*data.seed) : "",
                   runs[i].order_seed, method.name);
    for (const std::string& value : method.axes) fmt::format_to(out, ",{}", cell(value));
    fmt::format_to(out, ",{},{}", cell(rows[i]->outcome.status), cell(rows[i]->outcome.reason));
    for (const std::string& name : figures) {
      const auto value = rows[i]->figure(name);
      fmt::format_to(out, ",{}", value ? fmt::to_string(*value) : "");
    }
    text += '\n';
  }
  return text;
}

}  // namespace aslio::experiment
