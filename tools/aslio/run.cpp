#include "aslio/experiment/run.hpp"

#include <fmt/format.h>

#include <iterator>
#include <limits>
#include <memory>

#include "aslio/core/errors.hpp"
#include "aslio/core/length_unit.hpp"
#include "aslio/experiment/measure.hpp"
#include "command.hpp"
#include "console.hpp"
#include "interrupt.hpp"
#include "options.hpp"
#include "progress.hpp"
#include "recording.hpp"
#include "reference_options.hpp"
#include "stages.hpp"

namespace aslio::cli {

namespace {

struct RunArguments {
  std::string pipeline, output, reference, save_map;
  RecordingArguments recording;
  std::vector<std::string> overrides, reference_sets, plugins;
  int threads = 1;
  std::uint64_t seed = 0;
  bool closed_loop = false, dense = false, stop_when_diverged = false, quiet = false;
};

int exit_code(const experiment::RunResult& result) {
  using pipeline::RunStatus;
  switch (result.summary.status) {
    case RunStatus::ok:
      return result.summary.evaluation_error.empty() ? kSuccess : kBadData;
    case RunStatus::degraded:
      return result.summary.evaluation_error.empty() ? kDegraded : kBadData;
    case RunStatus::truncated:
      return kBadData;
    case RunStatus::interrupted:
      return kInterrupted;
    case RunStatus::diverged:
      return kRunFailed;
    case RunStatus::failed:
      return result.bad_data ? kBadData : kRunFailed;
  }
  return kRunFailed;
}

/// A moment to the nanosecond; a double would be 240 ns off.
std::string exact_seconds(TimeNs t) {
  const TimeNs whole = t / kSecond, rest = t % kSecond;
  return fmt::format("{}{}.{:09}", t < 0 && whole == 0 ? "-" : "", whole, rest < 0 ? -rest : rest);
}

/// An error of position, in the unit that the report gives a table of such: 23.4 mm, 0.234 m.
std::string length_text(double metres) {
  const LengthUnit unit = length_unit(metres);
  return fmt::format("{:.{}f} {}", unit.scale * metres, unit.scale > 1 ? 1 : 3, unit.name);
}

/// A reference of positions only tells none.
std::string rotation_text(const evaluation::Statistics& rotation) {
  return rotation.n > 0 ? fmt::format("{:.3f} deg", rotation.rmse) : "no rotation";
}

std::string report(const experiment::Summary& s, const std::string& output) {
  std::string text = fmt::format("status       {}", pipeline::name(s.status));
  const auto out = std::back_inserter(text);
  if (!s.reason.empty()) fmt::format_to(out, ": {}", s.reason);
  if (s.moment) fmt::format_to(out, " (at {} s)", exact_seconds(*s.moment));
  fmt::format_to(out, "\nupdates      {} over {:.2f} s of data, coverage {:.1f} %\n", s.updates, s.data_s,
                 100 * s.coverage);
  if (const std::string weak = experiment::weak_updates(s); !weak.empty()) {
    fmt::format_to(out, "weak         {}\n", weak);
  }
  if (const std::string open = pipeline::unbound_text(s.monitor); !open.empty()) {
    fmt::format_to(out, "not bound    {}\n", open);
  }
  if (s.rate_hz) {
    fmt::format_to(out, "rate         {:.1f} / {:.1f} / {:.1f} Hz (min / median / max)\n", s.rate_hz->min,
                   s.rate_hz->median, s.rate_hz->max);
  }
  fmt::format_to(out, "path         {:.2f} m", s.path_length_m);
  if (s.end_to_end_m) fmt::format_to(out, ", end to end {}", length_text(*s.end_to_end_m));
  if (s.evaluation) {
    fmt::format_to(out, "\naccuracy     ATE {}, {}; {:.1f} % of the poses matched",
                   length_text(s.evaluation->ate.translation.rmse), rotation_text(s.evaluation->ate.rotation),
                   100 * s.evaluation->matched_share);
    if (const auto rpe = experiment::headline_rpe(*s.evaluation)) {
      fmt::format_to(out, "; RPE {} over {:g} m", length_text(rpe->rmse_m), rpe->distance_m);
    }
    if (s.evaluation->score) fmt::format_to(out, "; score {:.2f} of 100", *s.evaluation->score);
    for (const std::string& note : s.evaluation->notes) fmt::format_to(out, "\nreference    {}", note);
    for (const std::string& warning : s.evaluation->warnings)
      fmt::format_to(out, "\nreference    warning: {}", warning);
  }
  if (const std::string learnt = s.calibration ? to_text(*s.calibration) : ""; !learnt.empty()) {
    fmt::format_to(out, "\ncalibration  {}", learnt);
  }
  fmt::format_to(out, "\ncost         {:.2f} s CPU ({:.3f} s per s of data), peak memory {:.0f} MB\n", s.cpu_s,
                 s.data_s > 0 ? s.cpu_s / s.data_s : 0.0, s.peak_rss_mb);
  fmt::format_to(out, "output       {}\n", output);
  return text;
}

experiment::RunOptions options_of(const RunArguments& a, const Stages& stages, const CLI::App& app,
                                  const std::vector<std::string>& command_line) {
  const Recording recording = find_recording(a.recording, app);
  experiment::RunOptions options;
  options.input = recording.inputs.front();
  options.more_inputs.assign(recording.inputs.begin() + 1, recording.inputs.end());
  options.sensor = recording.sensor;
  options.dataset = recording.dataset;
  options.published = recording.published;
  options.reference = chosen_reference(recording.reference, a.reference, a.reference_sets);
  options.section = recording.section;
  options.closed_loop = recording.closed_loop || a.closed_loop;
  options.pipeline = a.pipeline;
  options.overrides = a.overrides;
  options.output = a.output;
  options.threads = a.threads;
  if (!a.save_map.empty()) options.save_map = a.save_map;
  options.dense = a.dense;
  options.stop_when_diverged = a.stop_when_diverged;
  options.order_seed = a.seed;
  options.plugins = stages.files;
  options.command_line = command_line;
  return options;
}

/// To be said for version 0.2.0 alone.
constexpr const char* kNewMeaning =
    "as_lio is the method of the paper. Before version 0.2.0 this name meant our own pipeline, which is now "
    "as_lio_plus.";

int run_pipeline(const RunArguments& a, const CLI::App& app, const std::vector<std::string>& command_line) {
  catch_interrupts();
  const Stages stages = load_stages(a.plugins);
  ProgressDisplay display(a.quiet, stderr_is_terminal());
  if (std::filesystem::path(a.pipeline).filename() == "as_lio.yaml") display.on_notice(kNewMeaning);
  const experiment::RunOptions options = options_of(a, stages, app, command_line);
  const auto result = experiment::run(options, stages.catalog, display, make_logger(a.quiet));
  display.clear();
  const int code = exit_code(result);
  for (const std::string& warning : result.late_warnings) tell("warning: " + warning);
  const experiment::Summary& summary = result.summary;
  const bool ended_well = summary.status == pipeline::RunStatus::ok || summary.status == pipeline::RunStatus::degraded;
  if (!ended_well) {
    complain(fmt::format("{}: {}: {}", options.input.string(), pipeline::name(summary.status), summary.reason));
  }
  // Of a run that came to nothing the first error is reason enough.
  if (!summary.evaluation_error.empty() && (ended_well || summary.accepted > 0)) {
    complain(fmt::format("--reference {}: {}", options.reference->file, summary.evaluation_error));
  }
  if (!a.quiet) print(report(result.summary, a.output));
  return code;
}

void add_options(CLI::App& app, RunArguments& a) {
  app.add_option("PIPELINE", a.pipeline, "pipeline file (schema: aslio/pipeline/1)")
      ->required()
      ->transform(shipped_file("pipelines"));
  add_recording_options(app, a.recording);
  app.add_option("--output", a.output, "folder for the results; files of an earlier run are replaced")->required();
  app.add_option("--set", a.overrides, "key.path=value (YAML); changes the pipeline, may be repeated")
      ->type_name("KEY=VALUE")
      ->allow_extra_args(false);
  app.add_option("--threads", a.threads, "threads; the results are the same for any number")
      ->check(whole_number(1, 256))
      ->capture_default_str();
  add_reference_options(app, a.reference, a.reference_sets);
  app.add_flag(
      "--closed-loop", a.closed_loop,
      "the motion ends in the pose in which it begins: measures the end-to-end error, as `closed_loop: true` of "
      "a dataset does");
  app.add_option(
      "--save-map", a.save_map,
      "writes the points of all updates to this .ply or .pcd file; after a loss, to others beside it (.segment_2)");
  app.add_flag("--dense", a.dense, "also writes trajectory_dense.tum, with every state the estimator emits");
  app.add_flag("--stop-when-diverged", a.stop_when_diverged,
               "ends the run once it has diverged by its own verdict, or its position is off by more than 2 m and 5 % "
               "of the reference's path");
  app.add_option(
         "--seed", a.seed,
         "offset of the first window (0 to 0.1 s; 0: none) and phase of the point strides: replicates differ in it")
      ->check(whole_number(0, std::numeric_limits<std::uint64_t>::max()))
      ->capture_default_str();
  add_plugin_option(app, a.plugins);
  app.add_flag("--quiet", a.quiet, "no progress and no report; warnings and errors remain");
}

}  // namespace

Command add_run(CLI::App& root, const std::vector<std::string>& command_line) {
  CLI::App* app = root.add_subcommand("run", "Runs a pipeline over a recording.");
  auto arguments = std::make_shared<RunArguments>();
  add_options(*app, *arguments);
  app->footer(
      "Writes trajectory.tum, trajectory_lidar.tum, updates.csv, timings.csv, summary.json, resolved.yaml and "
      "manifest.json.\n\n"
      "Example:\n"
      "  aslio run configs/pipelines/as_lio_plus.yaml --input corridor.bag --sensor configs/sensors/livox_avia.yaml "
      "--output out/corridor --set window.seg_step=0.04 --save-map out/corridor/map.ply\n"
      "  aslio run configs/pipelines/as_lio_plus.yaml --dataset out/quickstart/data --output "
      "out/quickstart/as_lio_plus");
  return {app, [=] { return run_pipeline(*arguments, *app, command_line); }};
}

}  // namespace aslio::cli
