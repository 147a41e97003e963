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

struct Header {
  PlyCounts counts;
  bool text = false;
  std::uint64_t elements = 0;  ///< of every kind
  bool list_last = false;      ///< the last kind begins with a list
};

/// One line without its end, which may be that of another system; false at the end of the file.
bool next_line(std::ifstream& file, std::string& line) {
  std::string buffer(static_cast<std::size_t>(kMaxLine), '\0');
  if (!file.getline(buffer.data(), kMaxLine)) return false;
  buffer.resize(buffer.find('\0'));  // getline() has ended it
  line = std::move(buffer);
  if (line.ends_with('\r')) line.pop_back();
  return true;
}

Header read_header(std::ifstream& file, const std::filesystem::path& path, std::uint64_t file_bytes) {
  std::string line;
  if (!next_line(file, line) || line != "ply")
    throw DataError(fmt::format("{}: not a PLY file: its first line is not \"ply\"", path.string()));
  Header header;
  bool first_property = false;
  for (int number = 2; next_line(file, line) && number < kMaxHeaderLines; ++number) {
    if (line == "end_header") return header;
    std::istringstream words(line);
    std::string keyword, element, count_text;
    words >> keyword >> element >> count_text;
    if (keyword == "format") header.text = element == "ascii";
    if (keyword == "property" && first_property) {
      header.list_last = element == "list";
      first_property = false;
    }
    if (keyword != "element") continue;
    std::uint64_t count = std::numeric_limits<std::uint64_t>::max();
    if (count_text.find_first_not_of("0123456789") == std::string::npos) std::istringstream(count_text) >> count;
    // Every element takes one byte at least.
    if (count > file_bytes)
      throw DataError(fmt::format("{}:{}: \"{}\" does not fit a file of {} bytes: damaged, or cut off", path.string(),
                                  number, line, file_bytes));
    header.elements += count;
    first_property = count > 0;
    if (element == "vertex") header.counts.vertices = count;
    if (element == "face" || element == "tristrips") header.counts.faces += count;
  }
  throw DataError(fmt::format("{}: damaged PLY file: its header has no \"end_header\"", path.string()));
}

/// A text file has an element in each line. Assimp makes up what is missing at its end.
void check_lines(std::ifstream& file, const std::filesystem::path& path, const Header& header) {
  std::uint64_t elements = 0;
  std::string line, last;
  while (std::getline(file, line)) {
    if (line.find_first_not_of(" \t\r") == std::string::npos) continue;
    ++elements;
    last.swap(line);
  }
  if (elements < header.elements)
    throw DataError(fmt::format("{}: damaged, or cut off: {} elements are announced, {} lines are there", path.string(),
                                header.elements, elements));
  std::istringstream words(last);
  std::uint64_t listed = 0;
  if (!header.list_last || !(words >> listed)) return;
  std::string word;
  std::uint64_t found = 0;
  while (found < listed && words >> word) ++found;
  if (found < listed)
    throw DataError(fmt::format("{}: cut off: its last line \"{}\" lists {} of {} values", path.string(),
                                last.substr(0, 100), found, listed));
}

}  // namespace

PlyCounts read_ply_header(const std::filesystem::path& path, std::uint64_t file_bytes) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw DataError(fmt::format("{}: cannot be opened: check its permissions", path.string()));
  const Header header = read_header(file, path, file_bytes);
  if (header.text) check_lines(file, path, header);
  return header.counts;
}

}  // namespace aslio::simulator
