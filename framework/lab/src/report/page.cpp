#include "aslio/report/page.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "aslio/config/document.hpp"
#include "aslio/config/node.hpp"
#include "aslio/core/errors.hpp"
#include "aslio/core/sha256.hpp"
#include "aslio/experiment/version.hpp"
#include "aslio/io/json.hpp"
#include "aslio/io/markup.hpp"
#include "aslio/report/encode.hpp"
#include "aslio/report/run_series.hpp"
#include "aslio/report/table.hpp"

namespace aslio::report {

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr std::size_t kFrameBytes = 4'000;  // of the page, around style, script and study

Json cell_json(const Cell& cell) {
  constexpr std::array<const char*, 4> kMarks = {"value", "diverged", "failed", "absent"};
  Json json = {
      {"mark", kMarks[static_cast<std::size_t>(cell.mark)]}, {"runs", cell.runs}, {"recordings", cell.recordings}};
  if (cell.mark == Mark::value) json["median"] = cell.median;
  if (cell.with_figure > 0) json["range"] = {cell.min, cell.max};
  if (cell.failed > 0) json["failed"] = cell.failed;
  if (cell.diverged > 0) json["diverged"] = cell.diverged;
  if (cell.rank != Rank::none) json["rank"] = cell.rank == Rank::best ? 1 : 2;
  return json;
}

Json comparison_json(const Comparison& comparison) {
  const auto tally = [](const Tally& t) { return Json{t.won, t.lost, t.tied}; };
  Json json = {{"method", comparison.method},
               {"baseline", comparison.baseline},
               {"sequences", tally(comparison.sequences)},
               {"pairs", tally(comparison.pairs)}};
  if (comparison.ratio) json["ratio"] = std::isfinite(*comparison.ratio) ? Json(*comparison.ratio) : Json("x");
  Json more = Json::array();
  for (const Statistic& statistic : comparison.more) more.push_back({statistic.name, statistic.text});
  json["more"] = more;
  return json;
}

Json tables_json(const StudyFolder& study) {
  std::vector<std::string> names = study.metrics;
  for (const std::string& figure : study.figures) {
    if (std::find(names.begin(), names.end(), figure) == names.end()) names.push_back(figure);
  }
  Json json = Json::array();
  for (const MetricTable& table : make_tables(study, names)) {
    const Metric& metric = table.metric;
    Json lines = Json::array(), comparisons = Json::array();
    for (const Line& line : table.lines) {
      Json cells = Json::array();
      for (const Cell& cell : line.cells) cells.push_back(cell_json(cell));
      lines.push_back({{"sequence", line.sequence}, {"cells", cells}});
    }
    for (const Comparison& comparison : table.comparisons) comparisons.push_back(comparison_json(comparison));
    json.push_back({{"metric", metric.name},
                    {"title", metric.title},
                    {"unit", metric.unit},
                    {"scale", metric.scale},
                    {"smaller", metric.smaller_is_better},
                    {"decimals", metric.decimals},
                    {"lines", lines},
                    {"comparisons", comparisons}});
  }
  return json;
}

void flatten(const config::Node& node, const std::string& path, Json& out) {
  if (node.is_map() && !node.members().empty()) {
    for (const config::Member& member : node.members()) {
      flatten(member.value, path.empty() ? member.key : path + "." + member.key, out);
    }
  } else if (node.is_list() &&
             std::any_of(node.items().begin(), node.items().end(), [](const config::Node& n) { return n.is_map(); })) {
    for (std::size_t i = 0; i < node.items().size(); ++i) flatten(node.items()[i], fmt::format("{}.{}", path, i), out);
  } else {
    out.push_back({path, config::to_line(node)});
  }
}

/// Resolved pipelines as [path, value] lists, each once.
class Configs {
 public:
  Json index_of(const fs::path& file) {
    const auto text = read_file(file);
    if (!text) return nullptr;
    const auto [at, added] = known_.try_emplace(*text, known_.size());
    if (added) {
      Json values = Json::array();
      try {
        flatten(config::parse_document(*text, file.string()), "", values);
      } catch (const ConfigError&) {
        values.push_back({"resolved.yaml", "cannot be read"});
      }
      list_.push_back(std::move(values));
    }
    return at->second;
  }
  Json take() { return std::move(list_); }

 private:
  std::map<std::string, std::size_t> known_;
  Json list_ = Json::array();
};

/// What of a run could not be read stands beside its status: one that is `ok` would be taken for whole.
void add_note(Json& run, const std::string& note) {
  const std::string reason = run["reason"].get<std::string>();
  run["reason"] = reason.empty() ? note : reason + "; " + note;
}

/// Nothing when the file is not there; one that is no JSON object is noted.
std::optional<Json> object_of(Json& run, const fs::path& file, std::vector<std::string>& unreadable) {
  const auto text = read_file(file);
  if (!text) return std::nullopt;
  auto json = io::parse_json(*text);
  if (json && json->is_object()) return json;
  const std::string name = file.filename().string();
  unreadable.push_back(file.string() + ": it is no JSON object");
  // single_runs() has told it.
  if (run["reason"].get<std::string>().find(name) == std::string::npos) add_note(run, name + ": it is no JSON object");
  return std::nullopt;
}

Json run_json(const FolderRun& run, Configs& configs, std::vector<std::string>& unreadable) {
  Json json = {{"data", run.data},     {"sequence", run.sequence}, {"seed", run.seed},     {"order", run.order_seed},
               {"method", run.method}, {"axes", run.axes},         {"status", run.status}, {"reason", run.reason}};
  Json figures = Json::array();
  for (const auto& figure : run.figures) figures.push_back(figure ? Json(*figure) : Json(nullptr));
  json["figures"] = figures;
  json["config"] = configs.index_of(run.folder / "resolved.yaml");
  if (const auto manifest = object_of(json, run.folder / "manifest.json", unreadable)) json["manifest"] = *manifest;
  if (const auto summary = object_of(json, run.folder / "summary.json", unreadable)) {
    for (const char* key : {"initialisation", "notes", "weak_updates"}) {
      if (summary->contains(key)) json["summary"][key] = (*summary)[key];
    }
    const auto calibration = summary->find("calibration");
    if (calibration != summary->end() && calibration->is_object()) {
      const auto text = calibration->find("text");
      if (text != calibration->end() && text->is_string()) json["summary"]["calibration"] = *text;
    }
  }
  return json;
}

/// The order in which runs get their share of the page: the first recording of every sequence before the second.
std::vector<std::size_t> by_importance(const StudyFolder& study) {
  std::map<std::string, std::vector<std::string>> data_of;
  std::vector<std::pair<std::size_t, std::size_t>> order;
  for (std::size_t i = 0; i < study.runs.size(); ++i) {
    auto& names = data_of[study.runs[i].sequence];
    const std::string name = study.runs[i].data + "/" + study.runs[i].order_seed;
    auto at = std::find(names.begin(), names.end(), name);
    if (at == names.end()) at = names.insert(names.end(), name);
    order.emplace_back(static_cast<std::size_t>(at - names.begin()), i);
  }
  std::sort(order.begin(), order.end());
  std::vector<std::size_t> runs;
  for (const auto& [rank, run] : order) runs.push_back(run);
  return runs;
}

/// What two objects have in common: members of the same value, and so on inside members that are objects in both.
Json common_part(const Json& a, const Json& b) {
  Json out = Json::object();
  for (const auto& [key, value] : a.items()) {
    const auto at = b.find(key);
    if (at == b.end()) continue;
    if (value == *at) {
      out[key] = value;
    } else if (value.is_object() && at->is_object()) {
      if (Json inside = common_part(value, *at); !inside.empty()) out[key] = std::move(inside);
    }
  }
  return out;
}

/// An object without what it has in common with the others.
Json rest_of(const Json& whole, const Json& common) {
  Json out = Json::object();
  for (const auto& [key, value] : whole.items()) {
    const auto at = common.find(key);
    if (at == common.end()) {
      out[key] = value;
    } else if (value != *at) {
      out[key] = rest_of(value, *at);
    }
  }
  return out;
}

/// The manifests of hundreds of runs are nearly one and the same: what they share stands once, as `manifest`.
void share_manifests(Json& json) {
  std::optional<Json> common;
  for (const Json& run : json["runs"]) {
    if (run.contains("manifest")) common = common ? common_part(*common, run["manifest"]) : run["manifest"];
  }
  if (!common) return;
  for (Json& run : json["runs"]) {
    if (run.contains("manifest")) run["manifest"] = rest_of(run["manifest"], *common);
  }
  json["manifest"] = std::move(*common);
}

/// Only that of the first run of a method is ever shown.
void drop_configs(Json& json) {
  std::set<std::string> seen;
  Json kept = Json::array();
  for (Json& run : json["runs"]) {
    if (run["config"].is_null()) continue;
    if (!seen.insert(run["method"].get<std::string>()).second) {
      run["config"] = nullptr;
      continue;
    }
    kept.push_back(json["configs"][run["config"].get<std::size_t>()]);
    run["config"] = kept.size() - 1;
  }
  json["configs"] = std::move(kept);
}

/// What is least needed goes first, until the study fits without any course; the page says what has gone. The bytes
/// that are left.
std::size_t fit(Json& json, std::size_t bytes) {
  const auto room = [&] {
    const std::size_t size = script_safe(json).size();
    return bytes > size ? bytes - size : 0;
  };
  json["left_out"] = Json::array();
  std::size_t left = room();
  const auto drop = [&](const char* what, const auto& act) {
    if (left > 0) return;
    act();
    json["left_out"].push_back(what);
    left = room();
  };
  drop("the manifests of single runs", [&] {
    for (Json& run : json["runs"]) {
      if (run.contains("manifest")) run["manifest"] = Json::object();
    }
  });
  drop("configurations of all but the first run of a method", [&] { drop_configs(json); });
  drop("the tables as LaTeX and Markdown", [&] { json["latex"] = json["markdown"] = ""; });
  drop("notes of single runs", [&] {
    for (Json& run : json["runs"]) run.erase("summary");
  });
  if (left == 0) json["left_out"].push_back("and still the tables alone are larger than --limit");
  return left;
}

std::size_t size_of(const Json& json) { return json.dump(-1, ' ', false, Json::error_handler_t::replace).size(); }

/// Course of a run, null where there is none. What of its files could not be read is noted at the run, as far as that
/// fits, and taken from the bytes that are left; all of it is added to `unreadable`.
Json course_json(const FolderRun& run, const DataTruth& truth, Json& at_page, std::size_t& left,
                 std::vector<std::string>& unreadable) {
  Json series = series_json(run, truth);
  if (series.is_null()) return series;
  if (const auto notes = series.find("notes"); notes != series.end()) {
    for (const Json& note : *notes) {
      unreadable.push_back(fmt::format("{}: {}", run.folder.string(), note.get<std::string>()));
    }
    for (const Json& note : *notes) {
      const std::size_t bytes = script_safe(note).size() + 2;
      if (bytes > left) break;
      left -= bytes;
      add_note(at_page, note.get<std::string>());
    }
    series.erase("notes");
  }
  if (series["channels"].empty() && !series.contains("path")) return nullptr;
  return series;
}

/// Courses of the runs, as many as fit, with what belongs to their recordings.
void put_courses(Json& json, const StudyFolder& study, const PageLimits& limits, std::size_t left,
                 std::vector<std::string>& unreadable) {
  std::size_t shown = 0;
  std::map<std::string, DataTruth> truths;
  Json data = Json::object();
  for (const std::size_t i : by_importance(study)) {
    const FolderRun& run = study.runs[i];
    if (!truths.contains(run.data)) truths[run.data] = read_truth(study, run.data);
    const DataTruth& truth = truths.at(run.data);
    Json series = course_json(run, truth, json["runs"][i], left, unreadable);
    if (series.is_null()) continue;
    std::size_t bytes = size_of(series);
    Json recording;
    if (!data.contains(run.data)) {
      recording = data_json(study, run.data, truth);
      if (const auto note = recording.find("unreadable"); note != recording.end()) {
        unreadable.push_back(note->get<std::string>());
      }
      bytes += size_of(recording);
    }
    if (bytes > left) break;
    left -= bytes;
    ++shown;
    json["runs"][i]["series"] = std::move(series);
    if (!recording.is_null()) data[run.data] = std::move(recording);
    if (data[run.data].contains("map")) continue;
    Json map = map_json(run, truth, limits.map_points);
    const std::size_t size = map.is_null() ? left + 1 : size_of(map);
    if (size > left) continue;
    left -= size;
    data[run.data]["map"] = std::move(map);
  }
  json["courses"] = std::move(data);
  json["shown"] = shown;
}

/// `bytes`: for all of it.
Json study_json(const StudyFolder& study, const PageLimits& limits, std::size_t bytes,
                std::vector<std::string>& unreadable) {
  Json baselines = Json::array();
  for (const auto& baseline : study.baseline) baselines.push_back(baseline ? Json(*baseline) : Json(nullptr));
  Json json = {{"format", 1},
               {"made_by", fmt::format("aslio {}", experiment::version())},
               {"revision", experiment::source_revision()},
               {"name", study.name},
               {"question", study.question},
               {"prediction", study.prediction},
               {"rule", study.rule},
               {"verdict", study.verdict},
               {"expectation", study.expectation},
               {"incomplete", study.incomplete},
               {"identical", study.identical},
               {"planned", study.planned.value_or(study.runs.size())},
               {"axes", study.axes},
               {"methods", study.methods},
               {"labels", study.labels},
               {"baselines", baselines},
               {"sequences", study.sequences},
               {"data", study.data},
               {"metrics", study.metrics},
               {"figures", study.figures},
               {"tables", tables_json(study)},
               {"latex", to_latex(study)},
               {"markdown", to_markdown(study)}};
  Configs configs;
  Json runs = Json::array();
  for (const FolderRun& run : study.runs) runs.push_back(run_json(run, configs, unreadable));
  json["runs"] = std::move(runs);
  json["configs"] = configs.take();
  share_manifests(json);
  put_courses(json, study, limits, fit(json, bytes), unreadable);
  return json;
}

/// 'sha256-..' as a content security policy names a text.
std::string policy_hash(const std::string& text) {
  const std::string hex = sha256_of(text);
  std::vector<std::uint8_t> bytes;
  for (std::size_t i = 0; i + 1 < hex.size(); i += 2) {
    std::uint8_t byte = 0;
    std::from_chars(hex.data() + i, hex.data() + i + 2, byte, 16);
    bytes.push_back(byte);
  }
  return fmt::format("'sha256-{}'", io::base64(bytes));
}

}  // namespace

Bundle read_bundle(const fs::path& folder) {
  const auto script = read_file(folder / "report.js"), style = read_file(folder / "report.css");
  if (!script || !style) {
    const std::string reason = read_file(folder / "missing.txt").value_or("");
    throw DataError(
        fmt::format("{}: report.js and report.css are missing, the page cannot be made{}{}. Give the build access to "
                    "the npm registry (or set npm_config_registry) and build aslio again; -DASLIO_REPORT=ON shows what "
                    "fails. --format md,tex,csv works without",
                    folder.string(), reason.empty() ? "" : ": ", reason.substr(0, reason.find('\n'))));
  }
  if (script->find("</script") != std::string::npos || style->find("</style") != std::string::npos) {
    throw DataError(fmt::format("{}: the script or style would end its own element; build it again", folder.string()));
  }
  return {*script, *style};
}

std::string make_page(const StudyFolder& study, const Bundle& bundle, const PageLimits& limits,
                      std::vector<std::string>* unreadable) {
  std::vector<std::string> problems;
  std::string page = fmt::format(
      "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; script-src {}; style-src {}; "
      "img-src data: blob:; base-uri 'none'; form-action 'none'; require-trusted-types-for 'script'\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
      "<meta name=\"referrer\" content=\"no-referrer\">\n<title>{}</title>\n<style>",
      policy_hash(bundle.script), policy_hash(bundle.style), io::html_escaped(study.name));
  page += bundle.style;
  page +=
      "</style>\n</head>\n<body>\n<noscript>This page draws its tables and figures with its own script; allow scripts "
      "to see them, or use `aslio report --format md`.</noscript>\n<div id=\"report\"></div>\n<script "
      "type=\"application/json\" id=\"study\">";
  const std::size_t frame = bundle.script.size() + bundle.style.size() + kFrameBytes;
  page += script_safe(study_json(study, limits, limits.bytes > frame ? limits.bytes - frame : 0, problems));
  if (unreadable != nullptr) unreadable->insert(unreadable->end(), problems.begin(), problems.end());
  page += "</script>\n<script>";
  page += bundle.script;
  page += "</script>\n</body>\n</html>\n";
  return page;
}

}  // namespace aslio::report
