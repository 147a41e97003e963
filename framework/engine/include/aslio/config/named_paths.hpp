#pragma once
/// Paths that a configuration file names: relative to its folder, and checked with its other keys.

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <utility>

#include "aslio/config/binder.hpp"

namespace aslio::config {

class NamedPaths {
 public:
  enum class Wanted : std::uint8_t { file, file_or_folder };

  explicit NamedPaths(std::filesystem::path folder) : folder_(std::move(folder)) {}

  std::filesystem::path at(const std::string& written) const { return (folder_ / written).lexically_normal(); }
  /// A problem of `key` where what is written is not there, or is nothing that can be read twice. Empty: no problem.
  void require(Binder& b, std::string_view key, const std::string& written, Wanted wanted) const;

 private:
  std::filesystem::path folder_;
};

}  // namespace aslio::config
