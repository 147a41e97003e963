#include "faults/table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <iterator>

namespace aslio::test::faults {
namespace {

template <class T>
bool among(const std::vector<T>& values, const T& value) {
  return std::find(values.begin(), values.end(), value) != values.end();
}

TimeNs at(double seconds) { return clean_walk().begin() + to_ns(seconds); }

std::string metres(double m) { return m < 0.1 ? fmt::format("{:g} mm", 1000 * m) : fmt::format("{:g} m", m); }

/// The exit codes that a status may have.
std::vector<int> exits_of(std::string_view status) {
  if (status == "ok") return {0};
  if (status == "degraded") return {4};
  if (status == "diverged") return {1};
  if (status == "failed") return {1, 3};
  if (status == "truncated") return {3};
  return {130};
}

std::vector<int> exits(const Expected& e) {
  if (!e.exit.empty()) return e.exit;
  std::vector<int> all;
  for (const std::string& status : e.status) {
    for (const int code : exits_of(status)) {
      if (!among(all, code)) all.push_back(code);
    }
  }
  return all;
}

/// What is expected, in words.
std::string words(const Row& row) {
  const Expected& e = row.expected;
  std::vector<std::string> parts;
  if (!e.status.empty()) parts.push_back(fmt::format("`{}`", fmt::join(e.status, "` or `")));
  parts.push_back(fmt::format("exit {}", fmt::join(exits(e), " or ")));
  for (const auto& [name, least] : e.counters) parts.push_back(fmt::format("`{}` >= {}", name, least));
  if (e.ate_times > 0) {
    parts.push_back(fmt::format("ATE <= {:g} x clean + {}", e.ate_times, metres(e.ate_plus)));
  } else if (e.ate_plus > 0) {
    parts.push_back(fmt::format("ATE <= {}", metres(e.ate_plus)));
  }
  for (const std::string& text : e.says) parts.push_back(fmt::format("says \"{}\"", text));
  if (!row.also.empty()) parts.push_back(row.also);
  return fmt::format("{}", fmt::join(parts, "; "));
}

std::string describe(const Outcome& o) {
  const auto counts = o.summary.is_null() ? std::string("none") : o.summary.at("counts").dump();
  return fmt::format("status {} ({}), exit {}, ATE {}\nstderr: {}\ncounts: {}", o.status(), o.reason(), o.exit_code,
                     o.ate ? fmt::format("{:.4f} m", *o.ate) : "none", o.err, counts);
}

}  // namespace

std::vector<Row> all_rows() {
  std::vector<Row> all;
  for (auto* rows : {&imu_rows, &lidar_rows, &view_rows, &calibration_rows, &file_rows, &process_rows}) {
    std::vector<Row> some = rows();
    all.insert(all.end(), std::make_move_iterator(some.begin()), std::make_move_iterator(some.end()));
  }
  std::sort(all.begin(), all.end(), [](const Row& a, const Row& b) { return a.number < b.number; });
  return all;
}

std::string title(const Row& row) { return fmt::format("fault {:02d} {}", row.number, row.name); }

std::string to_markdown(const std::vector<Row>& rows) {
  std::string text =
      "# Faults\n\n"
      "What `aslio run` makes of bad input, one fault at a time. The input is one simulated walk of 12 s with a LiDAR "
      "of\n"
      "360 deg, 6700 points per sweep. The pipeline is `as_lio_plus`. Each row is a test case (`ctest -L faults`); "
      "\"clean\" is the\n"
      "same walk without the fault. "
      "`ASLIO_WRITE_FAULTS=1 build/dev/tests/faults/test_faults \"the table*\"` writes this page, and a\n"
      "test compares it with the rows.\n\n"
      "| | fault | what is injected | required, and what happens | test |\n|---|---|---|---|---|\n";
  std::string notes, pending;
  for (const Row& row : rows) {
    const bool met = row.pending.empty();
    fmt::format_to(std::back_inserter(text), "| {} | {} | {} | {}{} | `{}` |\n", row.number, row.name, row.injected,
                   words(row), met ? "" : fmt::format(" **(not yet: {})**", row.pending), title(row));
    if (!row.note.empty())
      fmt::format_to(std::back_inserter(notes), "- **{}, {}**: {}\n", row.number, row.name, row.note);
  }
  if (!notes.empty()) text += "\n## Where another requirement is met\n\n" + notes;
  return text;
}

void hold(const Row& row) {
  const Expected& e = row.expected;
  INFO(row.injected);
  const Outcome o = row.run();
  const std::string seen = describe(o);
  INFO(seen);
  if (!row.pending.empty()) WARN(title(row) + ": pending: " + row.pending + "\n" + seen);
  if (!e.status.empty()) {
    INFO("status is one of: " << fmt::format("{}", fmt::join(e.status, ", ")));
    CHECK(among(e.status, o.status()));
  }
  INFO("exit code is one of: " << fmt::format("{}", fmt::join(exits(e), ", ")));
  CHECK(among(exits(e), o.exit_code));
  if (!o.summary.is_null()) CHECK(among(exits_of(o.status()), o.exit_code));
  for (const auto& [name, least] : e.counters) {
    INFO(name);
    CHECK(o.count(name) >= least);
  }
  if (e.ate_times > 0 || e.ate_plus > 0) {
    const double clean = e.ate_times > 0 ? run_clean().ate.value() : 0.0;
    REQUIRE(o.ate.has_value());
    CHECK(*o.ate <= e.ate_times * clean + e.ate_plus);
  }
  for (const std::string& text : e.says) CHECK_THAT(o.reason() + "\n" + o.err, Catch::Matchers::Contains(text));
  if (row.check) row.check(o);
}

void check_noticed(const Outcome& o, double from, double within) {
  TimeNs noticed = kTimeMax;
  for (const char* status : {"degraded", "lost", "recovering"}) {
    noticed = std::min(noticed, o.first(status, at(from)).value_or(kTimeMax));
  }
  REQUIRE(noticed < kTimeMax);
  CHECK(to_seconds(noticed - at(from)) <= within);
}

void check_recovered(const Outcome& o, double from, double within) {
  const auto recovered = o.first("ok", at(from));
  REQUIRE(recovered.has_value());
  CHECK(to_seconds(*recovered - at(from)) <= within);
  REQUIRE_FALSE(o.tracking.empty());
  CHECK(o.tracking.back() == "ok");
}

void check_lost(const Outcome& o, double from, double within) {
  const auto lost = o.lost_at();
  REQUIRE(lost.has_value());
  CHECK(to_seconds(*lost - at(from)) >= -0.01);  // from the last sample before the fault on
  CHECK(to_seconds(*lost - at(from)) <= within);
}

void check_same_as_clean(const Outcome& o) {
  const Outcome clean = run_clean();
  REQUIRE_FALSE(clean.trajectory.empty());
  CHECK((o.trajectory == clean.trajectory));
}

}  // namespace aslio::test::faults
