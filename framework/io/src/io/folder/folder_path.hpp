#pragma once

#include <filesystem>

namespace aslio::io {

/// Absolute and without a separator at its end, so that the folder has a name and a parent.
inline std::filesystem::path named_folder(const std::filesystem::path& path) {
  std::error_code ignored;
  const std::filesystem::path whole = std::filesystem::absolute(path, ignored).lexically_normal();
  return whole.has_filename() ? whole : whole.parent_path();
}

}  // namespace aslio::io
