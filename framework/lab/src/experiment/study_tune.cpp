#include "study_tune.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <map>
#include <random>
#include <sstream>

#include "aslio/config/binder.hpp"
#include "aslio/core/errors.hpp"
#include "aslio/experiment/study_statistics.hpp"
#include "aslio/experiment/version.hpp"
#include "aslio/io/writers.hpp"
#include "run_outputs.hpp"
#include "study_files.hpp"

namespace aslio::experiment {

namespace {

namespace fs = std::filesystem;

constexpr std::string_view kTunedOn = "# tuned-on ";
constexpr double kWorst = 1e9;

bool is_of(const StudyTuneParameterConfig& parameter, const std::string& method) {
  const auto& methods = parameter.methods;
  return methods.empty() || std::find(methods.begin(), methods.end(), method) != methods.end();
}

/// How many the budget allows for each method, the untuned pipeline among them.
std::size_t candidates_of(const Study& study) {
  const std::size_t runs = std::max<std::size_t>(1, study.data.size() * study.order_seeds.size());
  return static_cast<std::size_t>(study.config.tune.budget) / runs;
}

/// Draws that depend on the seed and the parameter alone, the same with every library (std::uniform_* are not).
class Draws {
 public:
  Draws(std::int64_t seed, const std::string& path) {
    std::uint64_t hash = 14695981039346656037ULL;  // FNV-1a
    for (const char c : path) hash = (hash ^ static_cast<unsigned char>(c)) * 1099511628211ULL;
    engine_.seed(hash ^ static_cast<std::uint64_t>(seed));
  }
  /// In [0, 1).
  double next() { return static_cast<double>(engine_() >> 11) * 0x1p-53; }

 private:
  std::mt19937_64 engine_;
};

std::string drawn(const StudyTuneParameterConfig& parameter, double u) {
  if (parameter.values.is_list()) {
    const auto& items = parameter.values.items();
    const auto at = std::min(items.size() - 1, static_cast<std::size_t>(u * static_cast<double>(items.size())));
    return config::to_line(items[at]);
  }
  const double low = parameter.range.at(0), high = parameter.range.at(1);
  if (parameter.whole) return fmt::format("{}", static_cast<std::int64_t>(std::floor(low + u * (high - low + 1))));
  const double value = parameter.scale == TuneScale::log ? low * std::pow(high / low, u) : low + u * (high - low);
  return fmt::format("{:.4g}", value);
}

/// Figures of one candidate over all recordings.
struct Score {
  std::size_t failures = 0, figures = 0, missing = 0;
  double log_sum = 0;
  double objective() const { return figures > 0 ? std::exp(log_sum / static_cast<double>(figures)) : kWorst; }
  bool better_than(const Score& other) const {
    return failures != other.failures ? failures < other.failures : objective() < other.objective();
  }
};

std::vector<Score> scores_of(const Study& study, const std::vector<StudyRun>& runs,
                             const std::vector<std::optional<StudyRow>>& rows) {
  std::vector<Score> scores(study.methods.size());
  for (std::size_t i = 0; i < runs.size(); ++i) {
    Score& score = scores[runs[i].method];
    if (!rows[i] || !rows[i]->outcome.final) {  // the machine's fault may be another's tomorrow
      ++score.missing;
      continue;
    }
    const auto figure = rows[i]->figure(study.config.tune.objective);
    if (!rows[i]->good() || !figure) {
      ++score.failures;
      continue;
    }
    ++score.figures;
    score.log_sum += std::log(std::max(*figure, 1e-12));
  }
  return scores;
}

std::string provenance(const Study& study, const Tuned& tuned) {
  const StudyMethod& method = study.methods[tuned.method];
  const StudyTuneConfig& tune = study.config.tune;
  std::string text = fmt::format(
      "# {} as tuned by the study {}: candidate {} of {}, {} {:.4g} (geometric mean over {} recordings, {} failed); "
      "untuned {}.\n# Random search over {} keys, seed {}, {} runs. aslio {}, {}.\n",
      tuned.base, study.name, method.axes.back(), tuned.candidates, tune.objective, tuned.objective, study.data.size(),
      tuned.failures, tuned.untuned_objective ? fmt::format("{:.4g}", *tuned.untuned_objective) : "failed",
      std::count_if(tune.space.begin(), tune.space.end(), [&](const auto& p) { return is_of(p, tuned.base); }),
      tune.seed, tuned.candidates * study.data.size() * study.order_seeds.size(), version(), source_revision());
  if (!method.set.empty()) text += fmt::format("# {}\n", fmt::join(method.set, ", "));
  for (const StudyData& data : study.data) text += fmt::format("{}{} {}\n", kTunedOn, data.name, data.identity);
  return text;
}

std::string tuning_csv(const Study& study, const std::vector<Score>& scores) {
  std::string text = "method,candidate,set," + study.config.tune.objective + ",failures,missing\n";
  for (std::size_t m = 0; m < study.methods.size(); ++m) {
    const StudyMethod& method = study.methods[m];
    std::string set = fmt::format("{}", fmt::join(method.set, "; "));
    std::replace(set.begin(), set.end(), '"', '\'');
    text += fmt::format("{},{},\"{}\",{},{},{}\n", method.base, method.axes.back(), set,
                        scores[m].figures > 0 ? fmt::format("{}", scores[m].objective()) : "", scores[m].failures,
                        scores[m].missing);
  }
  return text;
}

}  // namespace

void StudyTuneParameterConfig::describe(config::Binder& b, StudyTuneParameterConfig& p) {
  b.text("path", p.path, "dotted path of the pipelines; required");
  b.reals("range", p.range, 0, "", {}, "lowest and highest value");
  b.choice("scale", p.scale, {{"linear", TuneScale::linear}, {"log", TuneScale::log}}, "of the range");
  b.flag("whole", p.whole, "values of the range are whole numbers");
  b.tree("values", p.values, "list of values in place of a range");
  b.texts("methods", p.methods, {}, "methods that have it; empty: all pipelines");
  b.require(!p.path.empty(), "path", "is required: name a key of the pipelines, as in estimator.sigma");
  b.require(p.range.empty() == p.values.is_list(), "range", "or `values` is required, and only one of them");
  b.require(p.range.empty() || (p.range.size() == 2 && p.range[0] < p.range[1]), "range",
            "must be two numbers, the lower one first");
  b.require(p.scale == TuneScale::linear || p.range.empty() || p.range[0] > 0, "scale", "log needs a range above 0");
  const bool bounds =
      p.range.size() == 2 && p.range[0] == std::floor(p.range[0]) && p.range[1] == std::floor(p.range[1]);
  b.require(!p.whole || (bounds && p.scale == TuneScale::linear), "whole", "needs a linear range of whole numbers");
  b.require(p.values.is_null() || (p.values.is_list() && !p.values.items().empty()), "values",
            "must be a list of values, as in [0.1, 0.2]");
}

void StudyTuneConfig::describe(config::Binder& b, StudyTuneConfig& tune) {
  b.groups("space", tune.space, "parameters that are drawn; empty: nothing is tuned");
  b.integer("budget", tune.budget, "1", {.min = 2, .max = 1e6},
            "runs for each method, the untuned pipeline's among them");
  b.text("objective", tune.objective, "figure whose geometric mean over the recordings is to be small");
  b.integer("seed", tune.seed, "1", {.min = 0, .max = 1e9}, "of the draws");
  b.require(smaller_is_better(tune.objective), "objective",
            "must be a figure of which a smaller one is better, as ate_m or cpu_s_per_s");
}

std::string tuning_problem(const Study& study, const StudyMethodConfig& method) {
  const StudyTuneConfig& tune = study.config.tune;
  const auto has = [&](const auto& parameter) { return is_of(parameter, method.name); };
  if (!method.external.given() && std::none_of(tune.space.begin(), tune.space.end(), has)) {
    return "has no parameter in `tune.space`: every method gets the same budget. Add one, or leave the method out";
  }
  if (candidates_of(study) >= 2) return "";
  return fmt::format("cannot be tuned: a budget of {} runs is not enough for two candidates over {} recordings",
                     tune.budget, study.data.size());
}

std::string space_problem(const StudyConfig& config) {
  const auto& space = config.tune.space;
  for (std::size_t k = 0; k < space.size(); ++k) {
    for (const std::string& name : space[k].methods) {
      const bool known =
          std::any_of(config.methods.begin(), config.methods.end(), [&](const auto& m) { return m.name == name; });
      if (!known) return fmt::format("'{}' is no method of the study", name);
    }
    for (std::size_t other = 0; other < k; ++other) {
      if (space[other].path != space[k].path) continue;
      const auto both = [&](const auto& m) { return is_of(space[other], m.name) && is_of(space[k], m.name); };
      const auto same = std::find_if(config.methods.begin(), config.methods.end(), both);
      if (same != config.methods.end())
        return fmt::format("'{}' stands there twice for '{}'", space[k].path, same->name);
    }
  }
  return "";
}

std::vector<AxisPoint> candidate_points(const Study& study, const StudyMethodConfig& method) {
  const StudyTuneConfig& tune = study.config.tune;
  const std::size_t candidates = method.external.given() ? 1 : candidates_of(study);
  std::vector<AxisPoint> points(candidates);
  for (std::size_t i = 0; i < candidates; ++i) {
    points[i].values = {fmt::to_string(i)};
    if (i > 0) points[i].suffix = fmt::format("_t{:03}", i);
  }
  for (const StudyTuneParameterConfig& parameter : tune.space) {
    if (!is_of(parameter, method.name)) continue;
    Draws draws(tune.seed, parameter.path);
    for (std::size_t i = 1; i < candidates; ++i) {
      points[i].assignments.push_back(parameter.path + "=" + drawn(parameter, draws.next()));
    }
  }
  return points;
}

std::vector<Tuned> best_candidates(const Study& study, const std::vector<StudyRun>& runs,
                                   const std::vector<std::optional<StudyRow>>& rows) {
  const std::vector<Score> scores = scores_of(study, runs, rows);
  std::map<std::string, std::vector<std::size_t>> methods;
  for (std::size_t m = 0; m < study.methods.size(); ++m) {
    if (!study.methods[m].external) methods[study.methods[m].base].push_back(m);
  }
  std::vector<Tuned> out;
  for (const auto& [base, members] : methods) {
    if (std::any_of(members.begin(), members.end(), [&](std::size_t m) { return scores[m].missing > 0; })) continue;
    const std::size_t best = *std::min_element(
        members.begin(), members.end(), [&](std::size_t a, std::size_t b) { return scores[a].better_than(scores[b]); });
    if (scores[best].figures == 0) continue;  // without one there is no best
    Tuned tuned{.base = base,
                .method = best,
                .untuned = members.front(),
                .candidates = members.size(),
                .failures = scores[best].failures,
                .objective = scores[best].objective(),
                .untuned_objective = {}};
    if (scores[members.front()].failures == 0) tuned.untuned_objective = scores[members.front()].objective();
    out.push_back(std::move(tuned));
  }
  return out;
}

void write_tuning(const Study& study, const std::vector<StudyRun>& runs,
                  const std::vector<std::optional<StudyRow>>& rows, const fs::path& output) {
  write_file(output / "tuning.csv", tuning_csv(study, scores_of(study, runs, rows)));
  const std::vector<Tuned> best = best_candidates(study, runs, rows);
  // What an earlier study left there is of other candidates.
  std::error_code ignored;
  for (const StudyMethod& method : study.methods) fs::remove(output / "tuned" / (method.base + ".yaml"), ignored);
  if (!best.empty()) create_folder(output / "tuned");
  for (const Tuned& tuned : best) {
    write_file(output / "tuned" / (tuned.base + ".yaml"),
               provenance(study, tuned) + study.methods[tuned.method].resolved);
  }
}

std::vector<std::string> tuned_on(const fs::path& pipeline, const std::vector<StudyData>& data) {
  std::vector<std::string> found;
  std::ifstream file(pipeline);
  for (std::string line; std::getline(file, line) && (line.empty() || line.front() == '#');) {
    if (!line.starts_with(kTunedOn)) continue;
    std::istringstream words(line.substr(kTunedOn.size()));
    std::string name, identity;
    words >> name >> identity;
    const bool reported = std::any_of(data.begin(), data.end(), [&](const StudyData& d) {
      // The identity changes with the program, a copy or the sensor file, and the name stays.
      return d.identity == identity || d.name == name;
    });
    if (reported) found.push_back(name);
  }
  return found;
}

}  // namespace aslio::experiment
