#include "aslio/experiment/version.hpp"

#include <fmt/format.h>

#include "command.hpp"
#include "console.hpp"

namespace aslio::cli {

Command add_version(CLI::App& root) {
  CLI::App* app = root.add_subcommand("version", "Tells version and source revision.");
  app->footer("Example:\n  aslio version");
  return {app, [] {
            const auto revision = experiment::source_revision();
            print(fmt::format("aslio {} ({})\n", experiment::version(),
                              revision.empty() ? "source revision unknown" : revision));
            return static_cast<int>(kSuccess);
          }};
}

}  // namespace aslio::cli
