#pragma once

#include <optional>
#include <set>
#include <string>

#include "aslio/experiment/run.hpp"

namespace aslio::cli {

/// Where work over data stands.
struct Standing {
  double data_s = 0;                 ///< done [s of data]
  std::optional<double> duration_s;  ///< of all data, where known [s]
  double wall_s = 0;
  std::string more;  ///< shown behind; with all else at most 80 columns
};

/// One line without line feed: "[=====>    ]  12.3 / 26.6 s   9.1x real time   ...".
std::string progress_line(const Standing& standing, bool bar);

/// A bar on a terminal, elsewhere a line at every tenth of the data; nothing when quiet.
class ProgressBar {
 public:
  ProgressBar(bool quiet, bool terminal) : quiet_(quiet), terminal_(terminal) {}
  void show(const Standing& standing);
  /// Before anything else is printed.
  void clear() const;

 private:
  bool quiet_, terminal_;
  int tenths_ = 0;
};

/// Shows a run to the user.
class ProgressDisplay final : public experiment::RunMonitor {
 public:
  ProgressDisplay(bool quiet, bool terminal) : quiet_(quiet), bar_(quiet, terminal) {}
  void on_start(const io::SourceNotes& notes) override;
  void on_progress(const experiment::Progress& progress) override;
  bool stop_requested() override;
  void on_notice(const std::string& notice) override;
  void clear() const { bar_.clear(); }

 private:
  /// What was said of a recording is not said again where a command reads it twice.
  void tell_once(const std::string& line);

  bool quiet_;
  ProgressBar bar_;
  std::set<std::string> told_;
};

}  // namespace aslio::cli
