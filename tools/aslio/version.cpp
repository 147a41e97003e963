#include "aslio/experiment/version.hpp"

#include <fmt/format.h>

#include "command.hpp"
#include "console.hpp"

namespace aslio::cli {

namespace {

std::string version_line() {
  const auto revision = experiment::source_revision();
  return fmt::format("aslio {} ({})", experiment::version(), revision.empty() ? "source revision unknown" : revision);
}

}  // namespace

Command add_version(CLI::App& root) {
  root.set_version_flag("-V,--version", version_line, "Print version and source revision and exit");
  CLI::App* app = root.add_subcommand("version", "Prints version and source revision.");
  app->footer("Example:\n  aslio version");
  return {app, [] {
            print(version_line() + "\n");
            return static_cast<int>(kSuccess);
          }};
}

}  // namespace aslio::cli
