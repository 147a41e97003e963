#include "aslio/core/csv.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <utility>

#include "aslio/core/errors.hpp"
#include "aslio/core/input_file.hpp"

namespace aslio {

CsvReader::CsvReader(std::string_view text, std::string source) : source_(std::move(source)), left_(text) {
  constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";
  if (left_.starts_with(kByteOrderMark)) left_.remove_prefix(kByteOrderMark.size());
}

void CsvReader::refuse(std::string_view why) const { throw DataError(fmt::format("{}:{}: {}", source_, line_, why)); }

bool CsvReader::at_end() const {
  return left_.empty() || left_.front() == '\n' || left_ == "\r" || left_.starts_with("\r\n");
}

bool CsvReader::next() {
  for (;; ++next_line_) {  // empty lines
    if (left_.starts_with("\r\n")) {
      left_.remove_prefix(2);
    } else if (left_.starts_with('\n')) {
      left_.remove_prefix(1);
    } else {
      break;
    }
  }
  cells_.clear();
  unquoted_.clear();
  if (left_.empty() || left_ == "\r") return false;
  line_ = next_line_;
  while (true) {
    if (cells_.size() == kMaxCsvCells) refuse(fmt::format("the line has more than {} cells", kMaxCsvCells));
    if (left_.starts_with('"')) {
      take_quoted();
    } else {
      take_plain();
    }
    if (!left_.starts_with(',')) break;
    left_.remove_prefix(1);
  }
  if (left_.starts_with('\r')) left_.remove_prefix(1);
  complete_ = !left_.empty();
  if (complete_) left_.remove_prefix(1);
  ++next_line_;
  return true;
}

void CsvReader::take_plain() {
  std::size_t end = std::min(left_.find_first_of(",\n"), left_.size());
  const bool last = end == left_.size() || left_[end] == '\n';
  if (last && end > 0 && left_[end - 1] == '\r') --end;
  cells_.push_back(left_.substr(0, end));
  left_.remove_prefix(end);
}

void CsvReader::take_quoted() {
  left_.remove_prefix(1);
  std::size_t end = 0;
  bool doubled = false;
  while (true) {
    end = left_.substr(0, kMaxCsvCellBytes).find('"', end);
    if (end == std::string_view::npos) {
      refuse(left_.size() > kMaxCsvCellBytes ? fmt::format("a quoted cell is longer than {} bytes", kMaxCsvCellBytes)
                                             : "a quote is not closed: is the file cut off?");
    }
    if (!left_.substr(end + 1).starts_with('"')) break;
    doubled = true;
    end += 2;
  }
  const std::string_view raw = left_.substr(0, end);
  next_line_ += static_cast<std::size_t>(std::count(raw.begin(), raw.end(), '\n'));
  left_.remove_prefix(end + 1);
  if (!at_end() && !left_.starts_with(',')) refuse("there is text behind a closing quote");
  cells_.push_back(raw);
  if (!doubled) return;
  std::string cell;
  for (std::size_t i = 0; i < raw.size(); ++i) {
    cell += raw[i];
    if (raw[i] == '"') ++i;
  }
  cells_.back() = unquoted_.emplace_back(std::move(cell));
}

std::size_t CsvTable::column(const std::string& name) const {
  const auto at = std::find(header.begin(), header.end(), name);
  if (at == header.end()) throw DataError(fmt::format("{}: has no column '{}'", path.string(), name));
  return static_cast<std::size_t>(at - header.begin());
}

CsvTable parse_csv(std::string_view text, const std::filesystem::path& path) {
  CsvTable table;
  table.path = path;
  CsvReader reader(text, path.string());
  if (reader.next()) table.header.assign(reader.cells().begin(), reader.cells().end());
  while (reader.next()) {
    if (reader.cells().size() != table.header.size()) {
      reader.refuse(fmt::format("has {} cells, the first line {}", reader.cells().size(), table.header.size()));
    }
    table.rows.emplace_back(reader.cells().begin(), reader.cells().end());
    table.lines.push_back(reader.line());
  }
  return table;
}

CsvTable read_csv(const std::filesystem::path& path) {
  require_input(path);
  std::ifstream stream(path, std::ios::binary);
  if (!stream) throw DataError(fmt::format("{}: cannot be opened", path.string()));
  const std::string text{std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
  if (stream.bad()) throw DataError(fmt::format("{}: cannot be read", path.string()));
  return parse_csv(text, path);
}

}  // namespace aslio
