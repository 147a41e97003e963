#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <memory>
#include <string_view>

#include "aslio/core/angles.hpp"
#include "aslio/core/errors.hpp"
#include "aslio/experiment/overlap_series.hpp"
#include "aslio/io/writers.hpp"
#include "command.hpp"
#include "console.hpp"
#include "interrupt.hpp"
#include "options.hpp"
#include "progress.hpp"
#include "recording.hpp"
#include "stages.hpp"

namespace aslio::cli {

namespace {

struct OverlapArguments {
  std::string pipeline, trajectory, output;
  RecordingArguments recording;
  std::vector<std::string> overrides, plugins;
  double period = 0.1, position_error = 0, rotation_error = 0;
  std::uint64_t seed = 0;
  bool quiet = false;
};

experiment::OverlapSeriesOptions options_of(const OverlapArguments& a, const Recording& recording) {
  experiment::OverlapSeriesOptions options;
  options.pipeline = a.pipeline;
  options.overrides = a.overrides;
  options.inputs = recording.inputs;
  options.sensor = recording.sensor;
  options.section = recording.section;
  if (recording.reference) options.trajectory = *recording.reference;
  if (!a.trajectory.empty()) options.trajectory = io::load_reference_spec(a.trajectory);
  if (options.trajectory.file.empty()) {
    throw ConfigError("the poses of the frames are missing: give --trajectory, or a dataset with a reference");
  }
  options.period = a.period;
  options.position_error = a.position_error;
  options.rotation_error = a.rotation_error * kRadPerDeg;
  options.seed = a.seed;
  return options;
}

/// Means over the frames that have a score.
struct Means {
  double score = 0, change = 0;
  std::size_t scores = 0, changes = 0;
  void add(const experiment::OverlapSample& sample) {
    if (!sample.score.value) return;
    score += *sample.score.value;
    ++scores;
    if (!sample.moved) return;
    change += std::abs(*sample.moved - *sample.score.value);
    ++changes;
  }
};

std::string report(const OverlapArguments& a, const experiment::OverlapSeriesEnd& end, const Means& means) {
  std::string text =
      fmt::format("frames       {} of {:g} s, {} with points at a pose", end.frames, a.period, end.scored);
  if (end.points_without_pose > 0) text += fmt::format("; {} points have no pose", end.points_without_pose);
  if (means.scores > 0) {
    text += fmt::format("\noverlap      mean {:.4f}", means.score / static_cast<double>(means.scores));
  }
  if (means.changes > 0) {
    text += fmt::format("; changed by {:.4f} on average at poses off by {:g} m and {:g} deg",
                        means.change / static_cast<double>(means.changes), a.position_error, a.rotation_error);
  }
  return text + fmt::format("\noutput       {}\n", a.output);
}

void refuse_to_overwrite(const experiment::OverlapSeriesOptions& options, const std::filesystem::path& dataset,
                         const std::string& output) {
  std::vector<std::filesystem::path> read{options.pipeline, options.sensor, options.trajectory.file, dataset};
  read.insert(read.end(), options.inputs.begin(), options.inputs.end());
  for (const auto& input : read) {
    std::error_code none;
    if (!input.empty() && std::filesystem::equivalent(input, output, none)) {
      throw ConfigError(fmt::format("--output {}: is read by this command; name another file", output));
    }
  }
}

int score(const OverlapArguments& a, const CLI::App& app) {
  catch_interrupts();
  const Stages stages = load_stages(a.plugins);
  const Recording recording = find_recording(a.recording, app);
  const auto options = options_of(a, recording);
  refuse_to_overwrite(options, recording.dataset.value_or(""), a.output);
  io::AtomicFile file(a.output);
  file.write(experiment::overlap_series_header());
  Means means;
  std::size_t lines = 0;
  const auto take = [&](const experiment::OverlapSample& sample) {
    means.add(sample);
    file.write(experiment::overlap_series_line(sample));
    ++lines;
  };
  ProgressDisplay display(a.quiet, stderr_is_terminal());
  const experiment::OverlapSeriesEnd end = experiment::score_overlap(options, stages.catalog, take, display);
  display.clear();
  for (const std::string& warning : end.late_warnings) tell("warning: " + warning);
  if (lines > 0) file.close();
  const auto kept = [&](std::string_view join) {
    return lines > 0 ? fmt::format("{}{} has the {} frames before", join, a.output, lines) : "";
  };
  if (end.failure) {
    complain(*end.failure + kept("; "));
    return end.bad_data ? kBadData : kRunFailed;
  }
  if (end.interrupted) {
    tell("interrupted" + kept(": "));
    return kInterrupted;
  }
  if (!a.quiet) print(report(a, end, means));
  if (end.truncated) {
    complain(fmt::format("{}: the input ends inside its last record", options.inputs.front().string()));
  }
  return end.truncated ? kBadData : kSuccess;
}

void add_options(CLI::App& app, OverlapArguments& a) {
  app.add_option("PIPELINE", a.pipeline, "pipeline file (schema: aslio/pipeline/1) with the overlap to score")
      ->required()
      ->transform(shipped_file("pipelines"));
  add_recording_options(app, a.recording);
  app.add_option("--trajectory", a.trajectory, "poses of the IMU (TUM); default: the reference of the dataset")
      ->check(CLI::ExistingFile);
  app.add_option("--output", a.output, "CSV file: a line for each frame")->required();
  app.add_option("--period", a.period, "length of a frame [s]")->check(number(0.001, 10))->capture_default_str();
  app.add_option("--position-error", a.position_error, "scores each frame also with its pose off by so many metres")
      ->check(number(0, 10))
      ->capture_default_str();
  app.add_option("--rotation-error", a.rotation_error, "and turned by so many degrees")
      ->check(number(0, 180))
      ->capture_default_str();
  app.add_option("--seed", a.seed, "of the directions of these errors, which differ from frame to frame")
      ->check(whole_number(0, std::numeric_limits<std::uint64_t>::max()))
      ->capture_default_str();
  app.add_option("--set", a.overrides, "key.path=value (YAML); changes the pipeline, may be repeated")
      ->type_name("KEY=VALUE")
      ->allow_extra_args(false);
  add_plugin_option(app, a.plugins);
  app.add_flag("--quiet", a.quiet, "no progress and no report; warnings and errors remain");
}

}  // namespace

Command add_overlap(CLI::App& root) {
  CLI::App* app = root.add_subcommand(
      "overlap", "Scores a recording with the overlap metric of a pipeline, at the poses of a trajectory.");
  auto arguments = std::make_shared<OverlapArguments>();
  add_options(*app, *arguments);
  app->footer(
      "Example:\n"
      "  aslio overlap configs/pipelines/as_lio_plus.yaml --dataset out/indoor_1 --output out/overlap.csv "
      "--set overlap.voxel=0.2 --position-error 0.02 --rotation-error 0.3");
  return {app, [=] { return score(*arguments, *app); }};
}

}  // namespace aslio::cli
