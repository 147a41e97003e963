#pragma once
/// What a command reads: --input with --sensor, or --dataset.

#include <CLI/CLI.hpp>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "aslio/experiment/dataset.hpp"
#include "aslio/io/reference.hpp"
#include "aslio/io/source.hpp"

namespace aslio::cli {

struct RecordingArguments {
  std::vector<std::string> inputs;  ///< that are one recording
  std::string dataset, data, sensor;
  double start = 0, duration = 0;
};

struct Recording {
  std::vector<std::filesystem::path> inputs;
  std::filesystem::path sensor;
  std::optional<std::filesystem::path> dataset;
  std::optional<io::ReferenceSpec> reference;
  io::Section section;
  std::optional<experiment::PublishedSequence> published;
  bool closed_loop = false;  ///< only where a dataset or --closed-loop says so
};

/// Checks that an input exists, or is a pattern.
CLI::Validator existing_input();

void add_recording_options(CLI::App& app, RecordingArguments& a);

/// What the dataset names, less what the command line names itself. Throws ConfigError when something is missing or
/// too much. `app` is the one that has parsed the options.
Recording find_recording(const RecordingArguments& a, const CLI::App& app);

}  // namespace aslio::cli
