#include <fstream>
#include <sstream>

#include "aslio/core/input_file.hpp"
#include "aslio/report/study_folder.hpp"

namespace aslio::report {

std::vector<std::vector<std::string>> parse_csv(std::string_view text) {
  std::vector<std::vector<std::string>> lines;
  std::vector<std::string> line;
  std::string cell;
  bool quoted = false, any = false;
  const auto end_line = [&] {
    line.push_back(std::move(cell));
    lines.push_back(std::move(line));
    cell.clear();
    line.clear();
    any = false;
  };
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (quoted) {
      if (c != '"') {
        cell += c;
      } else if (i + 1 < text.size() && text[i + 1] == '"') {
        cell += text[++i];
      } else {
        quoted = false;
      }
      continue;
    }
    if (c == '\n') {
      if (any) end_line();
      continue;
    }
    if (c == '\r') continue;
    any = true;
    if (c == '"') {
      quoted = true;
    } else if (c == ',') {
      line.push_back(std::move(cell));
      cell.clear();
    } else {
      cell += c;
    }
  }
  if (any) end_line();
  return lines;
}

std::optional<std::string> read_file(const std::filesystem::path& path) {
  if (!why_no_input(path).empty()) return std::nullopt;
  std::ifstream stream(path, std::ios::binary);
  if (!stream) return std::nullopt;
  std::ostringstream text;
  text << stream.rdbuf();
  return std::move(text).str();
}

}  // namespace aslio::report
