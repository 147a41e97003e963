#pragma once

#include <string>

#include "aslio/experiment/dataset.hpp"

namespace aslio::experiment {

/// Whether a file is read whole for each look at a study: a trajectory or table, no recording.
bool is_small(const std::filesystem::path& path);

/// What a recording and its files are: equal as long as none of them changes. Of the data themselves size and time, of
/// sensor and reference the content.
std::string recording_identity(const Dataset& dataset);

}  // namespace aslio::experiment
