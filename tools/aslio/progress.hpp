#pragma once

#include <string>

#include "aslio/experiment/run.hpp"

namespace aslio::cli {

/// One line without line feed: "[=====>    ]  12.3 / 26.6 s   9.1x   SOD 0.83   15.0 Hz".
std::string progress_line(const experiment::Progress& progress, bool bar);

/// Shows a run to the user: a bar on a terminal, elsewhere a line at every tenth of the data; nothing when quiet.
class ProgressDisplay final : public experiment::RunMonitor {
 public:
  ProgressDisplay(bool quiet, bool terminal) : quiet_(quiet), terminal_(terminal) {}
  void on_start(const io::SourceNotes& notes) override;
  void on_progress(const experiment::Progress& progress) override;
  bool stop_requested() override;

 private:
  bool quiet_, terminal_;
  int tenths_ = 0;
};

}  // namespace aslio::cli
