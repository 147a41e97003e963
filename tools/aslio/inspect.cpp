#include "aslio/io/inspect.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <vector>

#include "aslio/core/errors.hpp"
#include "aslio/io/sensor_file.hpp"
#include "aslio/io/writers.hpp"
#include "command.hpp"
#include "console.hpp"
#include "inspect_check.hpp"
#include "recording.hpp"
#include "stages.hpp"

namespace aslio::cli {

namespace {

struct InspectArguments {
  std::string path, draft;
  RecordingArguments recording;
  FrameCheckArguments frames;
};

/// Nobody's work is overwritten: a sensor file holds what was measured by hand.
void write_draft(const InspectArguments& a, const io::InputReport& report) {
  if (std::filesystem::exists(a.draft)) {
    throw ConfigError(fmt::format("--write-sensor {}: the file exists; name another one", a.draft));
  }
  io::AtomicFile file(a.draft);
  file.write(io::draft_sensor(report));
  file.close();
  print(fmt::format("sensor file written: {}; replace T_imu_lidar, a placeholder\n", a.draft));
}

/// PATH is short for --input.
RecordingArguments recording_of(const InspectArguments& a) {
  RecordingArguments recording = a.recording;
  if (!a.path.empty()) recording.inputs.insert(recording.inputs.begin(), a.path);
  return recording;
}

int inspect(const InspectArguments& a, const CLI::App& app) {
  RecordingArguments recording = recording_of(a);
  if (a.frames.check) {
    if (!a.draft.empty()) throw ConfigError("--write-sensor goes without --check: draft the sensor file first");
    return check_recording(a.frames, recording, app);
  }
  if (const std::string name = option_without_check(app, a.frames); !name.empty()) {
    throw ConfigError(fmt::format("{} is an option of --check: give that, too, or leave it out", name));
  }
  if (recording.dataset.empty() && recording.inputs.empty()) {
    throw ConfigError("the recording is missing: give PATH, or --dataset");
  }
  std::vector<std::filesystem::path> inputs(recording.inputs.begin(), recording.inputs.end());
  std::filesystem::path sensor_file = recording.sensor;
  if (!recording.dataset.empty()) {
    const Recording found = find_recording(recording, app);
    inputs = found.inputs;
    sensor_file = found.sensor;
  }
  io::SensorConfig sensor;
  if (!sensor_file.empty()) {
    sensor = io::load_sensor(sensor_file, load_stages({}).catalog).value;
  }
  const io::InputReport report = io::inspect(inputs, sensor);
  print(io::render(report));
  if (!a.draft.empty()) write_draft(a, report);
  if (!report.usable) complain(fmt::format("{}: unusable: {}", report.name, report.reason));
  return report.usable && report.status == io::InputStatus::complete ? kSuccess : kBadData;
}

}  // namespace

Command add_inspect(CLI::App& root) {
  CLI::App* app = root.add_subcommand(
      "inspect", "Reads a whole recording and prints topics, rates, gaps, units and the state of point times.");
  auto arguments = std::make_shared<InspectArguments>();
  app->add_option(
         "PATH", arguments->path,
         "recording: a bag (.bag, .mcap, .db3), a network capture, a folder or pattern of parts, or a folder of files")
      ->check(existing_input());
  add_recording_options(*app, arguments->recording);
  app->add_option("--write-sensor", arguments->draft, "write the sensor file that fits what was found");
  add_frame_check_options(*app, arguments->frames);
  app->footer(
      "Exits with 3 when a run could not use the recording, or when it is truncated. With --check, exits with 4 when "
      "the data contradict the files.\n\n"
      "Example:\n  aslio inspect corridor.bag --sensor configs/sensors/livox_avia.yaml\n"
      "  aslio inspect --dataset out/indoor_1 --check");
  return {app, [=] { return inspect(*arguments, *app); }};
}

}  // namespace aslio::cli
