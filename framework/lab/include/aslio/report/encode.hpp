#pragma once
/// Numbers and texts as they go into a page: small, and harmless wherever they come from.

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace aslio::report {

/// Indices of samples (ascending, the first and the last among them) such that linear interpolation between them is
/// within `tolerance` of every sample left out. `t` strictly increases; all values are finite. With `tolerance` 0 only
/// samples on straight lines go.
std::vector<std::uint32_t> decimated(std::span<const double> t, std::span<const double> values, double tolerance);
/// The same for points in space: the distance at equal times.
std::vector<std::uint32_t> decimated(std::span<const double> t, std::span<const double> x, std::span<const double> y,
                                     std::span<const double> z, double tolerance);

/// Differences of consecutive values, zigzag, in groups of 7 bits, least first; base64. The first is a difference to 0.
std::string packed_integers(std::span<const std::int64_t> values);
/// Each value as its nearest multiple of `unit`, then as packed_integers(). What is no number counts as 0.
std::string packed_numbers(std::span<const double> values, double unit);

/// JSON for a <script> element: ASCII, and no `<`, `>` or `&`, so that no text can end the element or begin a comment.
/// Bytes that are no UTF-8 become U+FFFD.
std::string script_safe(const nlohmann::ordered_json& json);
/// Text for LaTeX.
std::string latex_escaped(std::string_view text);
/// Text for a cell of a Markdown table.
std::string markdown_cell(std::string_view text);

}  // namespace aslio::report
