// From a study file to a checked study: what the keys name is read, the grid of methods is laid out.
#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <stdexcept>
#include <utility>

#include "aslio/config/document.hpp"
#include "aslio/config/load.hpp"
#include "aslio/config/problems.hpp"
#include "aslio/core/errors.hpp"
#include "aslio/core/sha256.hpp"
#include "aslio/experiment/dataset.hpp"
#include "aslio/experiment/family.hpp"
#include "aslio/experiment/study.hpp"
#include "aslio/experiment/study_expectation.hpp"
#include "aslio/pipeline/stage_set.hpp"
#include "matching_paths.hpp"
#include "recording_identity.hpp"
#include "study_axes.hpp"
#include "study_differences.hpp"
#include "study_methods.hpp"
#include "study_tune.hpp"

namespace aslio::experiment {

namespace {

namespace fs = std::filesystem;
using config::Location;
using config::Node;

constexpr std::size_t kMaxMethods = 10'000;

class Reader {
 public:
  Reader(const fs::path& path, const config::StageLookup& stages, const StudyReading& reading)
      : stages_(stages), reading_(reading), folder_(path.parent_path()) {
    study_.path = path;
    study_.name = path.stem().string();
  }

  Study read() {
    const std::string text = config::read_text(study_.path);
    bind(text);
    root_ = config::parse_document(text, study_.path.string());
    for (const double seed : study_.config.order_seeds) study_.order_seeds.push_back(static_cast<std::uint64_t>(seed));
    lay_out_axes();
    for (std::size_t i = 0; i < study_.config.datasets.size(); ++i) add_data(study_.config.datasets[i], i);
    require_distinct_data();
    require_known_methods();
    lay_out_methods();
    require_distinct_folders();
    if (!wrong_keys_.empty()) {
      throw ConfigError(problems_.size() == 0 ? wrong_keys_ : wrong_keys_ + "\n" + problems_.text());
    }
    const bool all_resolved = problems_.size() == 0;
    find_baselines();
    check_rules();
    if (all_resolved) require_known_differences(study_, root_, problems_);
    problems_.raise();
    return std::move(study_);
  }

 private:
  /// Reads the keys. One that is wrong does not keep back what is wrong with the files that others name.
  void bind(const std::string& text) {
    try {
      study_.resolved =
          config::bind_text(text, study_.path.string(), config::FileKind::study, stages_, {}, [&](config::Binder& b) {
            StudyConfig::describe(b, study_.config);
          }).resolved;
    } catch (const ConfigError& error) {
      wrong_keys_ = error.what();
      study_.config.vary.clear();
      study_.config.tune.space.clear();
    }
  }

  fs::path at(const std::string& written) const { return (folder_ / written).lexically_normal(); }

  /// Place of `key` in item `index` of `list`; of the item where the key was left out.
  Location place(std::string_view list, std::size_t index, std::string_view key) const {
    const config::Member* items = root_.find(list);
    if (items == nullptr || index >= items->value.items().size()) return root_.at();
    const Node& item = items->value.items()[index];
    const config::Member* member = item.find(key);
    return member != nullptr ? member->value.at() : item.at();
  }

  /// Each line of an error in another file is a problem here.
  void add_problems(const Location& at, const std::string& before, const std::string& text) {
    for (std::size_t begin = 0; begin <= text.size();) {
      const std::size_t end = std::min(text.find('\n', begin), text.size());
      problems_.add(at, before + text.substr(begin, end - begin));
      begin = end + 1;
    }
  }

  void add_data(const StudyDataConfig& config, std::size_t index) {
    if (config.kinds() != 1) return;  // which has been noted
    if (!config.family.empty()) {
      add_family(config, index);
    } else if (config.scene.empty()) {
      add_recordings(config, index);
    } else {
      add_scene(config, index);
    }
  }

  void add_recordings(const StudyDataConfig& config, std::size_t index) {
    std::error_code ignored;
    if (!is_pattern(config.dataset) || fs::exists(at(config.dataset), ignored)) {
      add_recording(config, at(config.dataset), index);
      return;
    }
    const std::vector<fs::path> found = matching_paths(folder_, config.dataset);
    if (found.empty()) {
      problems_.add(place("datasets", index, "dataset"),
                    fmt::format("'{}' matches nothing: give a pattern of dataset files, or of folders with one; it is "
                                "relative to the folder of this file",
                                config.dataset));
    } else if (found.size() > 1 && !config.name.empty()) {
      problems_.add(place("datasets", index, "name"),
                    fmt::format("'{}' would be the name of {} recordings that '{}' matches: leave it out", config.name,
                                found.size(), config.dataset));
    } else {
      for (const fs::path& path : found) add_recording(config, path, index);
    }
  }

  void add_recording(const StudyDataConfig& config, const fs::path& path, std::size_t index) {
    try {
      const Dataset dataset = load_dataset(path);
      add_dataset(dataset, config.name.empty() ? dataset.name : config.name, index);
    } catch (const std::exception& error) {
      add_problems(place("datasets", index, "dataset"), "", error.what());
    }
  }

  void add_family(const StudyDataConfig& config, std::size_t index) {
    const auto patterns = sequence_patterns(config);
    if (!patterns || config.data.empty()) return;  // which has been noted
    try {
      std::error_code ignored;
      const fs::path beside = at(config.family);
      const Family family = load_family(
          find_family(fs::is_regular_file(beside, ignored) ? beside.string() : config.family, reading_.families));
      for (const FamilySequence* sequence : select_sequences(family, *patterns)) {
        const std::string before = config.name.empty() ? "" : config.name + "_";
        add_dataset(dataset_of(family, *sequence, at(config.data)), before + sequence->name, index);
      }
    } catch (const std::exception& error) {
      add_problems(place("datasets", index, "family"), "", error.what());
    }
  }

  void add_dataset(const Dataset& dataset, const std::string& name, std::size_t index) {
    StudyData data;
    data.name = data.sequence = name;
    data.dataset = dataset.file;
    if (dataset.published) {
      data.dataset /= dataset.published->sequence;
      data.folder = dataset.published->data;
    }
    data.texts = {dataset.file, dataset.sensor};
    if (dataset.reference && is_small(dataset.reference->file)) data.texts.emplace_back(dataset.reference->file);
    for (const fs::path& file : data.texts) study_.sources.emplace(file, sha256_of_file(file));
    data.identity = recording_identity(dataset);
    require_one_scene(data.sequence, "recording", index);
    add_named(std::move(data), index);
  }

  void add_scene(const StudyDataConfig& config, std::size_t index) {
    StudyData data;
    data.scene = at(config.scene);
    data.texts = {data.scene};
    data.scale = reading_.scale;
    data.sequence = config.name.empty() ? data.scene.stem().string() : config.name;
    const auto read = reading_.seeds ? reading_.seeds : parse_seeds(config.seeds);
    if (!read || read->empty()) return;
    const auto& seeds = *read;
    const bool by_seed = with_seed(config.set, seeds.front()) != config.set;
    try {
      ResolvedScene resolved = reading_.resolve_scene(data.scene, with_seed(config.set, seeds.front()));
      // Of scenes that go by the seed, one and the same stands for all: that of seed 1.
      const std::string all =
          by_seed ? reading_.resolve_scene(data.scene, with_seed(config.set, 1)).text : resolved.text;
      study_.sources.emplace(data.scene, sha256_of_file(data.scene));
      require_one_scene(data.sequence, (by_seed ? "by seed\n" : "") + all, index);
      for (const std::uint64_t seed : seeds) {
        data.seed = seed;
        data.set = with_seed(config.set, seed);
        data.name = fmt::format("{}_{}", data.sequence, seed);
        if (by_seed) resolved = reading_.resolve_scene(data.scene, data.set);
        data.texts = {data.scene};
        for (const fs::path& file : resolved.files) {
          data.texts.push_back(file);
          study_.sources.emplace(file, sha256_of_file(file));
        }
        data.identity = sha256_of(fmt::format("scene\n{}\nseed {}\nscale {}\n", resolved.text, seed, data.scale));
        add_named(data, index);
      }
    } catch (const std::runtime_error& error) {  // of the scene, or of what it names
      add_problems(place("datasets", index, "scene"), "", error.what());
    }
  }

  void add_named(StudyData data, std::size_t index) {
    if (!valid_name(data.name)) {
      problems_.add(place("datasets", index, "name"), fmt::format("'{}' {}", data.name, kNameRule));
      return;
    }
    data_entries_.push_back(index);
    study_.data.push_back(std::move(data));
  }

  /// Figures of one row of a table are replicates: one scene, other seeds.
  void require_one_scene(const std::string& sequence, const std::string& what, std::size_t index) {
    const auto [other, is_new] = scenes_.emplace(sequence, std::pair(what, index));
    if (is_new || other->second.first == what) return;
    problems_.add(
        place("datasets", index, "name"),
        fmt::format("datasets.{} and datasets.{} differ in more than the seed, and both are called '{}': give "
                    "one of them another name",
                    other->second.second, index, sequence));
  }

  void require_distinct_data() {
    std::map<std::string, std::size_t> first;  // entry by name
    for (std::size_t i = 0; i < study_.data.size(); ++i) {
      const auto [other, is_new] = first.emplace(study_.data[i].name, data_entries_[i]);
      if (is_new) continue;
      problems_.add(place("datasets", data_entries_[i], "name"),
                    fmt::format("datasets.{} and datasets.{} both make the data '{}': give one of them another name",
                                other->second, data_entries_[i], study_.data[i].name));
      return;
    }
  }

  void lay_out_axes() {
    for (const StudyAxisConfig& axis : study_.config.vary) {
      points_.push_back(axis_points(axis));
      for (const std::string& column : axis_columns(axis)) study_.axes.push_back(column);
    }
    if (study_.config.tune.given()) study_.axes.emplace_back(kCandidateColumn);
  }

  void lay_out_methods() {
    for (std::size_t i = 0; i < study_.config.methods.size(); ++i) {
      const StudyMethodConfig& config = study_.config.methods[i];
      if (config.name.empty() || (config.pipeline.empty() && !config.external.given()))
        continue;  // which has been noted
      if (!valid_name(config.name)) {
        problems_.add(place("methods", i, "name"), fmt::format("'{}' {}", config.name, kNameRule));
        continue;
      }
      Grid laid = grid_of(points_, study_.config.vary, config.name);
      if (study_.config.tune.given() && !add_candidates(config, i, laid)) continue;
      const Grid& grid = laid;
      std::vector<std::size_t> at_axes(grid.size(), 0);
      const std::size_t before = problems_.size();
      do {
        add_method(config, i, grid, at_axes);
      } while (problems_.size() == before && advance(grid, at_axes));
    }
  }

  /// False: the method cannot be tuned as the others are, which has been noted.
  bool add_candidates(const StudyMethodConfig& config, std::size_t index, Grid& grid) {
    const std::string problem = tuning_problem(study_, config);
    if (problem.empty()) {
      grid.push_back(candidate_points(study_, config));
      return true;
    }
    problems_.add(place("methods", index, "name"), fmt::format("'{}' {}", config.name, problem));
    return false;
  }

  void require_known_methods() {
    const std::string problem = space_problem(study_.config);
    if (!problem.empty()) problems_.add(root_.find("tune")->value.at(), "'tune.space': " + problem);
    const auto& methods = study_.config.methods;
    for (std::size_t k = 0; k < study_.config.vary.size(); ++k) {
      for (const std::string& name : study_.config.vary[k].methods) {
        if (std::any_of(methods.begin(), methods.end(), [&](const auto& m) { return m.name == name; })) continue;
        problems_.add(place("vary", k, "methods"), fmt::format("'{}' is no method of the study", name));
      }
    }
  }

  void add_method(const StudyMethodConfig& config, std::size_t index, const Grid& grid,
                  const std::vector<std::size_t>& at_axes) {
    StudyMethod method;
    method.name = method.base = config.name;
    if (config.external.given()) {
      try {
        method.external = placed_in(config.external, folder_);
      } catch (const ConfigError& error) {
        add_problems(place("methods", index, "trajectory_set"), "", error.what());
        return;
      }
    } else {
      method.pipeline = at(config.pipeline);
    }
    method.differs = config.differs;
    method.differs.insert(method.differs.end(), study_.config.differs.begin(), study_.config.differs.end());
    method.entry = index;
    for (const config::Member& member : config.set.members()) {
      method.set.push_back(member.key + "=" + config::to_line(member.value));
    }
    for (std::size_t k = 0; k < at_axes.size(); ++k) {
      const AxisPoint& point = grid[k][at_axes[k]];
      method.set.insert(method.set.end(), point.assignments.begin(), point.assignments.end());
      method.axes.insert(method.axes.end(), point.values.begin(), point.values.end());
      method.name += point.suffix;
    }
    if (study_.methods.size() >= kMaxMethods) {
      problems_.add(place("vary", 0, "values"), fmt::format("more than {} methods in the grid", kMaxMethods));
      return;
    }
    if (!valid_name(method.name) || find_method(study_, method.name)) {
      problems_.add(
          place("methods", index, "name"),
          fmt::format(
              "'{}' {}", method.name,
              find_method(study_, method.name) ? "is the name of two methods: name one of them otherwise" : kNameRule));
      return;
    }
    if (resolve(method, index) && find_uses(method, index)) study_.methods.push_back(std::move(method));
  }

  /// `a` with order seed 1 and a method of the name `a_order_1` would overwrite each other.
  void require_distinct_folders() {
    std::map<std::string, std::pair<std::size_t, std::uint64_t>> first;  // method and order seed by folder
    for (std::size_t m = 0; m < study_.methods.size(); ++m) {
      for (const std::uint64_t seed : study_.order_seeds) {
        const auto [other, is_new] = first.emplace(run_folder(study_.methods[m].name, seed), std::pair(m, seed));
        if (is_new) continue;
        problems_.add(
            place("methods", study_.methods[m].entry, "name"),
            fmt::format("'{}' with order seed {} and '{}' with order seed {} would both have the folder '{}': "
                        "name one of them otherwise",
                        study_.methods[m].name, seed, study_.methods[other->second.first].name, other->second.second,
                        other->first));
        return;
      }
    }
  }

  /// False: it varies along an axis, which has been noted.
  bool resolve_external(StudyMethod& method, std::size_t index) {
    if (!wrong_keys_.empty()) return false;  // its own may be among them
    method.resolved = resolved_text(*method.external);
    if (method.set.empty()) return true;
    problems_.add(place("methods", index, "name"),
                  fmt::format("method '{}': `vary` changes pipelines, and this is another program: give the axis "
                              "`methods: [..]` without it",
                              method.base));
    return false;
  }

  /// False: the pipeline with its overrides is wrong, which has been noted.
  bool resolve(StudyMethod& method, std::size_t index) {
    if (method.external) return resolve_external(method, index);
    std::vector<config::Override> overrides;
    for (const std::string& assignment : method.set) overrides.push_back({assignment});
    try {
      method.pipeline = config::follow_alias(method.pipeline);
      const auto loaded =
          config::load<pipeline::PipelineConfig>(method.pipeline, config::FileKind::pipeline, stages_, overrides);
      pipeline::check_stages(loaded, made_later(method.set));
      method.resolved = loaded.resolved;
      method.paths = paths_in(method.resolved);
      study_.sources.emplace(method.pipeline, sha256_of_file(method.pipeline));
      return require_other_data(method, index);
    } catch (const ConfigError& error) {
      add_problems(place("methods", index, study_.config.methods[index].set.is_map() ? "set" : "pipeline"),
                   fmt::format("method '{}': ", method.name), error.what());
      return false;
    }
  }

  /// False: it was tuned on what the study reports, which has been noted.
  bool require_other_data(const StudyMethod& method, std::size_t index) {
    if (study_.config.tune.given()) return true;
    const std::vector<std::string> same = tuned_on(method.pipeline, study_.data);
    if (same.empty()) return true;
    problems_.add(place("methods", index, "pipeline"),
                  fmt::format("method '{}': {} was tuned on {}, which this study reports: take other recordings",
                              method.base, method.pipeline.string(), fmt::join(same, ", ")));
    return false;
  }

  /// Methods named as {run:NAME}. One with axes is meant at the same values. False: there is none, which was noted.
  bool find_uses(StudyMethod& method, std::size_t index) {
    constexpr std::string_view kOpen = "{run:";
    for (const std::string& assignment : method.set) {
      for (std::size_t begin = assignment.find(kOpen); begin != std::string::npos;
           begin = assignment.find(kOpen, begin + 1)) {
        const std::size_t end = assignment.find('}', begin);
        const std::string name = assignment.substr(begin + kOpen.size(), end - begin - kOpen.size());
        const auto used = find_variant(study_, name, method.axes);
        if (end == std::string::npos || !used) {
          problems_.add(place("methods", index, "set"),
                        fmt::format("{{run:{}}}: no method of that name stands before '{}'; there are: {}", name,
                                    method.name, method_names(study_)));
          return false;
        }
        if (study_.methods[*used].external) {
          problems_.add(place("methods", index, "set"),
                        fmt::format("{{run:{}}}: a program of others leaves no file that a stage reads", name));
          return false;
        }
        if (study_.config.stop_when_diverged) {
          problems_.add(place("methods", index, "set"),
                        fmt::format("{{run:{}}}: does not go with stop_when_diverged: the file of a run that was ended "
                                    "is cut off; leave the key out",
                                    name));
          return false;
        }
        const std::pair<std::string, std::size_t> use(name, *used);
        if (std::find(method.uses.begin(), method.uses.end(), use) == method.uses.end()) method.uses.push_back(use);
      }
    }
    return true;
  }

  void find_baselines() {
    study_.baseline.assign(study_.methods.size(), std::nullopt);
    if (problems_.size() > 0) return;
    for (std::size_t i = 0; i < study_.methods.size(); ++i) {
      const std::size_t entry = study_.methods[i].entry;
      const std::string& own = study_.config.methods[entry].baseline;
      const std::string& name = own.empty() ? study_.config.baseline : own;
      if (name.empty()) continue;
      const auto base = find_variant(study_, name, study_.methods[i].axes);
      if (!base) {
        problems_.add(own.empty() ? root_.find("baseline")->value.at() : place("methods", entry, "baseline"),
                      fmt::format("'baseline' names no method: '{}'; there are: {}", name, method_names(study_)));
        return;
      }
      if (*base == i) continue;
      study_.baseline[i] = base;
      require_named_differences(study_.methods[i], study_.methods[*base]);
    }
  }

  void check_rules() {
    if (problems_.size() > 0) return;
    check_expectation(study_, reading_.seeds.has_value(),
                      [this](std::size_t rule, std::string_view key, const std::string& message) {
                        problems_.add(place("expectation", rule, key), fmt::format("'{}': {}", key, message));
                      });
  }

  /// A comparison is fair where the study says what is compared.
  void require_named_differences(const StudyMethod& method, const StudyMethod& baseline) {
    const std::vector<std::string> unnamed = unnamed_keys(method, baseline);
    if (unnamed.empty()) return;
    problems_.add(
        place("methods", method.entry, "differs"),
        fmt::format("'{}' differs from the baseline '{}' in what the study does not name; set these alike, or say so: "
                    "differs: [{}]",
                    method.name, baseline.name, fmt::join(unnamed, ", ")));
  }

  const config::StageLookup& stages_;
  const StudyReading& reading_;
  fs::path folder_;
  Study study_;
  Node root_;
  Grid points_;
  config::Problems problems_;
  std::string wrong_keys_;                 ///< what the keys themselves have wrong, a line each
  std::vector<std::size_t> data_entries_;  // by data: index in `datasets`
  std::map<std::string, std::pair<std::string, std::size_t>> scenes_;  ///< what is behind a sequence, and its entry
};

}  // namespace

Study load_study(const fs::path& path, const config::StageLookup& stages, const StudyReading& reading) {
  return Reader(path, stages, reading).read();
}

}  // namespace aslio::experiment
