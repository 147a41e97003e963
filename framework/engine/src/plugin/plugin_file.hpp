#pragma once
/// All that is looked at before the code of a plugin is loaded.

#include <sys/stat.h>

#include <filesystem>
#include <string>

namespace aslio::plugin {

/// Throws ConfigError: "plugin FILE: REASON".
[[noreturn]] void refuse_plugin(const std::filesystem::path& file, const std::string& reason);

/// Of `path`, which belongs to the plugin `file`. Throws ConfigError naming both.
struct stat plugin_file_status(const std::filesystem::path& path, const std::filesystem::path& file);

/// The file without symbolic links, once nobody but its owner and group could have put it there, and it is as long as
/// its headers say. Throws ConfigError naming the file and the reason. A file of another format passes: the loader
/// knows better what is wrong with it.
std::filesystem::path check_plugin_file(const std::filesystem::path& file);

}  // namespace aslio::plugin
