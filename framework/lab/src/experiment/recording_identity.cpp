#include "recording_identity.hpp"

#include <fmt/format.h>
#include <sys/stat.h>

#include <algorithm>
#include <vector>

#include "aslio/core/sha256.hpp"
#include "matching_paths.hpp"

namespace aslio::experiment {

namespace fs = std::filesystem;

namespace {

/// Size and time of change: bags are too large to be read for every look at a study.
std::string file_identity(const fs::path& path) {
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0) return "gone";
  return fmt::format("{} {}.{:09}", status.st_size, status.st_mtim.tv_sec, status.st_mtim.tv_nsec);
}

std::string input_identity(const fs::path& path) {
  std::error_code error;
  if (!fs::exists(path, error) && is_pattern(path.string())) {
    std::string text;
    for (const fs::path& file : matching_paths({}, path.string())) {
      text += file.filename().string() + " " + file_identity(file) + "\n";
    }
    return text;
  }
  if (!fs::is_directory(path, error)) return file_identity(path);
  std::vector<std::string> lines;
  for (const auto& entry : fs::recursive_directory_iterator(path, error)) {
    lines.push_back(entry.path().lexically_relative(path).generic_string() + " " + file_identity(entry.path()));
  }
  std::sort(lines.begin(), lines.end());
  return fmt::format("{}", fmt::join(lines, "\n"));
}

}  // namespace

bool is_small(const fs::path& path) {
  constexpr std::uintmax_t kSmall = 256U << 20U;
  std::error_code error;
  return fs::is_regular_file(path, error) && fs::file_size(path, error) < kSmall;
}

std::string recording_identity(const Dataset& dataset) {
  std::vector<std::string> inputs;
  for (const fs::path& input : dataset.inputs) inputs.push_back(input_identity(input));
  std::string text =
      fmt::format("recording\n{}\n{}\n{}\n", dataset.resolved, fmt::join(inputs, "\n"), sha256_of_file(dataset.sensor));
  if (dataset.reference) {
    const io::ReferenceSpec& reference = *dataset.reference;
    text += is_small(reference.file) ? sha256_of_file(reference.file) : input_identity(reference.file);
    // A plain path leaves all keys as they are, and the identity as it was before there were any.
    const std::string keys = io::resolved_text(reference);
    if (keys != io::resolved_text(io::ReferenceSpec(std::filesystem::path(reference.file)))) text += "\n" + keys;
  }
  return sha256_of(text);
}

}  // namespace aslio::experiment
