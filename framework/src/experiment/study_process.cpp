#include "study_process.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <fstream>
#include <system_error>

#include "aslio/core/errors.hpp"

namespace aslio::experiment {

namespace {

constexpr const char* kThisProgram = "/proc/self/exe";  // the file that runs, even when it has been replaced since

/// Redirections of a child.
class FileActions {
 public:
  explicit FileActions(const std::string& log) {
    posix_spawn_file_actions_init(&actions_);
    posix_spawn_file_actions_addopen(&actions_, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_addopen(&actions_, STDOUT_FILENO, log.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
    posix_spawn_file_actions_adddup2(&actions_, STDOUT_FILENO, STDERR_FILENO);
  }
  ~FileActions() { posix_spawn_file_actions_destroy(&actions_); }
  FileActions(const FileActions&) = delete;
  FileActions& operator=(const FileActions&) = delete;
  const posix_spawn_file_actions_t* get() const { return &actions_; }

 private:
  posix_spawn_file_actions_t actions_{};
};

/// Resident memory [MB]; 0 when the process is gone.
double resident_mb(pid_t id) {
  std::ifstream statm(fmt::format("/proc/{}/statm", id));
  double size = 0, resident = 0;
  statm >> size >> resident;
  return resident * static_cast<double>(::sysconf(_SC_PAGESIZE)) * 1e-6;
}

}  // namespace

ChildProcess::ChildProcess(const std::vector<std::string>& arguments, const std::filesystem::path& log,
                           double time_limit, double memory_limit)
    : start_(std::chrono::steady_clock::now()), time_limit_(time_limit), memory_limit_(memory_limit) {
  std::vector<std::string> words = {"aslio"};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  const FileActions actions(log.string());
  const int error = ::posix_spawn(&id_, kThisProgram, actions.get(), nullptr, argv.data(), environ);
  if (error != 0) {
    throw DataError(fmt::format("a run cannot be started: {} (its log would be {})",
                                std::generic_category().message(error), log.string()));
  }
}

ChildProcess::~ChildProcess() {
  if (id_ < 0) return;
  kill();
  int status = 0;
  while (::waitpid(id_, &status, 0) < 0 && errno == EINTR) {
  }
}

double ChildProcess::wall_s() const {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
}

std::optional<ChildEnd> ChildProcess::poll() {
  int status = 0;
  if (::waitpid(id_, &status, WNOHANG) == id_) {
    id_ = -1;
    const bool exited = WIFEXITED(status);
    ChildEnd end;
    end.cause = limit_ ? *limit_ : exited ? ChildEnd::Cause::exit : ChildEnd::Cause::signal;
    end.code = exited ? WEXITSTATUS(status) : WTERMSIG(status);
    end.wall_s = wall_s();
    return end;
  }
  if (limit_) return std::nullopt;
  if (wall_s() > time_limit_) limit_ = ChildEnd::Cause::time_limit;
  if (resident_mb(id_) > memory_limit_) limit_ = ChildEnd::Cause::memory_limit;
  if (limit_) kill();
  return std::nullopt;
}

void ChildProcess::interrupt() const {
  if (id_ > 0) ::kill(id_, SIGTERM);
}

void ChildProcess::kill() const {
  if (id_ > 0) ::kill(id_, SIGKILL);
}

}  // namespace aslio::experiment
