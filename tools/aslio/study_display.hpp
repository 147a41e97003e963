#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "aslio/experiment/study_run.hpp"

namespace aslio::cli {

/// Lines of the display, each at most `width` columns: a bar with count, time left and failures, then what is at work.
std::string display_text(const experiment::StudyProgress& progress, std::size_t width);

/// The first metric of a study: a line per method, medians over seeds by sequence, aligned. Marks as in table.md.
std::string medians_text(const experiment::Study& study, const std::vector<experiment::StudyRun>& runs,
                         const std::vector<std::optional<experiment::StudyRow>>& rows);

/// Shows a study to the user: on a terminal what ends scrolls by above a display of what runs, elsewhere it is a line
/// each.
class StudyDisplay final : public experiment::StudyMonitor {
 public:
  StudyDisplay(bool quiet, bool terminal) : quiet_(quiet), terminal_(terminal && !quiet) {}
  ~StudyDisplay() override { clear(); }
  StudyDisplay(const StudyDisplay&) = delete;
  StudyDisplay& operator=(const StudyDisplay&) = delete;

  void on_line(const std::string& line) override;
  void on_progress(const experiment::StudyProgress& progress) override;
  bool stop_requested() override;
  /// Before anything else is printed.
  void clear();

 private:
  bool quiet_, terminal_;
  std::size_t drawn_ = 0;  ///< lines
};

}  // namespace aslio::cli
