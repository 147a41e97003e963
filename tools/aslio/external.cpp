#include <fmt/format.h>

#include <filesystem>
#include <limits>
#include <memory>

#include "aslio/core/errors.hpp"
#include "aslio/evaluation/report.hpp"
#include "aslio/experiment/external_run.hpp"
#include "command.hpp"
#include "console.hpp"
#include "dataset_options.hpp"
#include "interrupt.hpp"
#include "options.hpp"

namespace aslio::cli {

namespace {

struct ExternalArguments {
  std::string method, dataset, data, output, name, sequence;
  std::uint64_t seed = 0;
  bool quiet = false;
};

std::string report(const experiment::ExternalSummary& s, const std::string& output) {
  std::string text = fmt::format("status       {}", pipeline::name(s.status));
  const auto out = std::back_inserter(text);
  if (!s.reason.empty()) fmt::format_to(out, ": {}", s.reason);
  fmt::format_to(out, "\nposes        {} over {:.2f} s of data, coverage {:.1f} %\npath         {:.2f} m\n", s.poses,
                 s.data_s, 100 * s.coverage, s.path_length_m);
  if (s.evaluation) text += evaluation::to_text(*s.evaluation);
  if (s.cpu_s && s.data_s > 0) {
    fmt::format_to(out, "cost         {:.2f} s CPU ({:.3f} s per s of data)", *s.cpu_s, *s.cpu_s / s.data_s);
    if (s.peak_rss_mb) fmt::format_to(out, ", peak memory {:.0f} MB", *s.peak_rss_mb);
    text += '\n';
  }
  fmt::format_to(out, "output       {}\n", output);
  return text;
}

int exit_code(const experiment::ExternalSummary& s) {
  switch (s.status) {
    case pipeline::RunStatus::ok:
      return s.evaluation_error.empty() ? kSuccess : kBadData;
    case pipeline::RunStatus::degraded:
      return kDegraded;
    case pipeline::RunStatus::interrupted:
      return kInterrupted;
    default:
      return s.bad_data ? kBadData : kRunFailed;
  }
}

int run_method(const ExternalArguments& a, const std::vector<std::string>& command_line) {
  catch_interrupts();
  experiment::ExternalOptions options;
  options.method = experiment::load_external_method(a.method);
  options.dataset = find_dataset(a.dataset, a.data);
  options.output = a.output;
  options.data_name = a.name.empty() ? options.dataset.name : a.name;
  options.sequence = a.sequence.empty() ? options.dataset.name : a.sequence;
  options.seed = a.seed;
  options.command_line = command_line;
  const auto summary = experiment::run_external(options, [] { return interrupted(); });
  for (const std::string& note : summary.notes) {
    if (note.starts_with("warning: ")) tell(note);
  }
  if (summary.status != pipeline::RunStatus::ok)
    complain(fmt::format("{}: {}", pipeline::name(summary.status), summary.reason));
  if (!summary.evaluation_error.empty()) complain(summary.evaluation_error);
  if (!a.quiet) print(report(summary, a.output));
  return exit_code(summary);
}

}  // namespace

Command add_external(CLI::App& root, const std::vector<std::string>& command_line) {
  CLI::App* app = root.add_subcommand(
      "external", "Runs a program of others over a recording, or takes its finished trajectory, and measures it.");
  auto a = std::make_shared<ExternalArguments>();
  app->add_option("METHOD", a->method, "file of the method (schema: aslio/external/1)")
      ->required()
      ->check(CLI::ExistingFile);
  add_dataset_options(*app, a->dataset, a->data);
  app->get_option("--dataset")->required();
  app->add_option("--output", a->output, "folder for the results, in which the program works")->required();
  app->add_option("--seed", a->seed, "for {seed} in its words")
      ->check(whole_number(0, std::numeric_limits<std::uint64_t>::max()))
      ->capture_default_str();
  app->add_option("--name", a->name, "for {data}; by default the name of the data set");
  app->add_option("--sequence", a->sequence, "for {sequence}; by default the name of the data set");
  app->add_flag("--quiet", a->quiet, "no report; warnings and errors remain");
  app->footer(
      "Writes trajectory.tum, trajectory_lidar.tum, program.log, summary.json, resolved.yaml and manifest.json.\n\n"
      "Example:\n"
      "  aslio external rko_lio.yaml --dataset out/indoor_1 --output out/rko_lio");
  return {app, [=] { return run_method(*a, command_line); }};
}

}  // namespace aslio::cli
