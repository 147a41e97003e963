#pragma once
/// Reads the subset of YAML that a configuration needs. Refused, with the place: duplicate keys, anchors and aliases,
/// merge keys, tags, keys that are no text, control characters, more than one document, more than 1 MB, nesting deeper
/// than 32, more than 100 000 nodes. Why: yaml-cpp 0.7 lets the first of two equal keys win and does not merge `<<`.

#include <filesystem>
#include <string>
#include <string_view>

#include "aslio/config/node.hpp"
#include "aslio/config/problems.hpp"

namespace aslio::config {

inline constexpr std::size_t kMaxFileBytes = 1'000'000;
inline constexpr std::size_t kMaxDepth = 32;
inline constexpr std::size_t kMaxNodes = 100'000;

/// Throws ConfigError with every problem found, each with its place in `source`.
Node parse_document(std::string_view text, const std::string& source);
/// The same, but problems that leave the tree whole (duplicate keys, of which the first counts, anchors and tags) are
/// added to `problems`, so that they can be reported with those of the values. Throws ConfigError for the others.
Node parse_document(std::string_view text, const std::string& source, Problems& problems);
/// The same for the value of an override: every part of the tree is at `at`.
Node parse_value(std::string_view text, const Location& at);
/// Content of a file. Throws ConfigError naming the file when it is missing, unreadable, no regular file (a
/// directory, a pipe, a device; none of them is opened) or too large.
std::string read_text(const std::filesystem::path& path);

}  // namespace aslio::config
