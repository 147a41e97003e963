#include "mesh/ply_header.hpp"

#include <fmt/format.h>

#include <fstream>
#include <limits>
#include <sstream>
#include <string>

#include "aslio/core/errors.hpp"

namespace aslio::simulator {
namespace {

constexpr int kMaxHeaderLines = 1000;
constexpr std::streamsize kMaxLine = 4096;

/// One line without its end, which may be that of another system; false at the end of the file.
bool next_line(std::ifstream& file, std::string& line) {
  std::string buffer(static_cast<std::size_t>(kMaxLine), '\0');
  if (!file.getline(buffer.data(), kMaxLine)) return false;
  line.assign(buffer.c_str());
  if (line.ends_with('\r')) line.pop_back();
  return true;
}

}  // namespace

PlyCounts read_ply_header(const std::filesystem::path& path, std::uint64_t file_bytes) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw DataError(fmt::format("{}: cannot be opened: check its permissions", path.string()));
  std::string line;
  if (!next_line(file, line) || line != "ply")
    throw DataError(fmt::format("{}: not a PLY file: its first line is not \"ply\"", path.string()));
  PlyCounts counts;
  for (int number = 2; next_line(file, line) && number < kMaxHeaderLines; ++number) {
    if (line == "end_header") return counts;
    std::istringstream words(line);
    std::string keyword, element, count_text;
    words >> keyword >> element >> count_text;
    if (keyword != "element") continue;
    std::uint64_t count = std::numeric_limits<std::uint64_t>::max();
    if (count_text.find_first_not_of("0123456789") == std::string::npos) std::istringstream(count_text) >> count;
    // Every element takes one byte at least.
    if (count > file_bytes)
      throw DataError(fmt::format("{}:{}: \"{}\" does not fit a file of {} bytes: damaged, or cut off", path.string(),
                                  number, line, file_bytes));
    if (element == "vertex") counts.vertices = count;
    if (element == "face" || element == "tristrips") counts.faces += count;
  }
  throw DataError(fmt::format("{}: damaged PLY file: its header has no \"end_header\"", path.string()));
}

}  // namespace aslio::simulator
