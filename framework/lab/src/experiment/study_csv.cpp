#include "study_csv.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>

#include "aslio/core/errors.hpp"
#include "aslio/core/input_file.hpp"

namespace aslio::experiment {

namespace {

std::vector<std::string> cells_of(const std::string& line) {
  std::vector<std::string> cells(1);
  bool quoted = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    if (c == '"' && quoted && i + 1 < line.size() && line[i + 1] == '"') {
      cells.back() += '"';
      ++i;
    } else if (c == '"') {
      quoted = !quoted;
    } else if (c == ',' && !quoted) {
      cells.emplace_back();
    } else {
      cells.back() += c;
    }
  }
  return cells;
}

}  // namespace

std::size_t CsvTable::column(const std::string& name) const {
  const auto at = std::find(header.begin(), header.end(), name);
  if (at == header.end()) throw DataError(fmt::format("{}: has no column '{}'", path.string(), name));
  return static_cast<std::size_t>(at - header.begin());
}

CsvTable read_csv(const std::filesystem::path& path) {
  require_input(path);
  std::ifstream stream(path);
  if (!stream) throw DataError(fmt::format("{}: cannot be opened", path.string()));
  CsvTable table;
  table.path = path;
  std::string line;
  if (std::getline(stream, line)) table.header = cells_of(line);
  while (std::getline(stream, line)) {
    table.rows.push_back(cells_of(line));
    if (table.rows.back().size() == table.header.size()) continue;
    throw DataError(fmt::format("{}:{}: has {} cells, the first line {}", path.string(), table.rows.size() + 1,
                                table.rows.back().size(), table.header.size()));
  }
  return table;
}

}  // namespace aslio::experiment
