#include "study_files.hpp"

#include <fmt/format.h>

#include <fstream>
#include <iterator>
#include <system_error>
#include <vector>

#include "aslio/core/errors.hpp"

namespace aslio::experiment {

namespace {

namespace fs = std::filesystem;

/// Removes what `goes` says of the entries of `folder`: listed first, since a folder must not change while it is read.
template <typename Goes>
void remove_entries(const fs::path& folder, const Goes& goes) {
  std::error_code error;
  std::vector<fs::path> found;
  for (auto at = fs::directory_iterator(folder, error); !error && at != fs::directory_iterator(); at.increment(error)) {
    if (goes(at->path())) found.push_back(at->path());
  }
  for (const fs::path& path : found) fs::remove_all(path, error);
}

}  // namespace

void create_folder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw DataError(fmt::format("{}: cannot create the folder: {}", folder.string(), error.message()));
}

bool is_leftover(std::string_view name, std::string_view begin) {
  return name.size() > begin.size() && name.starts_with(begin) &&
         name.find_first_not_of("0123456789", begin.size()) == std::string_view::npos;
}

void remove_leftovers(const fs::path& folder, const std::string& begin) {
  remove_entries(folder, [&](const fs::path& path) { return is_leftover(path.filename().string(), begin); });
}

void remove_parts(const fs::path& folder) {
  remove_entries(folder, [](const fs::path& path) { return path.extension() == ".part"; });
}

std::string read_text(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

}  // namespace aslio::experiment
