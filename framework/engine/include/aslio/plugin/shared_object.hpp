#pragma once
/// Stages from shared objects. Loading one runs its code, so only the user names them (command line, environment),
/// never a configuration, a recording or a folder of results.

#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "aslio/plugin/registry.hpp"

namespace aslio::plugin {

/// A loaded shared object, for the manifest of a run.
struct SharedObject {
  std::filesystem::path path;      ///< absolute, without symbolic links
  std::string sha256;              ///< of the file
  std::vector<std::string> types;  ///< what it added, as "family/type", sorted
  std::string warning;             ///< why it would be refused but for WritablePlugins::allowed; empty: it would not
};

/// What becomes of a file that anybody can write, or replace. Some file systems give all files such rights.
enum class WritablePlugins : unsigned char { refused, allowed };

/// Environment variable: 1 allows them for files that the user names.
inline constexpr const char* kAllowWritableVariable = "ASLIO_ALLOW_WRITABLE_PLUGINS";

/// Adds the types of one shared object to the catalog; their origin is its path. Throws ConfigError naming the file and
/// the reason, and the catalog stays as it was: the file is missing, no regular file, or it or its directory can be
/// written by anybody (unless `writable` allows it); it cannot be opened, or changes while it is loaded; it is no
/// plugin of this version, or its build stamp differs; its registration fails; a type is taken already.
SharedObject load_shared_object(Catalog& catalog, const std::filesystem::path& file,
                                WritablePlugins writable = WritablePlugins::refused);

/// Loads `files` in order, then every *.so, sorted by name, of the directories in `search_path` (colon separated,
/// absolute; empty: none). A file that comes up twice is loaded once. `writable` holds for `files` alone: what a
/// directory holds was not named by the user.
std::vector<SharedObject> load_shared_objects(Catalog& catalog, std::span<const std::string> files,
                                              std::string_view search_path,
                                              WritablePlugins writable = WritablePlugins::refused);

/// By the environment.
WritablePlugins writable_plugins();

/// Value of ASLIO_PLUGIN_PATH, empty when unset.
std::string plugin_search_path();

}  // namespace aslio::plugin
