#include "text_rows.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <iterator>

#include "aslio/core/errors.hpp"
#include "aslio/core/input_file.hpp"

namespace aslio::io {
namespace {

constexpr std::string_view kBlanks = " \t\r";
constexpr std::size_t kLeastColumns = 4;  ///< a time and a position

std::string_view trimmed(std::string_view text) {
  const std::size_t begin = text.find_first_not_of(kBlanks);
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(kBlanks) - begin + 1);
}

bool is_comment(std::string_view line) {
  return line.starts_with('#') || line.starts_with('%') || line.starts_with("//");
}

/// The next line of `left`, which loses it.
std::string_view take_line(std::string_view& left) {
  const std::size_t end = std::min(left.find('\n'), left.size());
  const std::string_view line = left.substr(0, end);
  left.remove_prefix(std::min(end + 1, left.size()));
  return line;
}

std::vector<std::string_view> split_at(std::string_view line, char separator) {
  std::vector<std::string_view> cells;
  while (true) {
    const std::size_t end = std::min(line.find(separator), line.size());
    cells.push_back(trimmed(line.substr(0, end)));
    if (end == line.size()) return cells;
    line.remove_prefix(end + 1);
  }
}

std::vector<std::string_view> split_at_blanks(std::string_view line) {
  std::vector<std::string_view> cells;
  while (true) {
    const std::size_t begin = line.find_first_not_of(kBlanks);
    if (begin == std::string_view::npos) return cells;
    line.remove_prefix(begin);
    const std::size_t end = std::min(line.find_first_of(kBlanks), line.size());
    cells.push_back(line.substr(0, end));
    line.remove_prefix(end);
  }
}

/// Two numbers or more.
bool holds_numbers(std::string_view cell) {
  const auto parts = split_at_blanks(cell);
  return parts.size() > 1 && std::all_of(parts.begin(), parts.end(), [](std::string_view part) {
           return std::string_view("-+.0123456789").find(part.front()) != std::string_view::npos;
         });
}

/// What is between the cells of a row. `1,5 2,5` has decimal commas: cells of a table hold no blanks.
char separator_of(std::string_view row) {
  for (const char separator : {',', ';'}) {
    const auto cells = split_at(row, separator);
    const bool blank = std::any_of(cells.begin(), cells.end(), holds_numbers);
    if (cells.size() >= kLeastColumns && !blank) return separator;
  }
  return ' ';
}

/// The first row decides; a header whose names hold blanks ("p_RS_R_x [m]") comes before it, mostly as a comment.
char find_separator(std::string_view text) {
  for (std::string_view left = text; !left.empty();) {
    const std::string_view line = trimmed(take_line(left));
    if (!line.empty() && !is_comment(line)) return separator_of(line);
  }
  return ' ';
}

}  // namespace

TextRows::TextRows(std::string_view text, std::string source) : source_(std::move(source)), left_(text) {
  constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";
  if (left_.starts_with(kByteOrderMark)) left_.remove_prefix(kByteOrderMark.size());
  separator_ = find_separator(left_);
  if (separator_ == ',') csv_.emplace(left_, source_);
}

void TextRows::refuse_at(std::size_t line, std::string_view why, std::string_view value) const {
  throw DataError(fmt::format("{}:{}: {}: '{}'", source_, line, why, value.substr(0, 100)));
}

std::vector<std::string_view> TextRows::split(std::string_view line) const {
  return separator_ == ' ' ? split_at_blanks(line) : split_at(line, separator_);
}

bool TextRows::next_plain() {
  while (!left_.empty()) {
    line_ = next_line_++;
    const std::string_view line = trimmed(take_line(left_));
    if (line.empty()) continue;
    if (!is_comment(line)) {
      cells_ = split(line);
      return true;
    }
    if (!seen_) comment_ = std::string(trimmed(line.substr(std::min(line.find_first_not_of("#%/ "), line.size()))));
  }
  return false;
}

bool TextRows::next() {
  if (!csv_) {
    const bool found = next_plain();
    seen_ = seen_ || found;
    return found;
  }
  while (csv_->next()) {
    line_ = csv_->line();
    cells_ = csv_->cells();
    for (std::string_view& cell : cells_) cell = trimmed(cell);
    if (!is_comment(cells_.front())) return seen_ = true;
    if (seen_) continue;
    comment_.clear();
    for (const std::string_view cell : cells_) comment_.append(comment_.empty() ? "" : ",").append(cell);
    comment_.erase(0, std::min(comment_.find_first_not_of("#%/ "), comment_.size()));
  }
  return false;
}

std::string read_whole(const std::string& path) {
  require_input(path);
  std::ifstream file(path, std::ios::binary);
  if (!file) throw DataError(fmt::format("{}: cannot open the trajectory", path));
  std::string text{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  if (file.bad()) throw DataError(fmt::format("{}: cannot read", path));
  return text;
}

}  // namespace aslio::io
