#pragma once
/// What is installed beside the program: configs, templates, contract.

#include <filesystem>

namespace aslio::cli {

/// The file or folder `relative` (such as "templates/plugin") of the program's data. Throws DataError, which names
/// where it was looked for, when it is not there.
std::filesystem::path data_path(const std::filesystem::path& relative);

}  // namespace aslio::cli
