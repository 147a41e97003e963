#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "aslio/evaluation/report.hpp"
#include "aslio/experiment/measure.hpp"
#include "aslio/io/writers.hpp"
#include "command.hpp"
#include "console.hpp"
#include "options.hpp"

namespace aslio::cli {

namespace {

struct EvaluateArguments {
  std::string estimate, reference, alignment = "se3";
  bool json = false, evo = false;
};

evaluation::Alignment alignment_of(const std::string& name) {
  if (name == "none") return evaluation::Alignment::none;
  return name == "yaw" ? evaluation::Alignment::yaw : evaluation::Alignment::se3;
}

int evaluate(const EvaluateArguments& a) {
  const Trajectory estimate(io::read_tum(a.estimate)), reference(io::read_tum(a.reference));
  const auto rule = a.evo ? evaluation::Rule::evo : evaluation::Rule::interpolated;
  auto options = experiment::measuring_options(reference, rule);
  options.alignment = alignment_of(a.alignment);
  const auto result = evaluation::evaluate(estimate, reference, options);
  print(a.json ? evaluation::to_json(result).dump(2) + "\n" : evaluation::to_text(result));
  return kSuccess;
}

}  // namespace

Command add_evaluate(CLI::App& root) {
  CLI::App* app = root.add_subcommand("evaluate", "Measures a trajectory against a reference.");
  auto arguments = std::make_shared<EvaluateArguments>();
  app->add_option("ESTIMATE", arguments->estimate, "trajectory (TUM)")->required()->check(CLI::ExistingFile);
  app->add_option("--reference", arguments->reference, "reference trajectory (TUM)")
      ->required()
      ->check(CLI::ExistingFile);
  app->add_option("--alignment", arguments->alignment,
                  "of the estimate's world with the reference's: se3 (any rotation and translation), yaw (for a "
                  "vertical z axis: shows tilt) or none (they are the same)")
      ->check(one_of("alignment", {"se3", "yaw", "none"}))
      ->capture_default_str();
  app->add_flag("--json", arguments->json, "all figures as JSON");
  app->add_flag("--evo", arguments->evo, "nearest stamps and equal weights, as evo does");
  app->footer("Example:\n  aslio evaluate out/corridor/trajectory.tum --reference truth.tum --json");
  return {app, [=] { return evaluate(*arguments); }};
}

}  // namespace aslio::cli
