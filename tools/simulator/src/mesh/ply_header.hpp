#pragma once

#include <cstdint>
#include <filesystem>

namespace aslio::simulator {

/// Numbers that the header of a PLY file promises.
struct PlyCounts {
  std::uint64_t vertices = 0, faces = 0;
};

/// Reads the header and, of a text file, counts the lines after it. Throws DataError when it is not that of a PLY file,
/// promises more elements than the file has bytes or lines, or the last line breaks off.
PlyCounts read_ply_header(const std::filesystem::path& path, std::uint64_t file_bytes);

}  // namespace aslio::simulator
