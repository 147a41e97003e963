#include "aslio/io/inspect.hpp"

#include <fmt/format.h>

#include <memory>

#include "aslio/config/load.hpp"
#include "command.hpp"
#include "console.hpp"
#include "stages.hpp"

namespace aslio::cli {

namespace {

struct InspectArguments {
  std::string path, sensor;
};

int inspect(const InspectArguments& a) {
  io::SensorConfig sensor;
  if (!a.sensor.empty()) {
    sensor = config::load<io::SensorConfig>(a.sensor, config::FileKind::sensor, load_stages({}).catalog).value;
  }
  const io::InputReport report = io::inspect(a.path, sensor);
  print(io::render(report));
  if (!report.usable) complain(fmt::format("{}: unusable: {}", a.path, report.reason));
  return report.usable && report.status == io::InputStatus::complete ? kSuccess : kBadData;
}

}  // namespace

Command add_inspect(CLI::App& root) {
  CLI::App* app = root.add_subcommand(
      "inspect", "Reads a whole recording and prints topics, rates, gaps, units and the state of point times.");
  auto arguments = std::make_shared<InspectArguments>();
  app->add_option("PATH", arguments->path, "ROS1 bag, or KITTI raw drive folder")->required()->check(CLI::ExistingPath);
  app->add_option("--sensor", arguments->sensor, "judges as a run with this sensor file would")
      ->check(CLI::ExistingFile);
  app->footer(
      "Exits with 3 when a run could not use the recording, or when it is truncated.\n\n"
      "Example:\n  aslio inspect corridor.bag --sensor configs/sensors/livox_avia.yaml");
  return {app, [=] { return inspect(*arguments); }};
}

}  // namespace aslio::cli
