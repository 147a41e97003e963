#include <fmt/format.h>

#include <memory>
#include <stdexcept>

#include "aslio/core/errors.hpp"
#include "aslio/pipeline/stage_set.hpp"
#include "command.hpp"
#include "console.hpp"
#include "files.hpp"
#include "stages.hpp"

namespace aslio::cli {

namespace {

struct CheckArguments {
  std::vector<std::string> files, plugins;
};

int check(const CheckArguments& a) {
  const Stages stages = load_stages(a.plugins);
  int code = kSuccess;
  for (const std::string& file : a.files) {
    try {
      const CheckedFile read = read_checked(file, stages.catalog);
      if (read.kind == config::FileKind::pipeline) {
        pipeline::check_stages(
            config::load<pipeline::PipelineConfig>(file, config::FileKind::pipeline, stages.catalog));
      }
      for (const std::string& warning : read.warnings) tell("warning: " + warning);
      print(fmt::format("{}: ok ({})\n", file, config::name(read.kind)));
    } catch (const std::runtime_error& error) {  // of the file, or of what it names
      complain(error.what());
      code = kWrongUsage;
    }
  }
  return code;
}

}  // namespace

Command add_check(CLI::App& root) {
  CLI::App* app =
      root.add_subcommand("check", "Checks pipeline, sensor, dataset, scene and study files and reports all errors.");
  auto arguments = std::make_shared<CheckArguments>();
  app->add_option("FILE", arguments->files, "files to check")->required();
  add_plugin_option(*app, arguments->plugins);
  app->footer(
      "Example:\n  aslio check configs/pipelines/as_lio_plus.yaml configs/sensors/livox_avia.yaml "
      "configs/scenes/quickstart.yaml");
  return {app, [=] { return check(*arguments); }};
}

}  // namespace aslio::cli
