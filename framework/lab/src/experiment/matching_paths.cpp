#include "matching_paths.hpp"

#include <glob.h>

#include <algorithm>

namespace aslio::experiment {

namespace fs = std::filesystem;

bool is_pattern(std::string_view text) { return text.find_first_of("*?[") != std::string_view::npos; }

std::vector<std::string> alternatives(const std::string& text) {
  constexpr std::string_view kOr = " | ";
  std::vector<std::string> out;
  std::size_t begin = 0;
  for (std::size_t end = text.find(kOr); end != std::string::npos; end = text.find(kOr, begin)) {
    out.push_back(text.substr(begin, end - begin));
    begin = end + kOr.size();
  }
  out.push_back(text.substr(begin));
  return out;
}

fs::path pattern_in(const fs::path& folder, const std::string& pattern) {
  if (fs::path(pattern).is_absolute()) return pattern;
  std::string escaped;
  for (const char c : folder.string()) {
    if (std::string_view("*?[\\").find(c) != std::string_view::npos) escaped += '\\';
    escaped += c;
  }
  if (!escaped.empty() && !escaped.ends_with('/')) escaped += '/';
  return escaped + pattern;
}

std::vector<fs::path> matching_paths(const fs::path& folder, const std::string& pattern) {
  glob_t found{};
  std::vector<fs::path> paths;
  if (::glob(pattern_in(folder, pattern).c_str(), GLOB_NOSORT, nullptr, &found) == 0) {
    for (std::size_t i = 0; i < found.gl_pathc; ++i) paths.push_back(fs::path(found.gl_pathv[i]).lexically_normal());
  }
  ::globfree(&found);
  std::sort(paths.begin(), paths.end());
  return paths;
}

}  // namespace aslio::experiment
