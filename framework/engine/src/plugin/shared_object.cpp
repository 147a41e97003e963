#include "aslio/plugin/shared_object.hpp"

#include <dlfcn.h>
#include <fmt/core.h>
#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdlib>
#include <cstring>

#include "aslio/core/errors.hpp"
#include "aslio/core/sha256.hpp"
#include "aslio/plugin/abi.hpp"
#include "plugin_file.hpp"

namespace aslio::plugin {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail(const fs::path& file, const std::string& reason) { refuse_plugin(file, reason); }

/// Same file, and neither content, name nor rights changed in between.
bool unchanged(const struct stat& a, const struct stat& b) {
  return a.st_dev == b.st_dev && a.st_ino == b.st_ino && a.st_size == b.st_size &&
         a.st_ctim.tv_sec == b.st_ctim.tv_sec && a.st_ctim.tv_nsec == b.st_ctim.tv_nsec;
}

std::vector<std::string> items_of(std::string_view stamp) {
  std::vector<std::string> items;
  while (!stamp.empty()) {
    const std::size_t end = std::min(stamp.find("; "), stamp.size());
    items.emplace_back(stamp.substr(0, end));
    stamp.remove_prefix(std::min(end + 2, stamp.size()));
  }
  return items;
}

/// "eigen max align 16", .. : items of `stamp` that `other` has not.
std::string only_in(std::string_view stamp, std::string_view other) {
  const std::vector<std::string> others = items_of(other);
  std::string text;
  for (const std::string& item : items_of(stamp)) {
    if (std::find(others.begin(), others.end(), item) != others.end()) continue;
    if (!text.empty()) text += ", ";
    text += item;
  }
  return text.empty() ? "nothing" : text;
}

/// Before any C++ object crosses.
void check_entry(const AslioPlugin& entry, const fs::path& file) {
  if (entry.magic != kPluginMagic) {
    fail(file, fmt::format("'{}' is not the entry of a plugin (wrong magic number)", kPluginSymbol));
  }
  if (entry.abi_version != kPluginAbiVersion) {
    fail(file, fmt::format("has plugin ABI version {}, this program has {}: build it again with this version's headers",
                           entry.abi_version, kPluginAbiVersion));
  }
  if (entry.size != sizeof(AslioPlugin)) {
    fail(file, fmt::format("its entry has {} bytes, this program expects {}: build it again with this version's "
                           "headers",
                           entry.size, sizeof(AslioPlugin)));
  }
  constexpr std::size_t kLongest = 4096;
  if (entry.build_stamp == nullptr || entry.register_types == nullptr) fail(file, "its entry is incomplete");
  const std::string_view stamp(entry.build_stamp, strnlen(entry.build_stamp, kLongest));
  if (stamp != kBuildStamp) {
    fail(file, fmt::format("was built differently: it has {}; this program has {}: build both with one compiler and "
                           "one version",
                           only_in(stamp, kBuildStamp), only_in(kBuildStamp, stamp)));
  }
}

const AslioPlugin& open(const fs::path& real, const fs::path& file) {
  void* handle = dlopen(real.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (handle == nullptr) fail(file, fmt::format("cannot be loaded: {}", dlerror()));
  const void* symbol = dlsym(handle, kPluginSymbol);
  if (symbol == nullptr) {
    fail(file, fmt::format("has no entry '{}': add ASLIO_PLUGIN(register_function)", kPluginSymbol));
  }
  return *static_cast<const AslioPlugin*>(symbol);
}

/// What the shared object registers, apart from the catalog in use: a failure half-way leaves that as it was.
Catalog registered(const AslioPlugin& entry, const fs::path& real, const fs::path& file) {
  Catalog staged;
  staged.set_origin(real.string());
  std::array<char, 1024> message{};
  int result = 1;
  try {
    result = entry.register_types(&staged, message.data(), message.size());
  } catch (...) {
    fail(file, "its registration let an exception out: use ASLIO_PLUGIN");
  }
  message.back() = '\0';
  if (result != 0) fail(file, fmt::format("its registration failed: {}", message.data()));
  return staged;
}

}  // namespace

SharedObject load_shared_object(Catalog& catalog, const fs::path& file, WritablePlugins writable) {
  SharedObject object;
  CheckedPlugin checked = check_plugin_file(file, writable);
  object.path = std::move(checked.path);
  object.warning = std::move(checked.warning);
  const struct stat hashed = plugin_file_status(object.path, file);
  try {
    object.sha256 = sha256_of_file(object.path);
  } catch (const DataError& error) {
    fail(file, error.what());
  }
  const AslioPlugin& entry = open(object.path, file);
  // Not by loading an open descriptor: the name it would load under breaks $ORIGIN in the plugin's search path.
  if (!unchanged(hashed, plugin_file_status(object.path, file))) {
    fail(file, "was changed while it was loaded, so its SHA-256 is not that of the code: load it again");
  }
  check_entry(entry, file);
  const Catalog staged = registered(entry, object.path, file);
  std::vector<const Entry*> entries;
  for (const std::string& family : staged.families()) {
    for (const std::string& type : staged.types(family)) {
      entries.push_back(staged.find(family, type));
      if (const Entry* taken = catalog.find(family, type)) {
        fail(file, fmt::format("its type {}/{} is registered already, by {}: rename one of them", family, type,
                               taken->origin));
      }
    }
  }
  if (entries.empty()) fail(file, "registers no type");
  for (const Entry* added : entries) {
    object.types.push_back(fmt::format("{}/{}", added->family, added->type));
    catalog.add(*added);
  }
  return object;
}

namespace {

/// Every *.so of a directory, sorted by name.
std::vector<fs::path> shared_objects_in(const fs::path& directory) {
  const auto fail_search = [&](const std::string& reason) {
    throw ConfigError(fmt::format("ASLIO_PLUGIN_PATH: '{}' {}", directory.string(), reason));
  };
  if (!directory.is_absolute()) fail_search("is not an absolute directory");
  std::error_code error;
  std::vector<fs::path> files;
  const fs::path real = fs::canonical(directory, error);
  if (error) fail_search(fmt::format("cannot be found: {}", error.message()));
  auto entry = fs::directory_iterator(real, error);
  if (error) fail_search(fmt::format("cannot be listed: {}", error.message()));
  for (; entry != fs::directory_iterator(); entry.increment(error)) {
    if (entry->path().extension() != ".so") continue;
    const fs::path target = fs::weakly_canonical(entry->path());
    if (target.parent_path() != real)
      fail_search(fmt::format("holds {}, which leads out of it", entry->path().string()));
    files.push_back(entry->path());
  }
  if (error) fail_search(fmt::format("cannot be listed: {}", error.message()));
  std::sort(files.begin(), files.end());
  return files;
}

}  // namespace

std::vector<SharedObject> load_shared_objects(Catalog& catalog, std::span<const std::string> files,
                                              std::string_view search_path, WritablePlugins writable) {
  std::vector<fs::path> wanted(files.begin(), files.end());
  while (!search_path.empty()) {
    const std::size_t end = std::min(search_path.find(':'), search_path.size());
    for (fs::path& file : shared_objects_in(fs::path(search_path.substr(0, end)))) wanted.push_back(std::move(file));
    search_path.remove_prefix(end);
    if (search_path == ":") throw ConfigError("ASLIO_PLUGIN_PATH: ends with ':', remove it");
    if (!search_path.empty()) search_path.remove_prefix(1);
  }
  std::vector<SharedObject> objects;
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    const fs::path& file = wanted[i];
    std::error_code error;
    const fs::path real = fs::canonical(file, error);
    const bool known = !error && std::any_of(objects.begin(), objects.end(),
                                             [&](const SharedObject& object) { return object.path == real; });
    const auto rights = i < files.size() ? writable : WritablePlugins::refused;
    if (!known) objects.push_back(load_shared_object(catalog, file, rights));
  }
  return objects;
}

std::string plugin_search_path() {
  const char* value = std::getenv("ASLIO_PLUGIN_PATH");
  return value != nullptr ? value : "";
}

WritablePlugins writable_plugins() {
  const char* value = std::getenv(kAllowWritableVariable);
  return value != nullptr && std::string_view(value) == "1" ? WritablePlugins::allowed : WritablePlugins::refused;
}

}  // namespace aslio::plugin
