#include <fmt/format.h>

#include <memory>

#include "aslio/config/description.hpp"
#include "aslio/core/errors.hpp"
#include "command.hpp"
#include "console.hpp"
#include "stages.hpp"

namespace aslio::cli {

namespace {

struct Arguments {
  std::string stage;
  std::vector<std::string> plugins;
  bool markdown = false;
};

int describe(const Arguments& a) {
  const Stages stages = load_stages(a.plugins);
  if (a.markdown && a.stage.empty()) {
    print(config::plugin_reference(stages.catalog));
    return kSuccess;
  }
  const std::size_t slash = a.stage.find('/');
  if (a.markdown || slash == std::string::npos) {
    throw ConfigError(
        fmt::format("name a stage as FAMILY/TYPE (for example windows/fixed; `aslio list` tells them), or "
                    "--markdown for all, not '{}'",
                    a.stage));
  }
  print(config::describe_stage(stages.catalog, a.stage.substr(0, slash), a.stage.substr(slash + 1)));
  return kSuccess;
}

}  // namespace

Command add_describe(CLI::App& root) {
  CLI::App* app = root.add_subcommand("describe", "Tells the parameters of a stage: unit, range, default, meaning.");
  auto arguments = std::make_shared<Arguments>();
  app->add_option("FAMILY/TYPE", arguments->stage, "the stage");
  app->add_flag("--markdown", arguments->markdown, "all stages, as a page of Markdown");
  add_plugin_option(*app, arguments->plugins);
  app->footer("Example:\n  aslio describe windows/sod_adaptive");
  return {app, [=] { return describe(*arguments); }};
}

}  // namespace aslio::cli
