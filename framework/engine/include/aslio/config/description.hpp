#pragma once
/// What can be written in a configuration, from the same declarations that read it.

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "aslio/config/binder.hpp"
#include "aslio/config/stage_lookup.hpp"

namespace aslio::config {

/// One key of a block.
struct Field {
  std::string path;           ///< dotted, relative to the block; items of a list as "boxes.N"
  std::string type;           ///< "number", "integer", "true|false", "text", "one of a|b", "stage of motions", ..
  std::string unit;           ///< empty: none
  std::string range;          ///< "[0.001, 10] s"; empty: any
  std::string default_value;  ///< as YAML; "required" where there is none
  std::string doc;            ///< one sentence
  std::string family;         ///< of a nested stage, otherwise empty
};

/// Keys that were removed, and what to use.
struct RemovedKey {
  std::string path, advice;
};

struct Description {
  std::vector<Field> fields;  ///< in the order of declaration
  std::vector<RemovedKey> removed;
};

/// Keys of any block.
Description describe(const std::function<void(Binder&)>& describe_block);
/// Keys of a stage. Throws ConfigError naming the nearest family or type when there is no such stage.
Description describe(const StageLookup& stages, std::string_view family, std::string_view type);

/// Two lines per key and one per removed key, with a line feed before each; the members of the families are named.
std::string to_text(const Description& description, const StageLookup& stages);
/// A table of the keys in Markdown, an empty line behind it.
std::string to_markdown(const Description& description);

/// Text of `aslio describe FAMILY/TYPE`: what it is, where it comes from, and every key.
std::string describe_stage(const StageLookup& stages, std::string_view family, std::string_view type);
/// Markdown with a section per family and a table per type; sorted, so that it changes only with the plugins.
std::string plugin_reference(const StageLookup& stages);

}  // namespace aslio::config
