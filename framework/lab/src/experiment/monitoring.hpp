#pragma once

#include <algorithm>
#include <chrono>
#include <optional>
#include <string>
#include <vector>

#include "aslio/experiment/run.hpp"
#include "aslio/io/source.hpp"
#include "aslio/pipeline/odometry.hpp"

namespace aslio::experiment {

/// Passes on what a progress display shows, at most some ten times a second of real time.
class ProgressFeed final : public pipeline::UpdateObserver {
 public:
  ProgressFeed(RunMonitor& monitor, const io::MeasurementSource& source) : monitor_(monitor) {
    if (source.begin_time() && source.end_time()) {
      progress_.duration_s = to_seconds(*source.end_time() - *source.begin_time());
    }
  }
  void on_update(const pipeline::UpdateRecord& record) override {
    // A window that a gap or the end cut short says nothing of the rate.
    reached(record.plan.fresh_begin, record.plan.end, record.overlap.value, !record.plan.partial);
  }
  /// The points of (begin, end] are done with. `whole`: the length of that interval tells the rate.
  void reached(TimeNs begin, TimeNs end, std::optional<double> overlap, bool whole) {
    if (!first_) first_ = begin;
    progress_.data_s = to_seconds(end - *first_);
    progress_.overlap = overlap;
    if (whole) progress_.rate_hz = 1.0 / to_seconds(end - begin);
    fresh_ = true;
  }
  void after_measurement() {
    if (fresh_ && seconds_since(shown_) >= 0.1) show();
  }
  void show() {
    shown_ = Clock::now();
    fresh_ = false;
    progress_.wall_s = seconds_since(start_);
    monitor_.on_progress(progress_);
  }

 private:
  using Clock = std::chrono::steady_clock;
  static double seconds_since(Clock::time_point then) {
    return std::chrono::duration<double>(Clock::now() - then).count();
  }

  RunMonitor& monitor_;
  Progress progress_;
  std::optional<TimeNs> first_;
  Clock::time_point start_ = Clock::now(), shown_ = start_;
  bool fresh_ = false;
};

/// Warnings of the input that are not among those told at the start.
inline std::vector<std::string> late_warnings(const io::MeasurementSource& source,
                                              const std::vector<std::string>& told) {
  std::vector<std::string> late;
  for (const std::string& warning : source.notes().warnings) {
    if (std::find(told.begin(), told.end(), warning) == told.end()) late.push_back(warning);
  }
  return late;
}

}  // namespace aslio::experiment
