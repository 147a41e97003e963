#pragma once
/// Folders and files of the runs of a study.

#include <filesystem>
#include <string>
#include <string_view>

namespace aslio::experiment {

/// With the folders above it. Throws DataError.
void create_folder(const std::filesystem::path& folder);

/// Is `name` this beginning and the id of a process, and nothing else? Names of methods and data may hold anything.
bool is_leftover(std::string_view name, std::string_view begin);

/// Removes what a study that was killed left in `folder`: folders of this beginning and the id of a process.
void remove_leftovers(const std::filesystem::path& folder, const std::string& begin);

/// Removes the files that a child which was killed had not finished.
void remove_parts(const std::filesystem::path& folder);

/// The whole file; empty where it cannot be read.
std::string read_text(const std::filesystem::path& file);

}  // namespace aslio::experiment
