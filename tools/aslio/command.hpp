#pragma once
/// The sub-commands of `aslio`, one file each. Exit codes are here and nowhere else.

#include <CLI/CLI.hpp>
#include <functional>

namespace aslio::cli {

enum ExitCode : int {
  kSuccess = 0,     ///< of a run: ok
  kRunFailed = 1,   ///< failed or diverged
  kWrongUsage = 2,  ///< arguments or configuration
  kBadData = 3,     ///< bad or truncated data, or output that could not be written
  kDegraded = 4,    ///< a run has a result, and something speaks against it
  kInterrupted = 130
};

/// What parsing sets up: `app` is parsed by CLI11, and `action` does the work when it was the one named.
struct Command {
  CLI::App* app;
  std::function<int()> action;
};

Command add_run(CLI::App& root, const std::vector<std::string>& command_line);
Command add_list(CLI::App& root);
Command add_datasets(CLI::App& root);
Command add_describe(CLI::App& root);
Command add_check(CLI::App& root);
Command add_diff(CLI::App& root);
Command add_inspect(CLI::App& root);
Command add_evaluate(CLI::App& root);
Command add_calibrate(CLI::App& root);
Command add_overlap(CLI::App& root);
Command add_simulate(CLI::App& root);
Command add_experiment(CLI::App& root);
Command add_external(CLI::App& root, const std::vector<std::string>& command_line);
Command add_status(CLI::App& root);
Command add_compare(CLI::App& root);
Command add_report(CLI::App& root);
Command add_new_plugin(CLI::App& root);
Command add_version(CLI::App& root);

}  // namespace aslio::cli
