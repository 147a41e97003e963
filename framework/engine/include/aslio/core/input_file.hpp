#pragma once
/// What may be read as a file.

#include <cstdint>
#include <filesystem>
#include <string>

namespace aslio {

/// Tables and trajectories beyond this are no input of anybody, and would fill the memory.
inline constexpr std::uint64_t kMaxTextBytes = std::uint64_t{1} << 30U;

/// Why `path` must not be opened for reading: a pipe would wait for its writer, a device may never end. "is a folder,
/// not a file", for example. Empty for a regular file of at most `most` bytes, and where there is nothing: opening says
/// why.
std::string why_no_input(const std::filesystem::path& path, std::uint64_t most = kMaxTextBytes);

/// Throws DataError that names the path and says why.
void require_input(const std::filesystem::path& path, std::uint64_t most = kMaxTextBytes);

}  // namespace aslio
