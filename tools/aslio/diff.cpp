#include "aslio/config/diff.hpp"

#include <fmt/format.h>

#include <memory>

#include "aslio/core/errors.hpp"
#include "command.hpp"
#include "console.hpp"
#include "files.hpp"
#include "stages.hpp"

namespace aslio::cli {

namespace {

struct DiffArguments {
  std::string a, b;
  std::vector<std::string> plugins;
};

int diff(const DiffArguments& arguments) {
  const Stages stages = load_stages(arguments.plugins);
  const CheckedFile a = read_checked(arguments.a, stages.catalog), b = read_checked(arguments.b, stages.catalog);
  if (a.kind != b.kind) {
    throw ConfigError(fmt::format("{} is a {} file and {} is a {} file: name two of one kind", arguments.a,
                                  config::name(a.kind), arguments.b, config::name(b.kind)));
  }
  const auto differences = config::diff(a.resolved, b.resolved);
  print(differences.empty() ? "no difference\n" : config::to_text(differences));
  return kSuccess;
}

}  // namespace

Command add_diff(CLI::App& root) {
  CLI::App* app = root.add_subcommand(
      "diff", "Prints how two files differ in meaning; spelling, order and omitted defaults do not count.");
  auto arguments = std::make_shared<DiffArguments>();
  app->add_option("A", arguments->a, "a file")->required();
  app->add_option("B", arguments->b, "another of the same kind")->required();
  add_plugin_option(*app, arguments->plugins);
  app->footer("Example:\n  aslio diff configs/pipelines/fixed_window.yaml configs/pipelines/as_lio_plus.yaml");
  return {app, [=] { return diff(*arguments); }};
}

}  // namespace aslio::cli
