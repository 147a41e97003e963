#pragma once
/// `aslio inspect --check`: frames, signs and clocks against the data.

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "recording.hpp"

namespace aslio::cli {

struct FrameCheckArguments {
  bool check = false, quiet = false;
  std::string reference, pipeline, json;
  std::vector<std::string> reference_sets, extrinsics;
};

void add_frame_check_options(CLI::App& app, FrameCheckArguments& a);

/// Whether an option was given that means nothing without --check; its name, or nothing.
std::string option_without_check(const CLI::App& app, const FrameCheckArguments& a);

/// Measures, prints and returns the exit code. `app` has parsed the options.
int check_recording(const FrameCheckArguments& a, const RecordingArguments& recording, const CLI::App& app);

}  // namespace aslio::cli
