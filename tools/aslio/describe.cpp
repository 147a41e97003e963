#include <fmt/format.h>

#include <memory>

#include "aslio/config/description.hpp"
#include "aslio/core/errors.hpp"
#include "aslio/io/source.hpp"
#include "aslio/pipeline/odometry.hpp"
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

std::string facts(const config::Field& field) {
  std::string text = field.type;
  if (!field.range.empty()) {
    text += ", " + field.range;
  } else if (!field.unit.empty()) {
    text += " [" + field.unit + "]";
  }
  if (field.default_value == "required") return text + ", required";
  return field.default_value.empty() ? text : text + ", default " + field.default_value;
}

/// The keys of a whole file.
template <class Config>
std::string describe_file(const plugin::Catalog& catalog, std::string_view kind) {
  const auto description = config::describe([](config::Binder& binder) {
    Config defaults;
    Config::describe(binder, defaults);
  });
  std::string text = fmt::format("{} file, begins with `schema: aslio/{}/1`\n", kind, kind);
  for (const config::Field& field : description.fields) {
    text += fmt::format("\n  {}: {}\n      {}\n", field.path, facts(field), field.doc);
    if (!field.family.empty()) {
      text += fmt::format("      {}: {}\n", field.family, fmt::join(catalog.types(field.family), ", "));
    }
  }
  for (const config::RemovedKey& key : description.removed) {
    text += fmt::format("\n  {}: removed, {}\n", key.path, key.advice);
  }
  return text;
}

int describe(const Arguments& a) {
  const Stages stages = load_stages(a.plugins);
  if (!a.markdown && (a.stage == "pipeline" || a.stage == "sensor")) {
    print(a.stage == "sensor" ? describe_file<io::SensorConfig>(stages.catalog, a.stage)
                              : describe_file<pipeline::PipelineConfig>(stages.catalog, a.stage));
    return kSuccess;
  }
  if (a.markdown && a.stage.empty()) {
    print(config::plugin_reference(stages.catalog));
    return kSuccess;
  }
  const std::size_t slash = a.stage.find('/');
  if (a.markdown || slash == std::string::npos) {
    throw ConfigError(
        fmt::format("name a stage as FAMILY/TYPE (for example windows/fixed; `aslio list` tells them), a file as "
                    "'pipeline' or 'sensor', or --markdown for all stages, not '{}'",
                    a.stage));
  }
  print(config::describe_stage(stages.catalog, a.stage.substr(0, slash), a.stage.substr(slash + 1)));
  return kSuccess;
}

}  // namespace

Command add_describe(CLI::App& root) {
  CLI::App* app = root.add_subcommand(
      "describe", "Tells the parameters of a stage, or the keys of a file: unit, range, default, meaning.");
  auto arguments = std::make_shared<Arguments>();
  app->add_option("FAMILY/TYPE", arguments->stage, "the stage, or the file: pipeline, sensor");
  app->add_flag("--markdown", arguments->markdown, "all stages, as a page of Markdown");
  add_plugin_option(*app, arguments->plugins);
  app->footer("Example:\n  aslio describe windows/sod_adaptive\n  aslio describe sensor");
  return {app, [=] { return describe(*arguments); }};
}

}  // namespace aslio::cli
