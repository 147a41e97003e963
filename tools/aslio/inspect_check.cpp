#include "inspect_check.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <utility>

#include "aslio/config/load.hpp"
#include "aslio/core/errors.hpp"
#include "aslio/experiment/frame_check.hpp"
#include "aslio/io/sensor_file.hpp"
#include "aslio/io/writers.hpp"
#include "command.hpp"
#include "console.hpp"
#include "data_folder.hpp"
#include "interrupt.hpp"
#include "options.hpp"
#include "progress.hpp"
#include "reference_options.hpp"
#include "stages.hpp"

namespace aslio::cli {

namespace {

/// Each --extrinsic is a sensor file, of which T_imu_lidar alone counts.
std::vector<experiment::PublishedExtrinsic> published(const std::vector<std::string>& files, const Stages& stages) {
  std::vector<experiment::PublishedExtrinsic> out;
  for (const std::string& file : files) {
    const auto sensor = io::load_sensor(file, stages.catalog);
    if (!sensor.value.placeholder_warning.empty()) tell("warning: " + sensor.value.placeholder_warning);
    out.push_back({file, sensor.value.model.T_imu_lidar});
  }
  return out;
}

experiment::FrameCheckOptions options_of(const FrameCheckArguments& a, const Recording& recording,
                                         const Stages& stages) {
  experiment::FrameCheckOptions options;
  options.motion.sensor = io::load_sensor(recording.sensor, stages.catalog).value;
  options.motion.pipeline = a.pipeline;
  if (a.pipeline.empty()) {
    options.motion.pipeline = data_path("configs/pipelines/ct_icp.yaml");
    // The motion within a window is taken for uniform, and that of a gait is not over a whole sweep. A third of a sweep
    // of a spinning sensor sees one side only.
    constexpr int kLinesOfLivox = 6;
    const auto& model = options.motion.sensor.model;
    const bool livox = model.scan_lines <= kLinesOfLivox;
    const double period = model.sweep_period / (livox ? 3 : 2);
    options.motion.overrides = {fmt::format("window.period={:.3f}", period), "window.cut=time"};
    options.slow_overrides.emplace();
  }
  options.motion.inputs = recording.inputs;
  options.motion.section = recording.section;
  options.reference = chosen_reference(recording.reference, a.reference, a.reference_sets);
  if (recording.published) options.published = recording.published->extrinsics;
  for (auto& extrinsic : published(a.extrinsics, stages)) options.published.push_back(std::move(extrinsic));
  return options;
}

/// Nobody's work is overwritten.
void refuse_to_overwrite(const std::string& json) {
  if (!json.empty() && std::filesystem::exists(json)) {
    throw ConfigError(fmt::format("--json {}: the file exists; name another one", json));
  }
}

}  // namespace

void add_frame_check_options(CLI::App& app, FrameCheckArguments& a) {
  app.add_flag("--check", a.check,
               "compares gyro, accelerometer, LiDAR and reference: frames, lever arms, signs and clocks of the files");
  add_reference_options(app, a.reference, a.reference_sets);
  app.add_option("--extrinsic", a.extrinsics,
                 "sensor file whose T_imu_lidar --check compares with the measured one; may be repeated")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll)
      ->check(CLI::ExistingFile);
  app.add_option("--pipeline", a.pipeline,
                 "pipeline without IMU that registers the LiDAR for --check; default: ct_icp.yaml")
      ->transform(shipped_file("pipelines"));
  app.add_option("--json", a.json, "also writes all figures of --check to this file");
  app.add_flag("--quiet", a.quiet, "no progress of --check");
}

std::string option_without_check(const CLI::App& app, const FrameCheckArguments& a) {
  if (a.check) return {};
  for (const char* name :
       {"--reference", "--reference-set", "--extrinsic", "--pipeline", "--json", "--quiet", "--start", "--duration"}) {
    if (app.count(name) > 0) return name;
  }
  return {};
}

int check_recording(const FrameCheckArguments& a, const RecordingArguments& recording, const CLI::App& app) {
  refuse_to_overwrite(a.json);
  catch_interrupts();
  const Stages stages = load_stages({});
  const experiment::FrameCheckOptions options = options_of(a, find_recording(recording, app), stages);
  ProgressDisplay display(a.quiet, stderr_is_terminal());
  const experiment::FrameCheck check = experiment::check_frames(options, stages.catalog, display);
  display.clear();
  for (const std::string& warning : check.measurement.motion.late_warnings) tell("warning: " + warning);
  if (check.measurement.motion.interrupted) {
    tell("interrupted: nothing is judged");
    return kInterrupted;
  }
  print(render(check));
  if (!a.json.empty()) {
    io::AtomicFile file(a.json);
    file.write(experiment::to_json(check));
    file.close();
  }
  return check.contradicts() ? kDegraded : kSuccess;
}

}  // namespace aslio::cli
