#include "number_lines.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "aslio/core/errors.hpp"
#include "aslio/core/input_file.hpp"

namespace aslio::io {
namespace {

constexpr std::uint64_t kMaxTableBytes = std::uint64_t{1} << 33U;

/// Commas and semicolons part cells that may be empty; blanks do so where there are none of them.
void split(std::string_view line, std::vector<std::string_view>& cells) {
  cells.clear();
  constexpr std::string_view kBlank = " \t";
  const auto trimmed = [&](std::string_view cell) {
    cell.remove_prefix(std::min(cell.size(), cell.find_first_not_of(kBlank)));
    cell.remove_suffix(cell.size() - std::min(cell.size(), cell.find_last_not_of(kBlank) + 1));
    return cell;
  };
  const bool blanks = line.find_first_of(",;") == std::string_view::npos;
  const std::string_view ends = blanks ? kBlank : std::string_view(",;");
  line = trimmed(line);
  while (true) {
    const std::size_t end = line.find_first_of(ends);
    const std::string_view cell = trimmed(line.substr(0, end));
    if (!blanks || !cell.empty()) cells.push_back(cell);
    if (end == std::string_view::npos) return;
    line.remove_prefix(end + 1);
  }
}

}  // namespace

NumberLines::NumberLines(const std::filesystem::path& path) : path_(path) {
  require_input(path, kMaxTableBytes);
  file_.open(path, std::ios::binary);
  if (!file_) throw DataError(fmt::format("{}: cannot open", path.string()));
}

bool NumberLines::next() {
  while (file_.getline(buffer_.data(), static_cast<std::streamsize>(buffer_.size()))) {
    ++number_;
    // Of what was read, the line feed, which is not kept, is counted; at the end of the file there is none.
    const auto length = static_cast<std::size_t>(file_.gcount()) - (file_.eof() ? 0 : 1);
    line_ = std::string_view(buffer_.data(), length);
    if (number_ == 1 && line_.starts_with("\xEF\xBB\xBF")) line_.remove_prefix(3);
    if (line_.ends_with('\r')) line_.remove_suffix(1);
    if (line_.find_first_not_of(" \t") == std::string_view::npos) continue;
    split(line_, cells_);
    return true;
  }
  if (!file_.eof()) {
    ++number_;
    refuse("the line is longer than 4095 characters, which no table of numbers has");
  }
  return false;
}

void NumberLines::refuse(std::string_view why) const {
  throw DataError(fmt::format("{}:{}: {}", path_.string(), number_, why));
}

}  // namespace aslio::io
