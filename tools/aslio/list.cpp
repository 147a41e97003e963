#include <fmt/format.h>

#include <algorithm>
#include <memory>

#include "aslio/core/errors.hpp"
#include "command.hpp"
#include "console.hpp"
#include "stages.hpp"

namespace aslio::cli {

namespace {

struct ListArguments {
  std::string family;
  std::vector<std::string> plugins;
};

int list(const ListArguments& a) {
  const Stages stages = load_stages(a.plugins);
  std::vector<std::string> families = stages.catalog.families();
  if (!a.family.empty()) {
    if (std::find(families.begin(), families.end(), a.family) == families.end()) {
      throw ConfigError(fmt::format("unknown family '{}'; there are: {}", a.family, fmt::join(families, ", ")));
    }
    families = {a.family};
  }
  for (const std::string& family : families) print(family_text(stages.catalog, family));
  return kSuccess;
}

}  // namespace

Command add_list(CLI::App& root) {
  CLI::App* app = root.add_subcommand("list", "Lists the stages there are.");
  auto arguments = std::make_shared<ListArguments>();
  app->add_option("FAMILY", arguments->family, "only this family");
  add_plugin_option(*app, arguments->plugins);
  app->footer("Example:\n  aslio list windows");
  return {app, [=] { return list(*arguments); }};
}

}  // namespace aslio::cli
