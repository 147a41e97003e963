#include <fmt/format.h>

#include <memory>

#include "aslio/config/load.hpp"
#include "aslio/core/errors.hpp"
#include "aslio/io/source.hpp"
#include "aslio/pipeline/odometry.hpp"
#include "command.hpp"
#include "console.hpp"
#include "stages.hpp"

namespace aslio::cli {

namespace {

struct Arguments {
  std::vector<std::string> files, plugins;
};

/// Reads the file as what its schema line says it is. Throws ConfigError with everything that is wrong with it.
config::FileKind check_file(const std::string& file, const plugin::Catalog& catalog) {
  const config::FileKind kind = config::peek_kind(file);
  switch (kind) {
    case config::FileKind::pipeline:
      config::load<pipeline::PipelineConfig>(file, kind, catalog);
      return kind;
    case config::FileKind::sensor:
      config::load<io::SensorConfig>(file, kind, catalog);
      return kind;
    default:
      throw ConfigError(fmt::format("{}: this version cannot check a {} file; it checks pipeline and sensor files",
                                    file, config::name(kind)));
  }
}

int check(const Arguments& a) {
  const Stages stages = load_stages(a.plugins);
  int code = kSuccess;
  for (const std::string& file : a.files) {
    try {
      const config::FileKind kind = check_file(file, stages.catalog);
      print(fmt::format("{}: ok ({})\n", file, config::name(kind)));
    } catch (const ConfigError& error) {
      complain(error.what());
      code = kWrongUsage;
    }
  }
  return code;
}

}  // namespace

Command add_check(CLI::App& root) {
  CLI::App* app = root.add_subcommand("check", "Checks pipeline and sensor files and tells everything that is wrong.");
  auto arguments = std::make_shared<Arguments>();
  app->add_option("FILE", arguments->files, "files to check")->required();
  add_plugin_option(*app, arguments->plugins);
  app->footer("Example:\n  aslio check configs/pipelines/as_lio.yaml configs/sensors/livox_avia.yaml");
  return {app, [=] { return check(*arguments); }};
}

}  // namespace aslio::cli
