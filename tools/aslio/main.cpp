/// The command line: parses, dispatches, and turns what went wrong into a message and an exit code.

#include <fmt/format.h>
#ifdef __GLIBC__
#include <malloc.h>
#endif

#include <fcntl.h>

#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <exception>
#include <sstream>
#include <vector>

#include "aslio/core/errors.hpp"
#include "aslio/core/thrown.hpp"
#include "command.hpp"
#include "console.hpp"
#include "options.hpp"

namespace aslio::cli {

namespace {

std::vector<Command> add_commands(CLI::App& root, const std::vector<std::string>& command_line) {
  return {add_run(root, command_line),
          add_simulate(root),
          add_list(root),
          add_datasets(root),
          add_describe(root),
          add_check(root),
          add_diff(root),
          add_inspect(root),
          add_evaluate(root),
          add_calibrate(root),
          add_overlap(root),
          add_experiment(root),
          add_external(root, command_line),
          add_report(root),
          add_status(root),
          add_compare(root),
          add_new_plugin(root),
          add_version(root)};
}

/// Messages are of a megabyte and come ten times a second: memory that goes back to the system with each of them is
/// paid for again, page by page.
void keep_freed_memory() {
#ifdef __GLIBC__
  mallopt(M_MMAP_THRESHOLD, 16 << 20);
  mallopt(M_TRIM_THRESHOLD, 64 << 20);
#endif
}

/// A file that is opened gets the lowest descriptor that is free: without these, what is printed would end up in it.
void keep_standard_streams_apart() {
  for (const int stream : {0, 1, 2}) {
    if (::fcntl(stream, F_GETFD) >= 0) continue;
    // Output that is closed stays one that cannot be written, which is told by the exit code; messages are lost.
    const int opened = ::open("/dev/null", stream == 1 ? O_RDONLY : O_RDWR);
    if (opened >= 0 && opened != stream) ::close(opened);
  }
}

/// Of an exception that nobody can catch: of a thread or a destructor of a plugin.
[[noreturn]] void end_by_exception() {
  std::string what = "std::terminate() was called";
  if (std::current_exception()) {
    try {
      throw;
    } catch (...) {
      what = aslio::what_was_thrown();
    }
  }
  complain(fmt::format("unexpected, where nothing can catch it: {}", what));
  std::_Exit(kRunFailed);
}

int act(const std::vector<Command>& commands) {
  for (const Command& command : commands) {
    if (command.app->parsed()) return command.action();
  }
  return kWrongUsage;
}

/// CLI11 would only say that a command is required.
void require_known_command(const std::vector<Command>& commands, const std::vector<std::string>& command_line) {
  if (command_line.size() < 2 || command_line[1].starts_with('-')) return;
  const std::string& wrong = command_line[1];
  std::vector<std::string> names;
  for (const Command& command : commands) names.push_back(command.app->get_name());
  if (std::find(names.begin(), names.end(), wrong) != names.end()) return;
  const std::string near = nearest_name(wrong, names);
  throw ConfigError(fmt::format("unknown command '{}'{}; there are: {}", wrong,
                                near.empty() ? "" : fmt::format(" (did you mean '{}'?)", near),
                                fmt::join(names, ", ")));
}

/// CLI11 would first miss the option that was mistyped.
void require_known_options(const std::vector<Command>& commands, const std::vector<std::string>& command_line) {
  for (const Command& command : commands) {
    if (command_line.size() < 2 || command.app->get_name() != command_line[1]) continue;
    std::vector<std::string> unknown;
    for (std::size_t i = 2; i < command_line.size(); ++i) {
      const std::string name = command_line[i].substr(0, command_line[i].find('='));
      if (name.starts_with("--") && name != "--" && command.app->get_option_no_throw(name) == nullptr) {
        unknown.push_back(command_line[i]);
      }
    }
    if (!unknown.empty()) throw ConfigError(unknown_options(*command.app, unknown));
  }
}

/// No argument may be empty; a path that is would stand for the working folder, or for none given.
void require_values(const std::vector<std::string>& command_line) {
  for (std::size_t i = 1; i < command_line.size(); ++i) {
    const std::string& word = command_line[i];
    const bool no_value = word.starts_with("--") && word.find('=') == word.size() - 1;
    if (!word.empty() && !no_value) continue;
    throw ConfigError(fmt::format("{} '{}' is empty: give a value (a shell variable that is not set leaves none)",
                                  no_value ? "the value of" : "the argument after",
                                  no_value ? word.substr(0, word.size() - 1) : command_line[i - 1]));
  }
}

std::string without_line_feed(std::string text) {
  while (text.ends_with('\n')) text.pop_back();
  return text;
}

int run_command_line(int argc, char** argv) {
  CLI::App root("AS-LIO Lab: LiDAR-inertial odometry from interchangeable stages.", "aslio");
  root.require_subcommand(1);
  root.footer(
      "Example:\n  aslio run configs/pipelines/as_lio_plus.yaml --input corridor.bag --sensor "
      "configs/sensors/livox_avia.yaml --output out/corridor\n\nExit codes: 0 ok, 1 failed or diverged, 2 wrong usage "
      "or configuration, 3 bad or truncated data, 4 degraded, 130 interrupted.\n`aslio COMMAND --help` prints the "
      "options of a command.");
  const std::vector<std::string> command_line(argv, argv + argc);
  const auto commands = add_commands(root, command_line);
  require_known_command(commands, command_line);
  require_values(command_line);
  require_known_options(commands, command_line);
  try {
    root.parse(argc, argv);
  } catch (const CLI::ExtrasError&) {
    const auto parsed = root.get_subcommands();
    const CLI::App& app = parsed.empty() ? root : *parsed.front();
    complain(unknown_options(app, root.remaining(true)));
    return kWrongUsage;
  } catch (const CLI::ParseError& error) {
    std::ostringstream out, err;
    const int code = root.exit(error, out, err) == 0 ? kSuccess : kWrongUsage;  // --help is reported as an error, too
    if (!out.str().empty()) print(out.str());
    if (!err.str().empty()) tell(without_line_feed(err.str()));
    return code;
  }
  return act(commands);
}

}  // namespace

}  // namespace aslio::cli

int main(int argc, char** argv) {
  using namespace aslio::cli;
  keep_standard_streams_apart();
  std::signal(SIGXFSZ, SIG_IGN);  // a file that reaches a size limit is a failed write, which is reported
  std::signal(SIGPIPE, SIG_IGN);
  keep_freed_memory();
  std::set_terminate(&end_by_exception);
  try {
    return run_command_line(argc, argv);
  } catch (const aslio::ConfigError& error) {
    complain(error.what());
    return kWrongUsage;
  } catch (const aslio::DataError& error) {
    complain(error.what());
    return kBadData;
  } catch (...) {
    complain(fmt::format("unexpected: {}", aslio::what_was_thrown()));
    return kRunFailed;
  }
}
