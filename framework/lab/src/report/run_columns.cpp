#include "run_columns.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>

#include "aslio/core/csv.hpp"
#include "aslio/core/errors.hpp"
#include "aslio/io/writers.hpp"

namespace aslio::report {

namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

bool is_text(std::string_view name) { return name == "status" || name == "tracking" || name == "digest"; }

double number_of(std::string_view cell) {
  double value = 0;
  const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
  return error == std::errc{} && end == cell.data() + cell.size() && std::isfinite(value) ? value : kNone;
}

using Cells = std::vector<std::string_view>;

class Reader {
 public:
  explicit Reader(const Cells& header) {
    for (const std::string_view name : header) names_.emplace_back(name);
    for (const std::string& name : names_) {
      if (name == "t_ns") {
        targets_.push_back({});
      } else if (columns_.texts.contains(name) || columns_.numbers.contains(name)) {
        targets_.push_back({});  // two columns of one name would be one of twice the length
        repeated_ = name;
      } else if (is_text(name)) {
        targets_.push_back({nullptr, &columns_.texts[name]});
      } else {
        targets_.push_back({&columns_.numbers[name], nullptr});
      }
    }
  }

  void take(const Cells& cells) {
    ++lines_;
    if (cells.size() != names_.size()) return;
    TimeNs t = 0;
    for (std::size_t i = 0; i < names_.size(); ++i) {
      if (names_[i] != "t_ns") continue;
      const auto [end, error] = std::from_chars(cells[i].data(), cells[i].data() + cells[i].size(), t);
      if (error != std::errc{} || !io::is_time(t) || (!columns_.t.empty() && t <= columns_.t.back())) return;
    }
    columns_.t.push_back(t);
    for (std::size_t i = 0; i < names_.size(); ++i) {
      if (targets_[i].numbers != nullptr) targets_[i].numbers->push_back(number_of(cells[i]));
      if (targets_[i].texts != nullptr) targets_[i].texts->emplace_back(cells[i]);
    }
  }

  bool has_time() const { return std::find(names_.begin(), names_.end(), "t_ns") != names_.end(); }
  std::size_t lines() const { return lines_; }
  /// A name that two columns have; empty: none.
  const std::string& repeated() const { return repeated_; }
  Columns finish() { return std::move(columns_); }

 private:
  struct Target {
    std::vector<double>* numbers = nullptr;
    std::vector<std::string>* texts = nullptr;
  };
  Columns columns_;
  std::vector<std::string> names_;
  std::vector<Target> targets_;
  std::string repeated_;
  std::size_t lines_ = 0;  ///< seen, those left out among them
};

}  // namespace

std::optional<Columns> read_columns(const std::filesystem::path& path) {
  std::vector<std::string> ignored;
  return read_columns(path, ignored);
}

std::optional<Columns> read_columns(const std::filesystem::path& path, std::vector<std::string>& notes) {
  const auto text = read_file(path);
  if (!text) return std::nullopt;
  const auto note = [&](const std::string& problem) { notes.push_back(path.filename().string() + ": " + problem); };
  CsvReader csv(*text, path.filename().string());
  std::string damage;
  const auto next = [&] {
    try {
      return csv.next();
    } catch (const DataError& error) {
      damage = error.what();
      return false;
    }
  };
  Reader reader(next() && csv.complete() ? csv.cells() : Cells());
  if (!reader.has_time()) {
    note(text->empty() ? "it is empty" : "its first line names no column t_ns; the file is left out");
    return std::nullopt;
  }
  bool cut = false;
  while (next()) {
    cut = !csv.complete();
    if (!cut) reader.take(csv.cells());
  }
  if (!reader.repeated().empty()) {
    note(fmt::format("its first line names the column {} twice; the first one is shown", reader.repeated()));
  }
  if (!damage.empty()) notes.push_back(damage + "; what stands before is shown");
  if (cut) note("it is cut off in the middle of a line; what stands before is shown");
  const std::size_t lines = reader.lines();
  Columns columns = reader.finish();
  if (columns.t.size() < lines) {
    note(
        fmt::format("{} of {} lines have another number of cells than the first, or no time that is later than the "
                    "one before; they are left out",
                    lines - columns.t.size(), lines));
  }
  if (columns.t.empty()) return std::nullopt;
  return columns;
}

}  // namespace aslio::report
