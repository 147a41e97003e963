// study.json: what programs read of a study. table.md has the same for people.
#include <algorithm>
#include <nlohmann/json.hpp>

#include "aslio/experiment/study_expectation.hpp"
#include "aslio/experiment/study_results.hpp"
#include "aslio/experiment/study_statistics.hpp"

namespace aslio::experiment {

namespace {

using Json = nlohmann::ordered_json;

Json methods_json(const Study& study) {
  Json out = Json::array();
  for (std::size_t m = 0; m < study.methods.size(); ++m) {
    const StudyMethod& method = study.methods[m];
    const std::string label = method_label(study, method);
    Json json = {{"name", method.name}, {"label", label.empty() ? Json(nullptr) : Json(label)}};
    json["baseline"] = nullptr;
    json["differs"] = Json::array();
    if (study.baseline[m]) {
      const StudyMethod& baseline = study.methods[*study.baseline[m]];
      json["baseline"] = baseline.name;
      json["differs"] = differing_keys(method, baseline);
    }
    out.push_back(std::move(json));
  }
  return out;
}

Json expectation_json(const std::vector<JudgedRule>& rules) {
  if (rules.empty()) return nullptr;
  Json out = {{"overall", to_text(overall(rules))}, {"rules", Json::array()}};
  for (const JudgedRule& rule : rules) {
    out["rules"].push_back({{"text", rule.text}, {"verdict", to_text(rule.verdict)}, {"open", rule.open}});
  }
  return out;
}

}  // namespace

std::string study_json(const Study& study, const std::vector<StudyRun>& runs,
                       const std::vector<std::optional<StudyRow>>& rows) {
  const StudyConfig& config = study.config;
  const auto done = std::count_if(rows.begin(), rows.end(), [](const auto& row) { return row.has_value(); });
  Json identical = Json::array();
  for (const IdenticalMethods& same : identical_methods(study, runs, rows)) {
    identical.push_back(identical_text(study, same));
  }
  for (const std::string& line : identical_orders(study, runs, rows)) identical.push_back(line);
  const StudyFigures figures(study, runs, rows);
  const Json json = {{"schema", kStudyJsonSchema},
                     {"name", study.name},
                     {"question", one_line(config.question)},
                     {"prediction", one_line(config.prediction)},
                     {"rule", one_line(config.rule)},
                     {"planned", runs.size()},
                     {"done", done},
                     {"metrics", config.metrics},
                     {"methods", methods_json(study)},
                     {"expectation", expectation_json(judge_expectation(study, runs, rows, figures))},
                     {"identical", identical}};
  // A name in another encoding must not lose the file.
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace aslio::experiment
