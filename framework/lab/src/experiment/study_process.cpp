#include "study_process.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <fstream>
#include <system_error>

#include "aslio/core/errors.hpp"

namespace aslio::experiment {

namespace {

constexpr double kTimeToEnd = 3;  ///< from the time limit to the end of one that does not end by itself [s]

/// Resident memory [MB]; 0 when the process is gone.
double resident_mb(pid_t id) {
  std::ifstream statm(fmt::format("/proc/{}/statm", id));
  double size = 0, resident = 0;
  statm >> size >> resident;
  return resident * static_cast<double>(::sysconf(_SC_PAGESIZE)) * 1e-6;
}

bool redirect(const char* path, int flags, int to) {
  const int file = ::open(path, flags, 0644);
  return file >= 0 && ::dup2(file, to) >= 0;
}

/// Between fork and exec: nothing but system calls. Never returns; an error goes to `report`.
[[noreturn]] void become(const char* program, char* const* argv, const char* log, pid_t parent, int report) {
  sigset_t none;
  ::sigemptyset(&none);
  ::sigprocmask(SIG_SETMASK, &none, nullptr);
  ::setpgid(0, 0);
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  const rlimit no_core{0, 0};  // a crash is a row, not a gigabyte
  ::setrlimit(RLIMIT_CORE, &no_core);
  if (::getppid() != parent) ::_exit(127);  // gone before it could be told
  if (redirect("/dev/null", O_RDONLY, STDIN_FILENO) &&
      redirect(log, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, STDOUT_FILENO) &&
      ::dup2(STDOUT_FILENO, STDERR_FILENO) >= 0) {
    ::execv(program, argv);
  }
  const int error = errno;
  [[maybe_unused]] const auto written = ::write(report, &error, sizeof(error));
  ::_exit(127);
}

/// What the child wrote before it could become the program; 0 when it has.
int error_of(int report) {
  int error = 0;
  ssize_t got = 0;
  do {
    got = ::read(report, &error, sizeof(error));
  } while (got < 0 && errno == EINTR);
  return got == static_cast<ssize_t>(sizeof(error)) ? error : 0;
}

void wait_for(pid_t id) {
  int status = 0;
  while (::waitpid(id, &status, 0) < 0 && errno == EINTR) {
  }
}

[[noreturn]] void complain(int error, const std::filesystem::path& log) {
  throw DataError(fmt::format("a run cannot be started: {} (its log would be {})",
                              std::generic_category().message(error), log.string()));
}

}  // namespace

ChildProcess::ChildProcess(const std::filesystem::path& program, const std::vector<std::string>& arguments,
                           const std::filesystem::path& log, Limits limits)
    : start_(std::chrono::steady_clock::now()), limits_(limits) {
  std::vector<std::string> words = {"aslio"};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  int report[2] = {-1, -1};
  if (::pipe2(report, O_CLOEXEC) != 0) complain(errno, log);
  const pid_t parent = ::getpid();
  id_ = ::fork();
  if (id_ == 0) become(program.c_str(), argv.data(), log.c_str(), parent, report[1]);
  int error = id_ < 0 ? errno : 0;
  ::close(report[1]);
  if (error == 0) error = error_of(report[0]);
  ::close(report[0]);
  if (error == 0) {
#ifdef SYS_pidfd_open
    descriptor_ = static_cast<int>(::syscall(SYS_pidfd_open, id_, 0));
#endif
    return;
  }
  if (id_ > 0) wait_for(id_);
  complain(error, log);
}

ChildProcess::~ChildProcess() {
  if (descriptor_ >= 0) ::close(descriptor_);
  if (id_ < 0) return;
  kill();
  wait_for(id_);
}

double ChildProcess::wall_s() const {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
}

std::optional<ChildEnd> ChildProcess::poll() {
  int status = 0;
  if (::waitpid(id_, &status, WNOHANG) == id_) {
    ::kill(-id_, SIGKILL);  // what it has started and left behind
    id_ = -1;
    const bool exited = WIFEXITED(status);
    ChildEnd end;
    end.cause = limit_ ? *limit_ : exited ? ChildEnd::Cause::exit : ChildEnd::Cause::signal;
    end.code = exited ? WEXITSTATUS(status) : WTERMSIG(status);
    end.wall_s = wall_s();
    return end;
  }
  if (!limit_ && wall_s() > limits_.time_s) {
    limit_ = ChildEnd::Cause::time_limit;
    interrupt();  // to write what it has
  }
  if (resident_mb(id_) > limits_.memory_mb) limit_ = ChildEnd::Cause::memory_limit;
  if (limit_ == ChildEnd::Cause::memory_limit || wall_s() > limits_.time_s + kTimeToEnd) kill();
  return std::nullopt;
}

void ChildProcess::interrupt() const {
  if (id_ > 0) ::kill(id_, SIGTERM);
}

void ChildProcess::kill() const {
  if (id_ <= 0) return;
  ::kill(-id_, SIGKILL);
  ::kill(id_, SIGKILL);  // before it has a group of its own
}

}  // namespace aslio::experiment
