#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "aslio/evaluation/report.hpp"
#include "aslio/experiment/measure.hpp"
#include "aslio/io/writers.hpp"
#include "command.hpp"
#include "console.hpp"

namespace aslio::cli {

namespace {

struct Arguments {
  std::string estimate, reference;
  bool json = false, evo = false;
};

int evaluate(const Arguments& a) {
  const Trajectory estimate(io::read_tum(a.estimate)), reference(io::read_tum(a.reference));
  const auto rule = a.evo ? evaluation::Rule::evo : evaluation::Rule::interpolated;
  const auto result = evaluation::evaluate(estimate, reference, experiment::measuring_options(reference, rule));
  print(a.json ? evaluation::to_json(result).dump(2) + "\n" : evaluation::to_text(result));
  return kSuccess;
}

}  // namespace

Command add_evaluate(CLI::App& root) {
  CLI::App* app = root.add_subcommand("evaluate", "Measures a trajectory against a reference.");
  auto arguments = std::make_shared<Arguments>();
  app->add_option("ESTIMATE", arguments->estimate, "trajectory (TUM)")->required()->check(CLI::ExistingFile);
  app->add_option("--reference", arguments->reference, "reference trajectory (TUM)")
      ->required()
      ->check(CLI::ExistingFile);
  app->add_flag("--json", arguments->json, "all figures as JSON");
  app->add_flag("--evo", arguments->evo, "nearest stamps and equal weights, as evo does");
  app->footer("Example:\n  aslio evaluate out/corridor/trajectory.tum --reference truth.tum --json");
  return {app, [=] { return evaluate(*arguments); }};
}

}  // namespace aslio::cli
