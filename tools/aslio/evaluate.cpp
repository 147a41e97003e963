#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "aslio/core/errors.hpp"
#include "aslio/evaluation/report.hpp"
#include "aslio/experiment/truth.hpp"
#include "aslio/io/sensor_file.hpp"
#include "command.hpp"
#include "console.hpp"
#include "dataset_options.hpp"
#include "options.hpp"
#include "reference_options.hpp"
#include "stages.hpp"

namespace aslio::cli {

namespace {

struct EvaluateArguments {
  std::string estimate, reference, dataset, data, sensor, alignment = "se3";
  std::vector<std::string> estimate_sets, reference_sets;
  bool json = false, evo = false;
};

evaluation::Alignment alignment_of(const std::string& name) {
  if (name == "none") return evaluation::Alignment::none;
  return name == "yaw" ? evaluation::Alignment::yaw : evaluation::Alignment::se3;
}

/// Poses of the IMU; the keys of a reference say what they are written as, and of which frame.
std::vector<StampedPose> estimated_poses(const EvaluateArguments& a, const io::SensorConfig* sensor) {
  io::ReferenceSpec spec = io::load_reference_spec(a.estimate, a.estimate_sets);
  if (spec.positions_only == io::PositionsOnly::automatic) spec.positions_only = io::PositionsOnly::no;
  const experiment::Truth estimate = experiment::load_truth(spec, sensor);
  for (const std::string& warning : estimate.warnings) tell("warning: " + warning);
  std::vector<StampedPose> poses(estimate.trajectory.samples().begin(), estimate.trajectory.samples().end());
  for (StampedPose& pose : poses) pose.T.p += estimate.origin;
  return poses;
}

/// --reference, or that of the dataset.
io::ReferenceSpec reference_of(const EvaluateArguments& a, const std::optional<experiment::Dataset>& dataset) {
  if (!a.reference.empty()) return io::load_reference_spec(a.reference, a.reference_sets);
  if (dataset && dataset->reference) return io::with_overrides(*dataset->reference, a.reference_sets);
  throw ConfigError(dataset ? fmt::format("--dataset {}: has no reference; give --reference", a.dataset)
                            : "the reference is missing: give --reference, or --dataset with one");
}

int evaluate(const EvaluateArguments& a) {
  std::optional<experiment::Dataset> dataset;
  if (!a.dataset.empty()) dataset = find_dataset(a.dataset, a.data);
  io::SensorConfig read;
  const io::SensorConfig* sensor = nullptr;  // one that was not read has no transform
  if (!a.sensor.empty() || dataset) {
    const std::filesystem::path file = a.sensor.empty() ? dataset->sensor : std::filesystem::path(a.sensor);
    read = io::load_sensor(file, load_stages({}).catalog).value;
    if (!read.placeholder_warning.empty()) tell("warning: " + read.placeholder_warning);
    sensor = &read;
  }
  const auto estimate = estimated_poses(a, sensor);
  const auto truth = experiment::load_truth(reference_of(a, dataset), sensor);
  evaluation::Options options = truth.options();
  if (a.evo) options.rule = evaluation::Rule::evo;
  options.alignment = alignment_of(a.alignment);
  const auto result = experiment::evaluate_against(truth, estimate, options);
  print(a.json ? evaluation::to_json(result).dump(2) + "\n" : evaluation::to_text(result));
  return kSuccess;
}

}  // namespace

Command add_evaluate(CLI::App& root) {
  CLI::App* app = root.add_subcommand("evaluate", "Measures a trajectory against a reference.");
  auto arguments = std::make_shared<EvaluateArguments>();
  app->add_option("ESTIMATE", arguments->estimate, "trajectory, in any format of a reference")
      ->required()
      ->check(CLI::ExistingPath);
  add_reference_options(*app, arguments->reference, arguments->reference_sets);
  add_dataset_options(*app, arguments->dataset, arguments->data);
  app->add_option("--estimate-set", arguments->estimate_sets, "key=value of the estimate, as of --reference-set")
      ->type_name("KEY=VALUE")
      ->allow_extra_args(false);
  app->add_option("--sensor", arguments->sensor, "sensor file whose transforms `frame` names")
      ->transform(shipped_file("sensors"));
  app->add_option("--alignment", arguments->alignment,
                  "of the estimate's world with the reference's: se3 (any rotation and translation), yaw (for a "
                  "vertical z axis: shows tilt) or none (they are the same)")
      ->check(one_of("alignment", {"se3", "yaw", "none"}))
      ->capture_default_str();
  app->add_flag("--json", arguments->json, "all figures as JSON");
  app->add_flag("--evo", arguments->evo, "nearest stamps and equal weights, as evo does");
  app->footer(
      "Example:\n  aslio evaluate out/corridor/trajectory.tum --reference truth.tum --json\n"
      "  aslio evaluate out/eee_01/trajectory.tum --reference eee_01.bag --reference-set protocol=ntu_viral");
  return {app, [=] { return evaluate(*arguments); }};
}

}  // namespace aslio::cli
