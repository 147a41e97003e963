#pragma once

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

namespace aslio::test {

/// Names of configs/pipelines/*.yaml, sorted.
inline std::vector<std::string> shipped_names() {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(ASLIO_SOURCE_DIR "/configs/pipelines")) {
    names.push_back(entry.path().stem());
  }
  std::sort(names.begin(), names.end());
  return names;
}

}  // namespace aslio::test
