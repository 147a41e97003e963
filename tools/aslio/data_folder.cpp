#include "data_folder.hpp"

#include <fmt/format.h>

#include "aslio/core/errors.hpp"

namespace aslio::cli {

namespace fs = std::filesystem;

fs::path data_path(const fs::path& relative) {
  // Relative to the program, so that an installation may be moved; a build tree has links in the same places.
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  const fs::path path = (program.parent_path() / ASLIO_DATA_FROM_PROGRAM / relative).lexically_normal();
  if (error || !fs::exists(path, error)) {
    throw DataError(fmt::format("{}: not found, and it belongs to this program: install aslio whole (cmake --install)",
                                path.string()));
  }
  return path;
}

}  // namespace aslio::cli
