#pragma once
/// From a file to checked values. Every file begins with `schema: aslio/<kind>/1`; everything wrong with it is reported
/// at once, in one ConfigError whose text has one line per problem: `file.yaml:2:3: what (remedy)`.

#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "aslio/config/binder.hpp"
#include "aslio/config/document.hpp"
#include "aslio/config/override.hpp"
#include "aslio/config/stage_lookup.hpp"

namespace aslio::config {

enum class FileKind : unsigned char { pipeline, sensor, scene, dataset, study };

/// "pipeline", ..
std::string_view name(FileKind kind);

/// Values of a file and what is needed to state them.
template <class T>
struct Loaded {
  T value;
  /// YAML text with every key at its effective value. Reading it again gives the same values and the same text.
  std::string resolved;
  /// Stages in use as "family/type", sorted, each once.
  std::vector<std::string> plugin_types;
  /// What was written, with the overrides: each part knows its place.
  Node tree;
};

/// What the file says it is. Throws ConfigError as load() does for a file without a known schema.
FileKind peek_kind(const std::filesystem::path& path);

/// Type-erased part of load() and parse(): binds `describe` to the text.
struct Bound {
  std::string resolved;
  std::vector<std::string> plugin_types;
  Node tree;
};
Bound bind_text(std::string_view text, const std::string& source, FileKind kind, const StageLookup& stages,
                std::span<const Override> overrides, const std::function<void(Binder&)>& describe);

/// Reads `text`; `source` stands for the file in messages. T has `static void describe(Binder&, T&)`.
template <class T>
Loaded<T> parse(std::string_view text, const std::string& source, FileKind kind, const StageLookup& stages,
                std::span<const Override> overrides = {}) {
  Loaded<T> loaded{};
  Bound bound = bind_text(text, source, kind, stages, overrides, [&](Binder& b) { T::describe(b, loaded.value); });
  loaded.resolved = std::move(bound.resolved);
  loaded.plugin_types = std::move(bound.plugin_types);
  loaded.tree = std::move(bound.tree);
  return loaded;
}

/// Reads the file. Throws ConfigError naming it when it is missing, unreadable or a directory.
template <class T>
Loaded<T> load(const std::filesystem::path& path, FileKind kind, const StageLookup& stages,
               std::span<const Override> overrides = {}) {
  return parse<T>(read_text(path), path.string(), kind, stages, overrides);
}

}  // namespace aslio::config
