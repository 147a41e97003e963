#pragma once

#include <filesystem>

#include "aslio/core/trajectory.hpp"

namespace test {

/// A trajectory in the TUM format. Throws std::runtime_error when the file is missing or not of that format.
aslio::Trajectory read_tum(const std::filesystem::path& file);

}  // namespace test
