#pragma once
/// Reading a configuration file as what its schema line says it is.

#include <filesystem>
#include <string>
#include <vector>

#include "aslio/config/load.hpp"
#include "aslio/experiment/study.hpp"

namespace aslio::cli {

struct CheckedFile {
  config::FileKind kind;
  std::string resolved;                 ///< every key at its effective value
  std::vector<std::string> warnings{};  ///< what is allowed, and may be an oversight
};

/// Throws ConfigError with everything that is wrong with the file.
CheckedFile read_checked(const std::filesystem::path& file, const config::StageLookup& stages);

/// A scene with overrides: its values, the version of the simulator, and the digests of the files it reads. Throws
/// ConfigError.
experiment::ResolvedScene resolve_scene(const std::filesystem::path& scene, const std::vector<std::string>& overrides);

}  // namespace aslio::cli
