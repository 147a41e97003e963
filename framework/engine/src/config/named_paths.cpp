#include "aslio/config/named_paths.hpp"

#include <fmt/format.h>

#include <system_error>

namespace aslio::config {

namespace {

namespace fs = std::filesystem;

/// What is wrong with a path that is named in the file; empty: nothing.
std::string trouble(const fs::path& path, NamedPaths::Wanted wanted) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (status.type() == fs::file_type::not_found) {
    return fmt::format("does not exist: {} (paths are relative to the folder of this file)", path.string());
  }
  if (status.type() == fs::file_type::none)
    return fmt::format("cannot be reached: {}: {}", path.string(), error.message());
  const bool folder = fs::is_directory(status);
  if (wanted == NamedPaths::Wanted::file && folder) return fmt::format("is a folder: {} (name a file)", path.string());
  if (!folder && !fs::is_regular_file(status)) {
    return fmt::format("is no regular file: {} (pipes and devices cannot be read twice)", path.string());
  }
  return {};
}

}  // namespace

void NamedPaths::require(Binder& b, std::string_view key, const std::string& written, Wanted wanted) const {
  if (written.empty()) return;  // whether it has to be there is for the file's own description to say
  const std::string wrong = trouble(at(written), wanted);
  b.require(wrong.empty(), key, wrong);
}

}  // namespace aslio::config
