#include <fmt/format.h>

#include <algorithm>
#include <span>
#include <vector>

#include "aslio/core/sha256.hpp"
#include "aslio/io/source.hpp"
#include "input_file.hpp"
#include "recording_files.hpp"

namespace aslio::io {
namespace {

namespace fs = std::filesystem;

void add_file(Sha256& digest, const fs::path& path) {
  const InputFile file(path);
  std::vector<std::uint8_t> block(std::min<std::uint64_t>(file.size(), 1U << 20U));
  for (std::uint64_t at = 0; at < file.size(); at += block.size()) {
    const auto part =
        std::span(block).first(static_cast<std::size_t>(std::min<std::uint64_t>(block.size(), file.size() - at)));
    file.read(at, part);
    digest.add(part.data(), part.size());
  }
}

}  // namespace

std::string input_digest(const fs::path& path) {
  std::error_code error;
  Sha256 digest;
  if (!fs::exists(path, error) && is_input(path)) {
    for (const fs::path& file : find_recording_files(path).files) {
      const std::string head = fmt::format("{}\n{}\n", file.filename().string(), fs::file_size(file));
      digest.add(head.data(), head.size());
      add_file(digest, file);
    }
    return digest.hex();
  }
  if (!fs::is_directory(path, error)) {
    add_file(digest, path);
    return digest.hex();
  }
  std::vector<std::string> names;
  for (const auto& entry : fs::recursive_directory_iterator(path)) {
    if (entry.is_regular_file()) names.push_back(entry.path().lexically_relative(path).generic_string());
  }
  std::sort(names.begin(), names.end());
  for (const std::string& name : names) {
    // The length separates a name from the content that follows.
    const std::string head = fmt::format("{}\n{}\n", name, fs::file_size(path / name));
    digest.add(head.data(), head.size());
    add_file(digest, path / name);
  }
  return digest.hex();
}

std::string input_digest(const std::vector<fs::path>& inputs) {
  if (inputs.size() == 1) return input_digest(inputs.front());
  Sha256 digest;
  for (const fs::path& input : inputs) {
    const std::string line = input_digest(input) + "\n";
    digest.add(line.data(), line.size());
  }
  return digest.hex();
}

}  // namespace aslio::io
