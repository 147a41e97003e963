#pragma once
/// Reads the tables that a study writes.

#include <filesystem>
#include <string>
#include <vector>

namespace aslio::experiment {

struct CsvTable {
  std::vector<std::string> header;
  std::vector<std::vector<std::string>> rows;  ///< as many cells as the header

  /// Throws DataError naming the file when there is no such column.
  std::size_t column(const std::string& name) const;
  std::filesystem::path path;
};

/// Cells may be quoted. Throws DataError for a file that cannot be read or a line of another length.
CsvTable read_csv(const std::filesystem::path& path);

}  // namespace aslio::experiment
