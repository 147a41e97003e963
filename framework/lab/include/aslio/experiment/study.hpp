#pragma once
/// A study: a question, the data and the methods that answer it, and the rule that decides (docs/experiments.md).

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "aslio/config/node.hpp"
#include "aslio/config/stage_lookup.hpp"
#include "aslio/experiment/external_method.hpp"

namespace aslio::config {
class Binder;
}

namespace aslio::experiment {

/// One entry of `datasets`: a scene with seeds, a dataset file, or sequences of a family.
struct StudyDataConfig {
  std::string scene, dataset;
  std::string family;            ///< name of a shipped one, or a family file
  config::Node sequences;        ///< a name or pattern, or a list of them; empty: all
  std::string data;              ///< folder with the files of the family
  std::string seeds = "1";       ///< "1-10", "3", "1-3,7"
  std::vector<std::string> set;  ///< `key.path=value`, for the scene
  std::string name;
  /// How many of scene, dataset and family are given: one is due.
  int kinds() const { return (scene.empty() ? 0 : 1) + (dataset.empty() ? 0 : 1) + (family.empty() ? 0 : 1); }
  static void describe(config::Binder& b, StudyDataConfig& data);
};

/// The patterns of `sequences`; nothing where it holds something else.
std::optional<std::vector<std::string>> sequence_patterns(const StudyDataConfig& data);

/// One entry of `methods`.
struct StudyMethodConfig {
  std::string name, pipeline;
  std::string label;                 ///< for people; empty: the name
  std::string baseline;              ///< its own; empty: that of the study
  config::Node set;                  ///< map of dotted paths to values
  std::vector<std::string> differs;  ///< keys and blocks
  ExternalMethod external;           ///< in place of a pipeline
  static void describe(config::Binder& b, StudyMethodConfig& method);
};

/// One entry of `vary`: a path with values, paths in step, or named points.
struct StudyAxisConfig {
  std::string path;
  config::Node values;               ///< list
  config::Node zip;                  ///< map of dotted paths to lists of one length
  config::Node list;                 ///< of {name, set}
  std::string name = "variant";      ///< column of `list`
  std::vector<std::string> methods;  ///< that vary along it; empty: all
  static void describe(config::Binder& b, StudyAxisConfig& axis);
};

/// One rule of `expectation`; judged by study_expectation.hpp.
struct StudyExpectationConfig {
  std::string claim;             ///< what it means, for people
  std::string method, against;   ///< names of methods, with the suffixes of axes
  std::string metric = "ate_m";  ///< compared
  /// One of them, or `failures`: "8 of 9 sequences", "most pairs".
  std::string lower_on, higher_on, not_lower_on, not_higher_on;
  double times = 1;                    ///< lower or higher than so many times the figure of `against`
  std::vector<std::string> sequences;  ///< empty: all
  std::optional<double> failures;      ///< most runs of `method` that may fail or diverge
  static void describe(config::Binder& b, StudyExpectationConfig& rule);
};

enum class TuneScale : std::uint8_t { linear, log };

/// One parameter of the space of `tune`: a path with a range or a list of values.
struct StudyTuneParameterConfig {
  std::string path;
  std::vector<double> range;  ///< lowest and highest
  TuneScale scale = TuneScale::linear;
  bool whole = false;
  config::Node values;               ///< list, in place of a range
  std::vector<std::string> methods;  ///< that have it; empty: all pipelines
  static void describe(config::Binder& b, StudyTuneParameterConfig& parameter);
};

/// Equal tuning: every pipeline gets as many runs over the same recordings, with values drawn from the same space.
struct StudyTuneConfig {
  std::vector<StudyTuneParameterConfig> space;  ///< empty: the study does not tune
  std::int64_t budget = 40;                     ///< runs for each method
  std::string objective = "ate_m";              ///< geometric mean over recordings; smaller is better
  std::int64_t seed = 1;                        ///< of the draws
  bool given() const { return !space.empty(); }
  static void describe(config::Binder& b, StudyTuneConfig& tune);
};

/// Study file (`schema: aslio/study/1`) as written. Paths are relative to the folder of the file.
struct StudyConfig {
  std::string question, prediction, rule;
  std::vector<StudyExpectationConfig> expectation;
  std::vector<StudyDataConfig> datasets;
  std::vector<StudyMethodConfig> methods;
  std::vector<StudyAxisConfig> vary;
  StudyTuneConfig tune;
  std::vector<double> order_seeds{0.0};
  std::string baseline;
  std::vector<std::string> differs;  ///< those of every method
  std::vector<std::string> metrics{"ate_m", "ate_deg", "end_to_end_m"};
  bool stop_when_diverged = false;   ///< RunOptions::stop_when_diverged
  std::vector<std::string> outputs;  ///< large ones that stay: "dense", "map", "world"
  double time_limit = 600;           ///< of a run [s]
  double memory_limit = 8000;        ///< resident memory of a run [MB]
  static void describe(config::Binder& b, StudyConfig& study);
};

/// What `metrics` may name: the figures of summary.json by the names that tables give them.
const std::vector<std::string>& study_metrics();

/// One recording of the study: a dataset file, or a scene with a seed that is still to be simulated.
struct StudyData {
  std::string name;                   ///< of its folder: that of the sequence, with _SEED when simulated
  std::string sequence;               ///< what tables call it
  std::optional<std::uint64_t> seed;  ///< of the simulation
  std::filesystem::path scene;        ///< empty for a recording
  std::vector<std::string> set;       ///< overrides of the scene
  double scale = 1;                   ///< of the scene
  std::filesystem::path dataset;      ///< empty for a scene; FAMILY_FILE/SEQUENCE of a family
  std::filesystem::path folder;       ///< with the files of the family; empty for any other data
  /// What was read of it before: the scene and what it reads, or the files of a recording.
  std::vector<std::filesystem::path> texts;
  std::string identity;  ///< SHA-256 of everything that makes these data what they are
};

/// One method: a pipeline with overrides, at one point of the grid of axes, or one that is not of this program.
struct StudyMethod {
  std::string name;  ///< with the suffixes of the axes
  std::string base;  ///< without
  std::filesystem::path pipeline;
  std::optional<ExternalMethod> external;  ///< in place of a pipeline; its paths are absolute
  std::vector<std::string> set;            ///< `key.path=value`; may hold {run:NAME} and {data}, see overrides_of()
  std::vector<std::string> axes;           ///< value in each column of the axes, as text
  std::vector<std::string> differs;        ///< its own, and those of the study
  std::size_t entry = 0;                   ///< in `methods`
  /// Names in {run:NAME}, and the methods they mean, all of which stand before this one.
  std::vector<std::pair<std::string, std::size_t>> uses;
  std::string resolved;            ///< pipeline, or external method, with every key at its effective value
  std::vector<std::string> paths;  ///< paths_in(resolved)
};

/// A study that has been checked: every file it names exists, every pipeline with its overrides is valid.
struct Study {
  std::filesystem::path path;
  std::string name;  ///< stem of the file
  StudyConfig config;
  std::vector<StudyData> data;       ///< in the order written, seeds ascending as written
  std::vector<StudyMethod> methods;  ///< in the order written, the last axis fastest
  std::vector<std::string> axes;     ///< columns of the axes: paths, or the name of a list
  std::vector<std::uint64_t> order_seeds;
  /// By method: the one to compare it with, if any. A baseline with axes: the variant at the same values.
  std::vector<std::optional<std::size_t>> baseline;
  std::string resolved;                        ///< YAML with every key at its effective value
  std::vector<std::filesystem::path> plugins;  ///< that every run loads; given by the caller
  /// SHA-256 of StudyData::texts, pipelines and plugins as they were read.
  std::map<std::filesystem::path, std::string> sources;
};

/// Throws DataError when one of the `sources` of the study is no longer what was read: a run of the new text must not
/// stand under the key of the old one.
void require_unchanged(const Study& study, const std::vector<std::filesystem::path>& sources);

/// Keys in which the resolved pipelines differ; `program` alone where one of the two is not of this program.
std::vector<std::string> differing_keys(const StudyMethod& method, const StudyMethod& baseline);
/// Of those, the ones that neither `set`, the axes nor `differs` of either names.
std::vector<std::string> unnamed_keys(const StudyMethod& method, const StudyMethod& baseline);

struct ResolvedScene {
  std::string text;                          ///< effective, with digests of all that makes its data
  std::vector<std::filesystem::path> files;  ///< that it reads besides itself: a mesh, poses to follow
};

struct StudyReading {
  /// A scene with overrides. Throws ConfigError. Given by the caller: the framework does not know the simulator.
  std::function<ResolvedScene(const std::filesystem::path& scene, const std::vector<std::string>& set)> resolve_scene;
  std::optional<std::vector<std::uint64_t>> seeds;  ///< in place of those of every scene
  double scale = 1;                                 ///< of every scene
  std::filesystem::path families = {};              ///< folder of those that may be named without a path
};

/// Reads and checks a study file. Throws ConfigError with everything that is wrong: file, line, column, remedy.
Study load_study(const std::filesystem::path& path, const config::StageLookup& stages, const StudyReading& reading);

/// "1-10", "3", "1-3,7" as numbers in the order written; nothing when the text is none of these, names a number twice
/// or more than 10 000 of them.
std::optional<std::vector<std::uint64_t>> parse_seeds(std::string_view text);

/// One run of the study: data x order seed x method.
struct StudyRun {
  std::size_t data = 0, method = 0;
  std::uint64_t order_seed = 0;
  std::string folder;             ///< name inside the folder of the data
  std::string key;                ///< SHA-256 of configuration, data, program and the runs it uses
  std::vector<std::size_t> uses;  ///< runs that must be finished before
};

/// Name of a run's folder inside the folder of its data: METHOD, or METHOD_order_N for an order seed N other than 0.
std::string run_folder(const std::string& method, std::uint64_t order_seed);

/// All runs, by data, order seed and method. `program` identifies the program with its plugins; `runs_folder` as in
/// overrides_of().
std::vector<StudyRun> plan_runs(const Study& study, std::string_view program,
                                const std::filesystem::path& runs_folder = {});

/// The same of one recording, behind those that there are: a plan of any size, one recording at a time.
void append_runs(const Study& study, std::string_view program, const std::filesystem::path& runs_folder,
                 std::size_t data, std::vector<StudyRun>& runs);

/// Values of a resolved pipeline that may be paths of files; they may hold {data}.
std::vector<std::string> paths_in(const std::string& resolved);

/// The key of a run, by what is now in the files that its pipeline names: a schedule, for one.
std::string run_key(const Study& study, const std::vector<StudyRun>& runs, const StudyRun& run,
                    std::string_view program, const std::filesystem::path& runs_folder);

/// Overrides of the run's pipeline with {run:NAME} replaced by folders below `runs_folder`, and {data} by the folder
/// beside it where truth and overlap of the run's simulated data stay.
std::vector<std::string> overrides_of(const Study& study, const std::vector<StudyRun>& runs, const StudyRun& run,
                                      const std::filesystem::path& runs_folder);

/// Throws ConfigError where a glob selects none of the runs.
void require_selection(const Study& study, const std::string& glob);

/// By run: whether "DATA/FOLDER", the name of its data or that of its method matches the glob, or a matching run uses
/// it. An empty glob matches all.
std::vector<bool> select_runs(const Study& study, const std::vector<StudyRun>& runs, const std::string& glob);

}  // namespace aslio::experiment
