#pragma once
/// One child process with its limits, watched from outside so that nothing it does can take the study with it.

#include <sys/types.h>

#include <chrono>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace aslio::experiment {

/// How a child ended.
struct ChildEnd {
  enum class Cause : unsigned char { exit, signal, time_limit, memory_limit };
  Cause cause = Cause::exit;
  int code = 0;  ///< exit code, or number of the signal
  double wall_s = 0;
};

/// This very program with other arguments. Ended and waited for at the latest when destroyed.
class ChildProcess {
 public:
  /// `arguments` without the program. stdout and stderr go to `log`, stdin is empty. Limits: wall-clock time [s] and
  /// resident memory [MB]. Throws DataError when it cannot be started.
  ChildProcess(const std::vector<std::string>& arguments, const std::filesystem::path& log, double time_limit,
               double memory_limit);
  ~ChildProcess();
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  /// Ends it where it is over a limit. Nothing while it runs.
  std::optional<ChildEnd> poll();
  /// Asks it to end, as Ctrl-C does.
  void interrupt() const;
  void kill() const;

 private:
  double wall_s() const;

  pid_t id_ = -1;
  std::chrono::steady_clock::time_point start_;
  double time_limit_, memory_limit_;
  std::optional<ChildEnd::Cause> limit_;  ///< that it was ended for
};

}  // namespace aslio::experiment
