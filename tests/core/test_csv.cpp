/// The one reader of tables: what earlier readers took in different ways.
#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "aslio/core/csv.hpp"
#include "aslio/core/errors.hpp"
#include "temporary_folder.hpp"

using namespace aslio;
using Catch::Contains;

namespace {

using Lines = std::vector<std::vector<std::string>>;

Lines lines_of(std::string_view text) {
  Lines lines;
  for (CsvReader reader(text, "t.csv"); reader.next();) {
    lines.emplace_back(reader.cells().begin(), reader.cells().end());
  }
  return lines;
}

std::string refusal(std::string_view text) {
  try {
    (void)parse_csv(text, "t.csv");
  } catch (const DataError& error) {
    return error.what();
  }
  return "accepted";
}

}  // namespace

TEST_CASE("a table is the same with LF and CR LF, with a byte order mark, and without the last line feed") {
  const Lines expected = {{"a", "b"}, {"1", ""}, {"", "x y"}};
  for (const char* text : {"a,b\n1,\n,x y\n", "a,b\r\n1,\r\n,x y\r\n", "\357\273\277a,b\n1,\n,x y", "a,b\n1,\n,x y\r",
                           "\n\r\na,b\n\n1,\r\n\n,x y\n\n\r\n\r"}) {
    CAPTURE(text);
    CHECK(lines_of(text) == expected);
  }
  CHECK(lines_of("").empty());
  CHECK(lines_of("\xef\xbb\xbf\r\n").empty());
  CHECK(lines_of("a\rb,c\n") == Lines{{"a\rb", "c"}});  // no end of a line
  CHECK(lines_of("a,\n") == Lines{{"a", ""}});
  CHECK(lines_of(",") == Lines{{"", ""}});
}

TEST_CASE("quotes hold commas, line feeds and quotes, and are plain inside a cell") {
  CHECK(lines_of("\"a,b\",\"c\nd\",\"e\r\nf\"\r\n1,2,3\n") == Lines{{"a,b", "c\nd", "e\r\nf"}, {"1", "2", "3"}});
  CHECK(lines_of("\"say \"\"no\"\"\",\"\"\"\",\"\"\n") == Lines{{"say \"no\"", "\"", ""}});
  CHECK(lines_of("5\" wide,x\"y\"\n") == Lines{{"5\" wide", "x\"y\""}});
  Lines many = {{}};
  std::string text;
  for (int i = 0; i < 100; ++i) {
    text += (i > 0 ? ",\"" : "\"") + std::to_string(i) + "\"\"\"";
    many[0].push_back(std::to_string(i) + "\"");
  }
  CHECK(lines_of(text) == many);  // the cells of a line stay valid together
}

TEST_CASE("an error names file and line, counted with what quotes hold and with empty lines") {
  CHECK(refusal("a,b\n\"x\ny\",2\n\n1\n") == "t.csv:5: has 1 cells, the first line 2");
  CHECK_THAT(refusal("a,b\n1,\"2\n3\n"), Contains("t.csv:2: a quote is not closed"));
  CHECK_THAT(refusal("a,b\n1,\"2\" 3\n"), Contains("t.csv:2: there is text behind a closing quote"));
  CHECK_THAT(refusal("a\n" + std::string(kMaxCsvCells, ',')), Contains("t.csv:2: the line has more than 10000 cells"));
  CHECK_THAT(refusal("a\n\"" + std::string(kMaxCsvCellBytes + 1, 'x') + "\"\n"),
             Contains("t.csv:2: a quoted cell is longer than"));
  CHECK(refusal("a\n\"" + std::string(kMaxCsvCellBytes - 1, 'x') + "\"\n") == "accepted");
}

TEST_CASE("a reader says whether a line feed ends the line, and where it begins") {
  CsvReader reader("a\r\n\n\"b\nc\"\nd", "t.csv");
  std::vector<std::pair<std::size_t, bool>> seen;
  while (reader.next()) seen.emplace_back(reader.line(), reader.complete());
  CHECK(seen == std::vector<std::pair<std::size_t, bool>>{{1, true}, {3, true}, {5, false}});
}

TEST_CASE("a table from a file has columns by name") {
  const aslio::test::TemporaryFolder folder;
  const CsvTable table = read_csv(folder.write("t.csv", "a,b\r\n1,2\r\n"));
  CHECK(table.column("b") == 1);
  CHECK(table.rows == Lines{{"1", "2"}});
  CHECK(table.lines == std::vector<std::size_t>{2});
  CHECK_THROWS_WITH(table.column("c"), Contains("t.csv: has no column 'c'"));
  CHECK_THROWS_AS(read_csv(folder.path() / "none.csv"), DataError);
  CHECK_THROWS_AS(read_csv(folder.path()), DataError);
}
