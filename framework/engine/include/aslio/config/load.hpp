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

enum class FileKind : unsigned char { pipeline, sensor, scene, dataset, study, reference, family, external };

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
  /// The file that was read is an alias of this one; empty: it is none.
  std::filesystem::path alias_of;
};

/// The file that `path` stands for. A file with nothing but `schema` and `alias: other.yaml` is an old name of that
/// file, beside it; all others stand for themselves. Throws ConfigError where a file is missing, or where the alias of
/// an alias is asked for.
std::filesystem::path follow_alias(const std::filesystem::path& path);

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

/// Reads the file, or the one that it is an alias of. Throws ConfigError naming it when it is missing, unreadable or a
/// directory.
template <class T>
Loaded<T> load(const std::filesystem::path& path, FileKind kind, const StageLookup& stages,
               std::span<const Override> overrides = {}) {
  const std::filesystem::path file = follow_alias(path);
  Loaded<T> loaded = parse<T>(read_text(file), file.string(), kind, stages, overrides);
  if (file != path) loaded.alias_of = file;
  return loaded;
}

}  // namespace aslio::config
