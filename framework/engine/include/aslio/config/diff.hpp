#pragma once
/// How two configurations differ in meaning: formatting, order of keys and omitted defaults do not count.

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace aslio::config {

/// One difference. A change of a stage's type is one difference at its block.
struct Difference {
  std::string path;
  std::optional<std::string> a, b;  ///< on one line; nothing where the key exists on the other side only
};

/// Differences of two resolved texts (Loaded::resolved), in the order of A, then what only B has.
std::vector<Difference> diff(std::string_view resolved_a, std::string_view resolved_b);

/// A line per difference: "path: a -> b", "path: a (only in A)", "path: b (only in B)".
std::string to_text(const std::vector<Difference>& differences);

}  // namespace aslio::config
