#include "../../framework/lab/src/experiment/study_csv.hpp"
#include "aslio/report/run_series.hpp"
#include "aslio/report/study_folder.hpp"
#include "fuzz/target.hpp"

ASLIO_FUZZ_TARGET(csv) {
  std::size_t held = 0;
  for (const auto& line : report::parse_csv(text_of(bytes))) {
    for (const std::string& cell : line) held += cell.size();
  }
  must(held <= bytes.size(), "cells hold no more than the file");
  const auto path = written("input.csv", bytes);
  accepts([&] {
    const experiment::CsvTable table = experiment::read_csv(path);
    for (const auto& row : table.rows) must(row.size() == table.header.size(), "a row is as long as the header");
  });
  if (const auto columns = report::read_columns(path)) {
    for (const auto& [name, values] : columns->numbers) must(values.size() == columns->t.size(), "a column is whole");
    for (const auto& [name, values] : columns->texts) must(values.size() == columns->t.size(), "a column is whole");
  }
}
