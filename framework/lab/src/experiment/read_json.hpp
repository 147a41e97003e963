#pragma once

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>

#include "aslio/core/input_file.hpp"
#include "aslio/io/json.hpp"

namespace aslio::experiment {

/// Nothing when the file is not there, cannot be read, or is no JSON object.
inline std::optional<nlohmann::ordered_json> read_json(const std::filesystem::path& path) {
  if (!why_no_input(path).empty()) return std::nullopt;
  std::ifstream stream(path, std::ios::binary);
  std::ostringstream text;
  // Read first: parse() lets through what the stream throws when the disk fails.
  if (!stream || !(text << stream.rdbuf())) return std::nullopt;
  auto json = io::parse_json(text.str());
  if (!json || !json->is_object()) return std::nullopt;
  return json;
}

}  // namespace aslio::experiment
