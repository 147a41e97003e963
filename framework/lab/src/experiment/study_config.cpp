// The keys of a study file.
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "aslio/config/binder.hpp"
#include "aslio/experiment/study.hpp"
#include "aslio/experiment/study_expectation.hpp"

namespace aslio::experiment {

namespace {

constexpr std::size_t kMaxSeeds = 10'000;

std::optional<std::uint64_t> whole_number(std::string_view text) {
  std::uint64_t value = 0;
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc() || stop != end || text.empty()) return std::nullopt;
  return value;
}

/// False: no range, or too many numbers in all.
bool append_range(std::string_view text, std::vector<std::uint64_t>& seeds) {
  const std::size_t dash = text.find('-');
  const auto first = whole_number(text.substr(0, dash));
  const auto last = dash == std::string_view::npos ? first : whole_number(text.substr(dash + 1));
  if (!first || !last || *last < *first || *last - *first >= kMaxSeeds) return false;
  for (std::uint64_t seed = *first;; ++seed) {
    if (std::find(seeds.begin(), seeds.end(), seed) != seeds.end()) return false;
    seeds.push_back(seed);
    if (seed == *last) break;
  }
  return seeds.size() <= kMaxSeeds;
}

template <class T>
bool distinct(std::vector<T> values) {
  std::sort(values.begin(), values.end());
  return std::adjacent_find(values.begin(), values.end()) == values.end();
}

bool whole_and_distinct(const std::vector<double>& values) {
  return distinct(values) && std::all_of(values.begin(), values.end(), [](double v) { return v == std::floor(v); });
}

}  // namespace

const std::vector<std::string>& study_metrics() {
  static const std::vector<std::string> names = {"ate_m",       "ate_deg",     "rpe",        "end_to_end_m",
                                                 "matched",     "coverage",    "updates",    "rate_hz",
                                                 "cpu_s_per_s", "peak_rss_mb", "weak_share", "path_length_m"};
  return names;
}

std::optional<std::vector<std::uint64_t>> parse_seeds(std::string_view text) {
  std::vector<std::uint64_t> seeds;
  while (true) {
    const std::size_t comma = text.find(',');
    if (!append_range(text.substr(0, comma), seeds)) return std::nullopt;
    if (comma == std::string_view::npos) return seeds;
    text.remove_prefix(comma + 1);
  }
}

std::optional<std::vector<std::string>> sequence_patterns(const StudyDataConfig& data) {
  const config::Node& written = data.sequences;
  if (written.is_null()) return std::vector<std::string>{"*"};
  if (written.is_scalar()) return std::vector<std::string>{written.text()};
  if (!written.is_list() || written.items().empty()) return std::nullopt;
  std::vector<std::string> patterns;
  for (const config::Node& item : written.items()) {
    if (!item.is_scalar()) return std::nullopt;
    patterns.push_back(item.text());
  }
  return patterns;
}

void StudyDataConfig::describe(config::Binder& b, StudyDataConfig& data) {
  b.text("scene", data.scene, "scene file, simulated when its runs begin; this, `dataset` or `family`");
  b.text("dataset", data.dataset, "dataset file, a folder with dataset.yaml, or a pattern of them (*, ?, [..])");
  b.text("family", data.family,
         "published data set: a name that `aslio datasets` lists, or the path of a family file; goes with `data`");
  b.tree("sequences", data.sequences, "of the family: a name, a pattern (*, ?, [..]), or a list of them; null: all");
  b.text("data", data.data, "folder with the files of the family, relative to the folder of this file");
  b.text("seeds", data.seeds, "of the simulation, as in 1-10 or 1-3,7; one recording each");
  b.texts("set", data.set, {}, "key.path=value, for the scene; {seed} is the seed of the recording");
  b.text("name", data.name,
         "what tables call the sequence; empty: the name of the scene file, or of the dataset; of a family: put before "
         "the name of the sequence");
  b.require(
      data.kinds() == 1, "scene",
      "dataset and family exclude each other, and one is required: name a scene file, a dataset file or a family");
  b.require(data.family.empty() == data.data.empty(), "data",
            "is the folder with the files of a `family`: give both or neither");
  b.require(sequence_patterns(data).has_value(), "sequences",
            "must be a name, a pattern, or a list of them, as in [quad_*, stairs]");
  b.require(!data.family.empty() || data.sequences.is_null(), "sequences", "goes with `family`");
  b.require(parse_seeds(data.seeds).has_value(), "seeds",
            fmt::format("must be whole numbers and ranges, each once and at most {}, as in 1-10 or 1-3,7", kMaxSeeds));
  b.require(!data.scene.empty() || data.set.empty(), "set", "changes a scene; a dataset file has its own keys");
}

void StudyMethodConfig::describe(config::Binder& b, StudyMethodConfig& method) {
  b.text("name", method.name, "what tables call the method, and its folder; required");
  b.text("pipeline", method.pipeline, "pipeline file; this, `command` or `trajectory` is required");
  b.text("label", method.label,
         "what the report and its LaTeX call the method, as in AS-LIO+; with `vary` the values follow it; empty: its "
         "name");
  b.tree("set", method.set,
         "dotted paths with the values to set there. In a text, {run:NAME} is the folder of that method's run over the "
         "same data. {data} is the folder in the output with truth and overlap of simulated data");
  b.text("baseline", method.baseline, "method to compare it with; empty: that of the study");
  b.texts("differs", method.differs, {},
          "keys, blocks or globs (`*.sigma`) in which the method may differ from the baseline, besides those of `set`; "
          "nothing else may");
  b.require(!method.name.empty(), "name", "is required");
  ExternalMethod::describe_keys(b, method.external);
  const bool external = method.external.given();
  b.require(!method.pipeline.empty() || external, "pipeline",
            "is required: name a pipeline file, give the `command` of a program, or a finished `trajectory`");
  b.require(method.pipeline.empty() || !external, "pipeline",
            "and `command` or `trajectory` exclude each other: a method is of one kind");
  b.require(!external || method.set.is_null(), "set", "changes a pipeline; a program takes words of its `command`");
  b.require(method.set.is_null() || method.set.is_map(), "set",
            "must be a block of dotted paths and values, as in {window.period: 0.05}");
}

void StudyExpectationConfig::describe(config::Binder& b, StudyExpectationConfig& rule) {
  b.text("claim", rule.claim, "what it means if it holds; stands before the verdict");
  b.text("method", rule.method, "method that the rule is about, with the suffixes of axes; required");
  b.text("against", rule.against, "method to compare it with");
  b.text("metric", rule.metric, "figure that is compared");
  b.text("lower_on", rule.lower_on,
         "where the method must be lower: '8 of 9 sequences' by their medians, '7 of 10 pairs' of runs, 'most pairs'");
  b.text("higher_on", rule.higher_on, "where it must be higher");
  b.text("not_lower_on", rule.not_lower_on, "the same, and it must not hold: lower on '2 of 3 sequences' is too many");
  b.text("not_higher_on", rule.not_higher_on, "the same for higher");
  b.real("times", rule.times, "", {.above = 0.0, .max = 1000.0},
         "lower or higher than so many times the figure of `against`");
  b.texts("sequences", rule.sequences, {}, "the rule is about these; empty: all");
  b.optional_real("failures", rule.failures, "", {.min = 0.0}, "the rule is a comparison",
                  "instead of a comparison: maximum number of runs of the method that may fail or diverge");
  b.require(!rule.method.empty(), "method", "is required: name one of `methods`");
  const std::vector<std::pair<std::string_view, const std::string*>> counts = {{"lower_on", &rule.lower_on},
                                                                               {"higher_on", &rule.higher_on},
                                                                               {"not_lower_on", &rule.not_lower_on},
                                                                               {"not_higher_on", &rule.not_higher_on}};
  int kinds = rule.failures ? 1 : 0;
  for (const auto& [key, text] : counts) {
    kinds += text->empty() ? 0 : 1;
    b.require(text->empty() || parse_required_count(*text), key,
              "must be as in 8 of 9 sequences, 7 of 10 pairs or most pairs");
  }
  b.require(kinds == 1, "lower_on",
            "higher_on, not_lower_on, not_higher_on and failures exclude each other, and one is required");
  b.require(rule.failures || !rule.against.empty(), "against", "is required: name the method to compare with");
  b.require(!rule.failures || rule.against.empty(), "against",
            "goes with lower_on, higher_on, not_lower_on and not_higher_on");
  b.require(!rule.failures || *rule.failures == std::floor(*rule.failures), "failures", "must be a whole number");
  const auto& metrics = study_metrics();
  b.require(std::find(metrics.begin(), metrics.end(), rule.metric) != metrics.end(), "metric",
            fmt::format("'{}' is none of {}", rule.metric, fmt::join(metrics, ", ")));
}

void StudyConfig::describe(config::Binder& b, StudyConfig& study) {
  constexpr double kMaxSeed = 9007199254740991.0;  // whole numbers beyond it are not exact
  b.text("question", study.question, "what the study asks; required");
  b.text("prediction", study.prediction, "what is expected, and why; required");
  b.text("rule", study.rule, "what outcome decides it, and how; required");
  b.groups("expectation", study.expectation, "rules that the program checks once the runs are there");
  b.groups("datasets", study.datasets, "the data, one table row per entry; required");
  b.groups("methods", study.methods, "the pipelines, one table column each; required");
  b.groups("vary", study.vary, "axes: every method is run at every combination of their points");
  b.group("tune", study.tune,
          "equal tuning: each pipeline is run with values drawn from a space, and the best ones become pipeline files");
  b.reals("order_seeds", study.order_seeds, 0, "", {.min = 0.0, .max = kMaxSeed},
          "seeds of `aslio run`: replicates over the same data");
  b.text("baseline", study.baseline, "method to compare the others with, where they name no other; empty: none");
  b.texts("differs", study.differs, {}, "keys or blocks in which every method may differ from the baseline");
  b.texts("metrics", study.metrics, study_metrics(), "figures that tables show");
  b.texts("outputs", study.outputs, {"dense", "map", "world"},
          "large files that stay: every state of a run (`aslio run --dense`), its map (map.ply), the surfaces of the "
          "simulated world (world.ply)");
  b.flag(
      "stop_when_diverged", study.stop_when_diverged,
      "end runs once they have diverged (`aslio run --stop-when-diverged`): their figures are those up to that moment");
  b.real("time_limit", study.time_limit, "s", {.above = 0.0, .max = 1e6}, "of a run; the program ends longer ones");
  b.real("memory_limit", study.memory_limit, "MB", {.min = 1.0, .max = 1e7},
         "resident memory of a run; the program ends larger ones");
  b.require(!study.tune.given() || study.vary.empty(), "tune",
            "and `vary` exclude each other: every method gets the same number of runs");
  const std::string_view paragraph = "is required: one paragraph, written before the study is run";
  b.require(!study.question.empty(), "question", paragraph);
  b.require(!study.prediction.empty(), "prediction", paragraph);
  b.require(!study.rule.empty(), "rule", paragraph);
  b.require(!study.datasets.empty(), "datasets", "is required: list scenes with seeds, or dataset files");
  b.require(!study.methods.empty(), "methods", "is required: list names with pipeline files");
  b.require(!study.order_seeds.empty() && whole_and_distinct(study.order_seeds), "order_seeds",
            "must be whole numbers, at least one and each once");
  b.require(!study.metrics.empty() && distinct(study.metrics), "metrics",
            "must name at least one figure, and each once");
  b.require(distinct(study.outputs), "outputs", "must name each once");
}

}  // namespace aslio::experiment
