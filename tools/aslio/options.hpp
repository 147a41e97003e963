#pragma once
/// What CLI11's own checks leave to be desired: readable messages, and no value that wraps, overflows or is not finite.

#include <CLI/CLI.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace aslio::cli {

/// A finite number of seconds of at most 1e9; `positive` refuses zero, too.
CLI::Validator seconds(bool positive);
/// A finite number in [min, max].
CLI::Validator number(double min, double max);
/// One of `names`; another is refused with the nearest.
CLI::Validator one_of(std::string_view what, std::vector<std::string> names);
/// A whole number in [min, max] without sign.
CLI::Validator whole_number(std::uint64_t min, std::uint64_t max);

/// A file that exists, or one of those in `configs/KIND` that come with the program, by its name (`as_lio_plus`) or as
/// it lies in a clone (`configs/pipelines/as_lio_plus.yaml`). Where there is none, the message lists what there is. For
/// Option::transform(): the text becomes the path.
CLI::Validator shipped_file(std::string kind);

/// "unknown option '--ouput' (did you mean '--output'?)" for what `app` did not know; `extras`: those words.
std::string unknown_options(const CLI::App& app, const std::vector<std::string>& extras);

/// The one of `names` with the fewest letters to insert, delete or replace, at most 2 of them; empty when none is near.
std::string nearest_name(std::string_view wrong, const std::vector<std::string>& names);

}  // namespace aslio::cli
