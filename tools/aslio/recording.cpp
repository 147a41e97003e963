#include "recording.hpp"

#include <fmt/format.h>

#include "aslio/core/errors.hpp"
#include "aslio/experiment/dataset.hpp"
#include "dataset_options.hpp"
#include "options.hpp"

namespace aslio::cli {

namespace {

void require_one_source(const RecordingArguments& a) {
  if (!a.inputs.empty() && !a.dataset.empty()) {
    throw ConfigError("--input and --dataset exclude each other: a dataset file names its input; leave one out");
  }
  if (a.dataset.empty() && !a.data.empty()) {
    throw ConfigError("--data goes with --dataset FAMILY/SEQUENCE: `aslio datasets` lists the families");
  }
  if (a.inputs.empty() && a.dataset.empty()) {
    throw ConfigError("the recording is missing: give --input and --sensor, or --dataset");
  }
  if (!a.inputs.empty() && a.sensor.empty()) {
    if (std::filesystem::exists(std::filesystem::path(a.inputs.front()) / "dataset.yaml")) {
      throw ConfigError(
          fmt::format("--input {0}: this folder has a dataset.yaml, which names input, sensor and "
                      "reference: give it as --dataset {0}",
                      a.inputs.front()));
    }
    throw ConfigError("--input needs --sensor, the sensor file that fits it (configs/sensors has some)");
  }
}

}  // namespace

CLI::Validator existing_input() {
  return CLI::Validator(
      [](const std::string& path) { return io::is_input(path) ? std::string{} : "Path does not exist: " + path; },
      "PATH");
}

void add_recording_options(CLI::App& app, RecordingArguments& a) {
  app.add_option(
         "--input", a.inputs,
         "recording: a bag (.bag, .mcap, .db3), a network capture, a folder or pattern of parts, or a folder of files; "
         "goes with --sensor; given several times, the inputs are one recording")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll)
      ->check(existing_input());
  add_dataset_options(app, a.dataset, a.data);
  app.add_option("--sensor", a.sensor, "sensor file (schema: aslio/sensor/1)")->transform(shipped_file("sensors"));
  app.add_option("--start", a.start, "seconds of data to skip")->check(seconds(false));
  app.add_option("--duration", a.duration, "seconds of data to use")->check(seconds(true));
}

Recording find_recording(const RecordingArguments& a, const CLI::App& app) {
  require_one_source(a);
  Recording recording;
  if (!a.dataset.empty()) {
    const experiment::Dataset dataset = find_dataset(a.dataset, a.data);
    recording = {dataset.inputs,  dataset.sensor,    dataset.file,       dataset.reference,
                 dataset.section, dataset.published, dataset.closed_loop};
  } else {
    recording.inputs.assign(a.inputs.begin(), a.inputs.end());
  }
  if (!a.sensor.empty()) {
    recording.sensor = a.sensor;
    if (recording.published) recording.published->extrinsic_source = "the file of --sensor";
  }
  if (app.count("--start") > 0) recording.section.start = a.start;
  if (app.count("--duration") > 0) recording.section.duration = a.duration;
  return recording;
}

}  // namespace aslio::cli
