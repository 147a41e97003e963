/// The command line: parses, dispatches, and turns what went wrong into a message and an exit code.

#include <fmt/format.h>

#include <csignal>
#include <vector>

#include "aslio/core/errors.hpp"
#include "command.hpp"
#include "console.hpp"

namespace aslio::cli {

namespace {

std::vector<Command> add_commands(CLI::App& root, const std::vector<std::string>& command_line) {
  return {add_run(root, command_line), add_list(root),     add_describe(root), add_check(root), add_diff(root),
          add_inspect(root),           add_evaluate(root), add_version(root)};
}

int act(const std::vector<Command>& commands) {
  for (const Command& command : commands) {
    if (command.app->parsed()) return command.action();
  }
  return kWrongUsage;
}

int run_command_line(int argc, char** argv) {
  CLI::App root("AS-LIO Lab: LiDAR-inertial odometry from interchangeable stages.", "aslio");
  root.require_subcommand(1);
  root.footer(
      "Example:\n"
      "  aslio run configs/pipelines/as_lio.yaml --input corridor.bag --sensor configs/sensors/livox_avia.yaml "
      "--output out/corridor\n\n"
      "Exit codes: 0 ok or degraded, 1 failed or diverged, 2 wrong usage or configuration, 3 bad or truncated data, "
      "130 interrupted.\n"
      "`aslio COMMAND --help` tells the options of a command.");
  const auto commands = add_commands(root, std::vector<std::string>(argv, argv + argc));
  try {
    root.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return root.exit(error) == 0 ? kSuccess : kWrongUsage;  // --help is reported as an error, too
  }
  return act(commands);
}

}  // namespace

}  // namespace aslio::cli

int main(int argc, char** argv) {
  using namespace aslio::cli;
  std::signal(SIGXFSZ, SIG_IGN);  // a file that reaches a size limit is a failed write, which is reported
  std::signal(SIGPIPE, SIG_IGN);
  try {
    return run_command_line(argc, argv);
  } catch (const aslio::ConfigError& error) {
    complain(error.what());
    return kWrongUsage;
  } catch (const aslio::DataError& error) {
    complain(error.what());
    return kBadData;
  } catch (const std::exception& error) {
    complain(fmt::format("unexpected: {}", error.what()));
    return kRunFailed;
  }
}
