#pragma once
/// All that is looked at before the code of a plugin is loaded.

#include <sys/stat.h>

#include <filesystem>
#include <string>

#include "aslio/plugin/shared_object.hpp"

namespace aslio::plugin {

/// Throws ConfigError: "plugin FILE: REASON".
[[noreturn]] void refuse_plugin(const std::filesystem::path& file, const std::string& reason);

/// Of `path`, which belongs to the plugin `file`. Throws ConfigError naming both.
struct stat plugin_file_status(const std::filesystem::path& path, const std::filesystem::path& file);

struct CheckedPlugin {
  std::filesystem::path path;  ///< without symbolic links
  std::string warning;         ///< what would have been refused; empty: nothing
};

/// The file, once nobody but its owner and group could have put it there (or `writable` allows that), and it is as long
/// as its headers say. Throws ConfigError naming the file, the reason and the remedy. A file of another format passes:
/// the loader knows better what is wrong with it.
CheckedPlugin check_plugin_file(const std::filesystem::path& file, WritablePlugins writable);

}  // namespace aslio::plugin
