#pragma once
/// Rows of numbers in a text file, by commas, semicolons or blanks.

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "aslio/core/csv.hpp"

namespace aslio::io {

/// Goes through the rows in memory that does not grow with their number. A byte order mark, CR LF, empty lines and
/// lines that begin with #, % or // are skipped.
class TextRows {
 public:
  /// `text` has to outlive the rows; `source` is named in errors. The first row tells what is between the cells.
  TextRows(std::string_view text, std::string source);

  /// Goes to the next row; false at the end. Throws DataError with file and line for what CsvReader refuses.
  bool next();

  /// Without the blanks around them; valid until next().
  const std::vector<std::string_view>& cells() const { return cells_; }
  std::size_t line() const { return line_; }
  /// The last comment before the first row, less its mark: tables have their header there.
  const std::string& comment() const { return comment_; }
  char separator() const { return separator_; }
  /// Splits a line as the rows are split.
  std::vector<std::string_view> split(std::string_view line) const;

  /// Throws DataError: "file:line: why: 'value'".
  [[noreturn]] void refuse(std::string_view why, std::string_view value) const { refuse_at(line_, why, value); }
  [[noreturn]] void refuse_at(std::size_t line, std::string_view why, std::string_view value) const;

 private:
  bool next_plain();

  std::string source_, comment_;
  std::string_view left_;
  std::optional<CsvReader> csv_;  ///< of a table by commas
  std::vector<std::string_view> cells_;
  std::size_t line_ = 0, next_line_ = 1;
  char separator_ = ' ';
  bool seen_ = false;
};

/// Content of a file of at most kMaxTextBytes. Throws DataError that names it.
std::string read_whole(const std::string& path);

}  // namespace aslio::io
