#include "aslio/core/input_file.hpp"

#include <system_error>

#include "aslio/core/errors.hpp"

namespace aslio {

std::string why_no_input(const std::filesystem::path& path, std::uint64_t most) {
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(path, error);
  if (!std::filesystem::exists(status)) return {};
  if (std::filesystem::is_directory(status)) return "is a directory, not a file";
  if (!std::filesystem::is_regular_file(status)) return "is a pipe or device, not a regular file: copy it to a file";
  const std::uintmax_t size = std::filesystem::file_size(path, error);
  if (error || size <= most) return {};
  return "has " + std::to_string(size) + " bytes, at most " + std::to_string(most) + " are read: is it the right file?";
}

void require_input(const std::filesystem::path& path, std::uint64_t most) {
  if (const std::string why = why_no_input(path, most); !why.empty()) throw DataError(path.string() + ": " + why);
}

}  // namespace aslio
