#pragma once
/// What a command reads: --input with --sensor, or --dataset.

#include <CLI/CLI.hpp>
#include <filesystem>
#include <optional>
#include <string>

#include "aslio/io/source.hpp"

namespace aslio::cli {

struct RecordingArguments {
  std::string input, dataset, sensor;
  double start = 0, duration = 0;
};

struct Recording {
  std::filesystem::path input, sensor;
  std::optional<std::filesystem::path> dataset, reference;
  io::Section section;
  bool closed_loop = false;  ///< only where a dataset or --closed-loop says so
};

void add_recording_options(CLI::App& app, RecordingArguments& a);

/// What the dataset names, less what the command line names itself. Throws ConfigError when something is missing or
/// too much. `app` is the one that has parsed the options.
Recording find_recording(const RecordingArguments& a, const CLI::App& app);

}  // namespace aslio::cli
