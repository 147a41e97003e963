#pragma once

#include <array>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>
#include <vector>

namespace aslio::io {

/// Tables of numbers, line by line: cells are parted by commas, semicolons or blanks. Empty lines are skipped; a
/// comment is a line like any other. Memory does not grow with the file.
class NumberLines {
 public:
  /// Throws DataError for what is no regular file, or too large.
  explicit NumberLines(const std::filesystem::path& path);

  /// False at the end. Throws DataError for a line of more than 4095 characters.
  bool next();
  const std::vector<std::string_view>& cells() const { return cells_; }  ///< valid until next()
  std::string_view line() const { return line_; }
  std::size_t number() const { return number_; }  ///< of the line, from 1
  bool complete() const { return !file_.eof(); }  ///< a line feed ends the line
  [[noreturn]] void refuse(std::string_view why) const;

 private:
  std::filesystem::path path_;
  std::ifstream file_;
  std::array<char, 4096> buffer_{};
  std::string_view line_;
  std::vector<std::string_view> cells_;
  std::size_t number_ = 0;
};

}  // namespace aslio::io
