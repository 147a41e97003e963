#pragma once

#include <vector>

#include "aslio/io/inspect.hpp"

namespace aslio::io {

/// Gathers the stamps of one topic in the order of recording.
class TopicStatistics {
 public:
  void add(TimeNs stamp);
  /// Fills count, rate, periods and order of a report.
  void finish(TopicReport& report);

 private:
  std::vector<TimeNs> steps_;  ///< forward steps
  TimeNs first_ = 0, last_ = 0, newest_ = kTimeMin;
  std::uint64_t count_ = 0, backward_ = 0, repeated_ = 0;
};

}  // namespace aslio::io
