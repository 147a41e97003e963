#pragma once

#include <cstdint>
#include <filesystem>

namespace aslio::simulator {

/// Numbers that the header of a PLY file promises.
struct PlyCounts {
  std::uint64_t vertices = 0, faces = 0;
};

/// Reads the header alone. Throws DataError when it is not that of a PLY file or promises more elements than the file
/// has bytes.
PlyCounts read_ply_header(const std::filesystem::path& path, std::uint64_t file_bytes);

}  // namespace aslio::simulator
