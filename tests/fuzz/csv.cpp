#include "aslio/core/csv.hpp"

#include "aslio/report/run_series.hpp"
#include "fuzz/target.hpp"

ASLIO_FUZZ_TARGET(csv) {
  std::size_t held = 0, last = 0;
  accepts([&] {
    for (CsvReader reader(text_of(bytes), "input.csv"); reader.next(); last = reader.line()) {
      must(reader.line() > last, "lines are counted on");
      must(!reader.cells().empty() && reader.cells().size() <= kMaxCsvCells, "a line holds cells");
      for (const std::string_view cell : reader.cells()) held += cell.size();
    }
  });
  must(held <= bytes.size(), "cells hold no more than the file");
  const auto path = written("input.csv", bytes);
  accepts([&] {
    const CsvTable table = read_csv(path);
    for (const auto& row : table.rows) must(row.size() == table.header.size(), "a row is as long as the header");
  });
  if (const auto columns = report::read_columns(path)) {
    for (const auto& [name, values] : columns->numbers) must(values.size() == columns->t.size(), "a column is whole");
    for (const auto& [name, values] : columns->texts) must(values.size() == columns->t.size(), "a column is whole");
  }
}
