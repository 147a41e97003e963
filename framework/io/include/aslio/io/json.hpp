#pragma once
/// JSON that comes from anywhere.

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string_view>

namespace aslio::io {

/// Nothing for a text that is no JSON, or is nested deeper than 64 levels: whoever walks such a tree would run out of
/// stack.
std::optional<nlohmann::ordered_json> parse_json(std::string_view text);

}  // namespace aslio::io
