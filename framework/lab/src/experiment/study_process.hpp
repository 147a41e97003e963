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
  double cpu_s = 0;        ///< of it and of what it started: what it waited for, and what was adopted
  double peak_rss_mb = 0;  ///< the largest of: all its processes together at a poll(), one of them alone
};

/// What a child is started with.
struct ChildCommand {
  std::filesystem::path program;       ///< without a slash: looked for in PATH
  std::vector<std::string> arguments;  ///< the first one is the name by which it is called
  std::filesystem::path log;           ///< stdout and stderr
  std::filesystem::path folder = {};   ///< in which it works; empty: that of this process
  /// This process becomes the parent of whatever the child leaves behind, and ends and counts it, too. It must have no
  /// other children.
  bool adopts = false;
  int when_left = 9;  ///< signal to the child when this process ends: SIGKILL, or one that lets it end what it started
};

/// A program that ends with this process, however that ends. Ended and waited for at the latest when destroyed. stdin
/// is empty.
class ChildProcess {
 public:
  struct Limits {
    double time_s = 0;     ///< wall-clock time
    double memory_mb = 0;  ///< resident, with all that it has started
  };
  /// Throws DataError when it cannot be started.
  ChildProcess(const ChildCommand& command, Limits limits);
  ~ChildProcess();
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  /// Ends it where it is over a limit. Its end, once; nothing while it runs, nor afterwards.
  std::optional<ChildEnd> poll();
  /// Readable from the moment it has ended; -1 where there is none to be had (before Linux 5.3, or no more files).
  int descriptor() const { return descriptor_; }
  /// Asks it to end, as Ctrl-C does.
  void interrupt() const;
  /// With everything that it has started.
  void kill() const;

 private:
  double wall_s() const;
  double look_at_memory();
  /// The child and all that it has started and that is still there.
  std::vector<pid_t> all() const;
  /// Ends what the child has left behind; the CPU time of it [s].
  static double end_adopted();

  pid_t id_ = -1;
  bool adopts_ = false;
  double peak_rss_mb_ = 0;
  int descriptor_ = -1;
  std::chrono::steady_clock::time_point start_;
  Limits limits_;
  std::optional<ChildEnd::Cause> limit_;  ///< that it was ended for
};

}  // namespace aslio::experiment
