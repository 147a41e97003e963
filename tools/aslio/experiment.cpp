#include <fmt/format.h>

#include <algorithm>
#include <memory>

#include "aslio/core/errors.hpp"
#include "aslio/core/sha256.hpp"
#include "aslio/experiment/study_expectation.hpp"
#include "aslio/experiment/study_placeholders.hpp"
#include "aslio/experiment/study_run.hpp"
#include "aslio/experiment/study_slurm.hpp"
#include "aslio/experiment/study_statistics.hpp"
#include "aslio/simulator/scene.hpp"
#include "command.hpp"
#include "console.hpp"
#include "dataset_options.hpp"
#include "files.hpp"
#include "interrupt.hpp"
#include "options.hpp"
#include "stages.hpp"
#include "study_display.hpp"

namespace aslio::cli {

namespace {

namespace fs = std::filesystem;

struct ExperimentArguments {
  std::string study, output, data, only, seeds, recording;
  std::vector<std::string> plugins, sbatch;
  std::string executor = "local";
  int jobs = 1, throttle = 100;
  double poll = 10;
  double scale = 1;
  bool keep_data = false, retry = false, dry_run = false, quiet = false;
};

std::optional<std::vector<std::uint64_t>> seeds_of(const std::string& text) {
  if (text.empty()) return std::nullopt;
  auto seeds = experiment::parse_seeds(text);
  if (!seeds) throw ConfigError(fmt::format("--seeds {}: give whole numbers and ranges, as in 1-3 or 1,4-6", text));
  return seeds;
}

/// Runs of another program, or with other plugins, are other runs.
std::string program_identity(const Stages& stages) {
  std::string text = sha256_of_file("/proc/self/exe");
  for (const experiment::PluginFile& plugin : stages.files) text.append("\n").append(plugin.sha256);
  return text;
}

/// One recording at a time: a plan may have any number of runs.
void print_plan(const experiment::Study& study, const experiment::StudyOptions& options) {
  const fs::path runs_folder = fs::absolute(options.output) / "runs";
  std::size_t open = 0, finished = 0;
  for (std::size_t d = 0; d < study.data.size(); ++d) {
    std::vector<experiment::StudyRun> runs;
    experiment::append_runs(study, options.program, runs_folder, d, runs);
    const auto selected = experiment::select_runs(study, runs, options.only);
    const auto rows = experiment::rows_so_far(study, runs, options.output);
    const auto standing = experiment::standing_runs(study, options, runs, rows);
    std::string text;
    for (std::size_t i = 0; i < runs.size(); ++i) {
      if (!selected[i]) continue;
      const bool done = standing[i];
      ++(done ? finished : open);
      text += fmt::format("{}/{}: {}\n", study.data[d].name, runs[i].folder, done ? "finished" : "to run");
    }
    print(text);
  }
  print(fmt::format("{} runs to do, {} finished\n", open, finished));
}

/// What the study expected, rule by rule.
void print_expectation(const experiment::Study& study, const experiment::StudyResult& result) {
  const experiment::StudyFigures figures(study, result.runs, result.rows);
  const auto rules = experiment::judge_expectation(study, result.runs, result.rows, figures);
  if (rules.empty()) return;
  print(fmt::format("expectation  {}\n", experiment::to_text(experiment::overall(rules))));
  for (const auto& rule : rules) {
    const std::string open = rule.open.empty() ? "" : fmt::format(" ({})", rule.open);
    print(fmt::format("  {:<13}  {}{}\n", experiment::to_text(rule.verdict), rule.text, open));
  }
}

int report(const experiment::Study& study, StudyDisplay& display, const experiment::StudyResult& result,
           const ExperimentArguments& a) {
  display.clear();
  if (result.interrupted) {
    complain(fmt::format("interrupted: the same command continues where {} stops{}", a.output,
                         a.executor == "slurm" ? "; tasks in the queue continue without it" : ""));
    return kInterrupted;
  }
  const std::size_t failures = result.failures();
  for (const auto& same : experiment::identical_methods(study, result.runs, result.rows)) {
    tell("warning: " + experiment::identical_text(study, same));
  }
  const bool tables = a.recording.empty();
  if (!a.quiet && tables) {
    print(medians_text(study, result.runs, result.rows));
    print_expectation(study, result);
  }
  if (!a.quiet && tables)
    print(fmt::format("output       {}: results.csv, statistics.csv, study.json, table.md, runs, data\n", a.output));
  if (failures == 0) return kSuccess;
  complain(fmt::format("{} of {} runs failed or diverged; {} gives the reasons", failures, result.runs.size(),
                       (fs::path(a.output) / (tables ? "table.md" : "runs")).string()));
  return kRunFailed;
}

/// Checked: a name of no recording would be a study without runs.
std::string recording_of(const experiment::Study& study, const std::string& name) {
  const bool known = name.empty() || std::any_of(study.data.begin(), study.data.end(),
                                                 [&](const auto& data) { return data.name == name; });
  if (!known)
    throw ConfigError(fmt::format("--recording {}: the study has none of that name; --dry-run lists them", name));
  return name;
}

/// This command for one recording, whose name is still missing, from any folder.
std::vector<std::string> command_of(const ExperimentArguments& a) {
  const auto whole = [](const std::string& path) { return fs::absolute(path).lexically_normal().string(); };
  std::vector<std::string> words = {fs::read_symlink("/proc/self/exe").string(),
                                    "experiment",
                                    whole(a.study),
                                    "--output",
                                    whole(a.output),
                                    "--jobs",
                                    fmt::to_string(a.jobs),
                                    "--scale",
                                    fmt::to_string(a.scale),
                                    "--quiet"};
  const auto add = [&words](const char* option, const std::string& value) {
    if (!value.empty()) words.insert(words.end(), {option, value});
  };
  add("--only", a.only);
  add("--seeds", a.seeds);
  add("--data", a.data.empty() ? a.data : whole(a.data));
  for (const std::string& plugin : a.plugins) add("--plugin", whole(plugin));
  if (a.keep_data) words.emplace_back("--keep-data");
  words.emplace_back("--recording");
  return words;
}

/// Throws ConfigError where the folder neither is there nor can be made, because of a file in its place or in that of a
/// folder around it: a study would meet it after its first simulation, and a plan not at all.
void require_folder(const char* option, const std::string& path) {
  const auto refuse = [&](const std::string& problem) {
    throw ConfigError(fmt::format("{} {}: {}; name a folder that exists or can be created", option, path, problem));
  };
  std::error_code error, ignored;
  if (path.empty()) refuse("it is empty");
  fs::path at = fs::absolute(path, error).lexically_normal();
  if (error) refuse(error.message());
  while (!fs::is_directory(at, ignored)) {
    const fs::file_type type = fs::symlink_status(at, error).type();
    if (type == fs::file_type::none) refuse(at.string() + ": " + error.message());
    if (type != fs::file_type::not_found) refuse(at.string() + " is not a folder");
    at = at.parent_path();
  }
}

int run_experiment(const ExperimentArguments& a) {
  catch_interrupts();
  require_folder("--output", a.output);
  if (!a.data.empty()) require_folder("--data", a.data);
  const Stages stages = load_stages(a.plugins);
  const experiment::StudyReading reading{
      .resolve_scene = resolve_scene, .seeds = seeds_of(a.seeds), .scale = a.scale, .families = shipped_families()};
  experiment::Study study = experiment::load_study(a.study, stages.catalog, reading);
  for (const experiment::PluginFile& plugin : stages.files) {
    study.plugins.push_back(plugin.path);
    study.sources.emplace(plugin.path, plugin.sha256);
  }
  experiment::StudyOptions options;
  options.output = a.output;
  if (!a.data.empty()) options.data = a.data;
  options.jobs = a.jobs;
  options.keep_data = a.keep_data;
  options.retry = a.retry;
  options.only = a.only;
  options.recording = recording_of(study, a.recording);
  options.program = program_identity(stages);
  for (const std::string& plugin : a.plugins) {
    options.run_options.insert(options.run_options.end(), {"--plugin", plugin});
  }
  experiment::require_selection(study, options.only);
  if (a.recording.empty()) {  // else the call that this one is a part of has said so
    for (const std::string& warning : experiment::placeholder_warnings(study)) tell("warning: " + warning);
  }
  if (a.dry_run) {
    print_plan(study, options);
    return kSuccess;
  }
  StudyDisplay display(a.quiet, stderr_is_terminal());
  if (a.executor == "local") return report(study, display, experiment::run_study(study, options, display), a);
  experiment::SlurmOptions slurm;
  slurm.command = command_of(a);
  slurm.sbatch = a.sbatch;
  slurm.throttle = a.throttle;
  slurm.poll_s = a.poll;
  return report(study, display, experiment::run_study_on_slurm(study, options, slurm, display), a);
}

void add_options(CLI::App& app, ExperimentArguments& a) {
  app.add_option("STUDY", a.study, "study file (schema: aslio/study/1)")->required()->check(CLI::ExistingFile);
  app.add_option("--output", a.output, "folder for runs and tables; what is finished there is not repeated")
      ->required();
  app.add_option("--jobs", a.jobs, "runs and simulations at once; the tables are the same for any number")
      ->check(whole_number(1, 256))
      ->capture_default_str();
  app.add_option("--only", a.only, "runs whose DATA/METHOD, data or method matches the pattern (*, ?, [..])")
      ->type_name("GLOB");
  app.add_option("--seeds", a.seeds, "seeds that replace those of every scene, as in 1-3 or 1,4-6")->type_name("SEEDS");
  app.add_option("--scale", a.scale, "scales every scene, as in `aslio simulate`")
      ->check(number(0.1, 3))
      ->capture_default_str();
  app.add_option("--data", a.data,
                 "folder for simulated data that several studies share; what lies there already is used and stays");
  app.add_option("--recording", a.recording,
                 "works only on the runs over this recording and writes no tables. Several such calls may share an "
                 "output; a call without it writes the tables")
      ->type_name("DATA");
  app.add_option("--executor", a.executor, "`local`, or `slurm`: a task of a job array per recording")
      ->check(one_of("executor", {"local", "slurm"}))
      ->capture_default_str();
  app.add_option("--sbatch", a.sbatch, "further option of sbatch, as in --sbatch=--partition=long; may be repeated");
  app.add_option("--throttle", a.throttle, "tasks on the cluster at once")
      ->check(whole_number(1, 100000))
      ->capture_default_str();
  app.add_option("--poll", a.poll, "seconds between checks of the queue of the cluster")
      ->check(seconds(true))
      ->capture_default_str();
  app.add_flag("--keep-data", a.keep_data, "keeps simulated data when their last run has ended");
  app.add_flag("--retry", a.retry, "also repeats runs that failed, crashed or met a limit");
  app.add_flag("--dry-run", a.dry_run,
               "checks everything, lists the runs and which of them are finished, runs nothing");
  add_plugin_option(app, a.plugins);
  app.add_flag("--quiet", a.quiet, "no progress and no report; errors remain");
}

}  // namespace

Command add_experiment(CLI::App& root) {
  CLI::App* app = root.add_subcommand("experiment", "Runs a study: methods over data, with tables of the outcome.");
  auto arguments = std::make_shared<ExperimentArguments>();
  add_options(*app, *arguments);
  app->footer(
      "Every run is a process of its own: one that crashes or hangs is a row of the table with its reason.\n\n"
      "Example:\n"
      "  aslio experiment experiments/table_1.yaml --output out/table_1 --jobs 2 --seeds 1-3");
  return {app, [=] { return run_experiment(*arguments); }};
}

}  // namespace aslio::cli
