#include <memory>
#include <string>

#include "aslio/experiment/study_compare.hpp"
#include "aslio/experiment/study_status.hpp"
#include "command.hpp"
#include "console.hpp"

namespace aslio::cli {

namespace {

int status(const std::string& folder) {
  print(experiment::to_text(experiment::read_status(folder)));
  return kSuccess;
}

int compare(const std::string& a, const std::string& b) {
  const experiment::FolderComparison comparison = experiment::compare_folders(a, b);
  print(experiment::to_text(comparison));
  return comparison.same() ? kSuccess : kRunFailed;
}

}  // namespace

Command add_status(CLI::App& root) {
  CLI::App* app = root.add_subcommand(
      "status", "Prints the progress of a study: runs that are finished, running, failed and waiting.");
  auto folder = std::make_shared<std::string>();
  app->add_option("DIR", *folder, "--output of `aslio experiment`")->required();
  app->footer("Example:\n  aslio status out/table_1");
  return {app, [=] { return status(*folder); }};
}

Command add_compare(CLI::App& root) {
  CLI::App* app = root.add_subcommand("compare", "Compares the runs that two folders of studies have in common.");
  auto a = std::make_shared<std::string>(), b = std::make_shared<std::string>();
  app->add_option("DIR_A", *a, "--output of `aslio experiment`")->required();
  app->add_option("DIR_B", *b, "another")->required();
  app->footer(
      "Exit codes: 0 same runs with the same figures to the last bit (time, CPU and memory aside), 1 they differ.\n\n"
      "Example:\n  aslio compare out/before out/after");
  return {app, [=] { return compare(*a, *b); }};
}

}  // namespace aslio::cli
