#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace aslio::config {

/// The name that `wrong` was probably meant to be: least edit distance (insert, delete, replace, swap neighbours), at
/// most a third of its length or 2; empty when nothing is near.
std::string nearest(std::string_view wrong, const std::vector<std::string>& names);
/// "a, b, c".
std::string join(const std::vector<std::string>& names);
/// " (did you mean 'x'?)", or " (known: a, b)" when nothing is near.
std::string suggestion(std::string_view wrong, const std::vector<std::string>& names);

}  // namespace aslio::config
