#pragma once
/// All faults of the matrix: what is injected, what must come of it, and how it is run. docs/faults.md is made of it.

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "faults/driver.hpp"

namespace aslio::test::faults {

/// What must come of a run.
struct Expected {
  std::vector<std::string> status = {};                              ///< one of these; empty: there may be no summary
  std::vector<int> exit = {};                                        ///< one of these; empty: that of the status
  std::vector<std::pair<std::string, std::uint64_t>> counters = {};  ///< of the summary, each at least so much
  double ate_times = 0;                ///< the error is at most so many times that of the clean run ..
  double ate_plus = 0;                 ///< .. and so much more [m]; both 0: it is not looked at
  std::vector<std::string> says = {};  ///< each is in the reason or on stderr
};

struct Row {
  int number = 0;
  std::string name, injected;
  Expected expected = {};
  std::function<Outcome()> run = {};
  std::string also = {};  ///< what `check` checks, in words
  std::function<void(const Outcome&)> check = {};
  std::string pending = {};  ///< the work that is to meet it (sensors, start, monitor, noise); empty: it is met
  std::string note = {};     ///< where it is another requirement than that of the matrix: which, and why
};

std::vector<Row> imu_rows();
std::vector<Row> lidar_rows();
std::vector<Row> view_rows();
std::vector<Row> calibration_rows();
std::vector<Row> file_rows();
std::vector<Row> process_rows();
/// All, by number.
std::vector<Row> all_rows();

/// The title of the test case of a row.
std::string title(const Row& row);
/// docs/faults.md.
std::string to_markdown(const std::vector<Row>& rows);
/// Runs it and checks everything that is expected.
void hold(const Row& row);

// What several rows check, with Catch2's CHECK.
/// Some update within `within` s after `at` s of data is no longer `ok`.
void check_noticed(const Outcome& outcome, double at, double within);
/// Tracking is `ok` again within `within` s after `at` s of data, and at the end.
void check_recovered(const Outcome& outcome, double at, double within);
/// The first loss lies within `within` s after `at` s of data.
void check_lost(const Outcome& outcome, double at, double within);
/// The trajectory is that of the clean run, to the last byte.
void check_same_as_clean(const Outcome& outcome);

}  // namespace aslio::test::faults
