#pragma once
/// The one reader of comma-separated tables (RFC 4180).

#include <cstddef>
#include <deque>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace aslio {

inline constexpr std::size_t kMaxCsvCells = 10'000;  ///< of a line
inline constexpr std::size_t kMaxCsvCellBytes =
    1U << 20U;  ///< of a quoted cell: one whose quote is never closed ends here

/// Goes through a table line by line, in memory that does not grow with the number of lines. A byte order mark, the CR
/// of a CR LF and empty lines are skipped. A cell whose first character is a quote may hold commas, line feeds and,
/// doubled, quotes. A quote elsewhere is a character like any other.
class CsvReader {
 public:
  /// `text` has to outlive the reader; `source` is named in errors.
  CsvReader(std::string_view text, std::string source);

  /// Goes to the next line; false at the end. Throws DataError with file and line for a quote that is not closed, text
  /// behind a closing quote, and what is beyond the limits.
  bool next();

  /// Of the current line, quotes undone; valid until next().
  const std::vector<std::string_view>& cells() const { return cells_; }
  /// Where the current line begins, from 1.
  std::size_t line() const { return line_; }
  /// Whether a line feed ends the current line: the last line of a file that is still written may be cut.
  bool complete() const { return complete_; }
  /// Throws DataError that names file and line.
  [[noreturn]] void refuse(std::string_view why) const;

 private:
  void take_plain();
  void take_quoted();
  /// Whether what is left begins with the end of a line.
  bool at_end() const;

  std::string source_;
  std::string_view left_;
  std::vector<std::string_view> cells_;
  std::deque<std::string>
      unquoted_;  ///< cells of the line that held doubled quotes; a deque, for cells_ refers to them
  std::size_t line_ = 0, next_line_ = 1;
  bool complete_ = false;
};

/// A whole table, each line as long as the first.
struct CsvTable {
  std::filesystem::path path;
  std::vector<std::string> header;
  std::vector<std::vector<std::string>> rows;  ///< as many cells as the header
  std::vector<std::size_t> lines;              ///< where each row begins in the file

  /// Throws DataError naming the file when there is no such column.
  std::size_t column(const std::string& name) const;
};

/// Throws what CsvReader throws, and DataError with file and line for a line of another length. `path` is named only.
CsvTable parse_csv(std::string_view text, const std::filesystem::path& path);

/// The same from a file. Throws DataError, too, for one that cannot be read.
CsvTable read_csv(const std::filesystem::path& path);

}  // namespace aslio
