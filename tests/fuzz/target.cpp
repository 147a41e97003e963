#include "fuzz/target.hpp"

#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <vector>

#include "temporary_folder.hpp"

namespace aslio::fuzz {

namespace {

std::filesystem::path quick_place() {
  // A place that the caller names comes first: what a crash leaves behind is there.
  const std::filesystem::path memory = "/dev/shm";
  if (std::getenv("TMPDIR") != nullptr || ::access(memory.c_str(), W_OK) != 0) {
    return std::filesystem::temp_directory_path();
  }
  return memory;
}

void put(const std::filesystem::path& path, std::string_view content) {
  std::ofstream file(path, std::ios::binary);
  file.write(content.data(), static_cast<std::streamsize>(content.size()));
  file.close();
  must(!file.fail(), "the file of an input can be written");
}

}  // namespace

void must(bool holds, std::string_view what) {
  if (holds) return;
  std::fprintf(stderr, "does not hold: %.*s\n", static_cast<int>(what.size()), what.data());
  std::abort();
}

const std::filesystem::path& folder() {
  static const aslio::test::TemporaryFolder own(quick_place());
  return own.path();
}

std::filesystem::path written(std::string_view name, Bytes bytes) {
  std::filesystem::path path = folder() / name;
  put(path, text_of(bytes));
  return path;
}

const std::filesystem::path& unpacked(Bytes bytes, std::initializer_list<std::string_view> names) {
  static std::vector<std::filesystem::path> left;
  for (const std::filesystem::path& path : left) std::filesystem::remove(path);
  left.clear();
  constexpr std::string_view kMark = "=== ";
  std::string_view rest = text_of(bytes);
  while (rest.starts_with(kMark)) {
    const std::size_t end_of_name = std::min(rest.find('\n'), rest.size());
    const std::string_view name = rest.substr(kMark.size(), end_of_name - kMark.size());
    rest.remove_prefix(std::min(end_of_name + 1, rest.size()));
    const std::size_t next = rest.starts_with(kMark) ? 0 : rest.find("\n=== ");
    const std::size_t end = next == std::string_view::npos ? rest.size() : next + (next > 0 ? 1 : 0);
    if (std::find(names.begin(), names.end(), name) != names.end()) {
      const std::filesystem::path path = folder() / name;
      std::filesystem::create_directories(path.parent_path());
      put(path, rest.substr(0, end));
      left.push_back(path);
    }
    rest.remove_prefix(end);
  }
  return folder();
}

}  // namespace aslio::fuzz
