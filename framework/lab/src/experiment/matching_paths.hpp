#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace aslio::experiment {

/// Is there a `*`, `?` or `[` in it?
bool is_pattern(std::string_view text);

/// The parts of a text that ' | ' separates.
std::vector<std::string> alternatives(const std::string& text);

/// `folder` / `pattern`, where characters of the folder stand for themselves.
std::filesystem::path pattern_in(const std::filesystem::path& folder, const std::string& pattern);

/// Paths that the pattern matches, sorted. It is relative to `folder`, unless it is absolute.
std::vector<std::filesystem::path> matching_paths(const std::filesystem::path& folder, const std::string& pattern);

}  // namespace aslio::experiment
