#pragma once
/// Reading telemetry, with a word on what could not be read.

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "aslio/report/run_series.hpp"

namespace aslio::report {

/// As read_columns() of run_series.hpp. What of a file that is there could not be read is added to `notes`, a sentence
/// each that begins with the file's name.
std::optional<Columns> read_columns(const std::filesystem::path& path, std::vector<std::string>& notes);

}  // namespace aslio::report
