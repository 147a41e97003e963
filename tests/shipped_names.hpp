#pragma once

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include "aslio/config/load.hpp"

namespace aslio::test {

/// Names of configs/pipelines/*.yaml, sorted; no old names.
inline std::vector<std::string> shipped_names() {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(ASLIO_SOURCE_DIR "/configs/pipelines")) {
    if (config::follow_alias(entry.path()) == entry.path()) names.push_back(entry.path().stem());
  }
  std::sort(names.begin(), names.end());
  return names;
}

}  // namespace aslio::test
