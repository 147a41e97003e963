#include "aslio/io/inspect.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <memory>

#include "aslio/config/load.hpp"
#include "aslio/core/errors.hpp"
#include "aslio/io/writers.hpp"
#include "command.hpp"
#include "console.hpp"
#include "recording.hpp"
#include "stages.hpp"

namespace aslio::cli {

namespace {

struct InspectArguments {
  std::string path, sensor, draft;
};

/// Nobody's work is overwritten: a sensor file holds what was measured by hand.
void write_draft(const InspectArguments& a, const io::InputReport& report) {
  if (std::filesystem::exists(a.draft)) {
    throw ConfigError(fmt::format("--write-sensor {}: the file exists; name another one", a.draft));
  }
  io::AtomicFile file(a.draft);
  file.write(io::draft_sensor(report));
  file.close();
  print(fmt::format("sensor file written: {}; fill in T_imu_lidar\n", a.draft));
}

int inspect(const InspectArguments& a) {
  io::SensorConfig sensor;
  if (!a.sensor.empty()) {
    sensor = config::load<io::SensorConfig>(a.sensor, config::FileKind::sensor, load_stages({}).catalog).value;
  }
  const io::InputReport report = io::inspect(a.path, sensor);
  print(io::render(report));
  if (!a.draft.empty()) write_draft(a, report);
  if (!report.usable) complain(fmt::format("{}: unusable: {}", a.path, report.reason));
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
      ->required()
      ->check(existing_input());
  app->add_option("--sensor", arguments->sensor, "judges as a run with this sensor file would")
      ->check(CLI::ExistingFile);
  app->add_option("--write-sensor", arguments->draft, "write the sensor file that fits what was found");
  app->footer(
      "Exits with 3 when a run could not use the recording, or when it is truncated.\n\n"
      "Example:\n  aslio inspect corridor.bag --sensor configs/sensors/livox_avia.yaml");
  return {app, [=] { return inspect(*arguments); }};
}

}  // namespace aslio::cli
