#include "study_process.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <fstream>
#include <system_error>
#include <thread>

#include "aslio/core/errors.hpp"

namespace aslio::experiment {

namespace {

constexpr double kTimeToEnd = 3;  ///< from the time limit to the end of one that does not end by itself [s]

/// The processes that this one has started and that are still there, and theirs.
void append_descendants(pid_t id, std::vector<pid_t>& found) {
  std::error_code error;
  const std::filesystem::path tasks = fmt::format("/proc/{}/task", id);
  for (auto at = std::filesystem::directory_iterator(tasks, error);
       !error && at != std::filesystem::directory_iterator(); at.increment(error)) {
    std::ifstream children(at->path() / "children");
    for (pid_t child = 0; children >> child;) {
      found.push_back(child);
      append_descendants(child, found);
    }
  }
}

/// Resident memory [MB], now and at most; 0 when the process is gone.
struct Resident {
  double now_mb = 0, peak_mb = 0;
};

Resident resident_of(pid_t id) {
  Resident out;
  std::ifstream status(fmt::format("/proc/{}/status", id));
  for (std::string line; std::getline(status, line);) {
    if (line.starts_with("VmHWM:")) out.peak_mb = std::strtod(line.c_str() + 6, nullptr) * 1024e-6;
    if (line.starts_with("VmRSS:")) out.now_mb = std::strtod(line.c_str() + 6, nullptr) * 1024e-6;
  }
  return out;
}

double seconds(const timeval& t) { return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec); }

bool redirect(const char* path, int flags, int to) {
  const int file = ::open(path, flags, 0644);
  return file >= 0 && ::dup2(file, to) >= 0;
}

/// Between fork and exec: nothing but system calls. Never returns; an error goes to `report`.
[[noreturn]] void become(const ChildCommand& command, char* const* argv, pid_t parent, int report) {
  sigset_t none;
  ::sigemptyset(&none);
  ::sigprocmask(SIG_SETMASK, &none, nullptr);
  // What this program ignores is its own matter: a pipe of others must break.
  ::signal(SIGPIPE, SIG_DFL);
  ::signal(SIGXFSZ, SIG_DFL);
  ::setpgid(0, 0);
  ::prctl(PR_SET_PDEATHSIG, command.when_left);
  const rlimit no_core{0, 0};  // a crash is a row, not a gigabyte
  ::setrlimit(RLIMIT_CORE, &no_core);
  if (::getppid() != parent) ::_exit(127);  // gone before it could be told
  if (redirect("/dev/null", O_RDONLY, STDIN_FILENO) &&
      redirect(command.log.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, STDOUT_FILENO) &&
      ::dup2(STDOUT_FILENO, STDERR_FILENO) >= 0 && (command.folder.empty() || ::chdir(command.folder.c_str()) == 0)) {
    ::execvp(command.program.c_str(), argv);
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

[[noreturn]] void complain(int error, const ChildCommand& command) {
  throw DataError(fmt::format("{}: cannot be started: {} (its log would be {})", command.program.string(),
                              std::generic_category().message(error), command.log.string()));
}

}  // namespace

ChildProcess::ChildProcess(const ChildCommand& command, Limits limits)
    : adopts_(command.adopts), start_(std::chrono::steady_clock::now()), limits_(limits) {
  std::vector<std::string> words = command.arguments;
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  if (adopts_) ::prctl(PR_SET_CHILD_SUBREAPER, 1);
  int report[2] = {-1, -1};
  if (::pipe2(report, O_CLOEXEC) != 0) complain(errno, command);
  const pid_t parent = ::getpid();
  id_ = ::fork();
  if (id_ == 0) become(command, argv.data(), parent, report[1]);
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
  id_ = -1;
  complain(error, command);
}

ChildProcess::~ChildProcess() {
  if (descriptor_ >= 0) ::close(descriptor_);
  if (id_ < 0) return;
  kill();
  wait_for(id_);
  if (adopts_) end_adopted();
}

double ChildProcess::wall_s() const {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
}

std::vector<pid_t> ChildProcess::all() const {
  std::vector<pid_t> found;
  if (!adopts_) found.push_back(id_);
  append_descendants(adopts_ ? ::getpid() : id_, found);
  return found;
}

double ChildProcess::end_adopted() {
  double cpu_s = 0;
  const auto until = std::chrono::steady_clock::now() + std::chrono::duration<double>(kTimeToEnd);
  while (std::chrono::steady_clock::now() < until) {  // one that cannot be ended must not hold up the rest
    std::vector<pid_t> left;
    append_descendants(::getpid(), left);
    for (const pid_t id : left) ::kill(id, SIGKILL);
    rusage usage{};
    pid_t ended = 0;
    while ((ended = ::wait4(-1, nullptr, WNOHANG, &usage)) > 0) {
      cpu_s += seconds(usage.ru_utime) + seconds(usage.ru_stime);
    }
    if (ended < 0 && errno != EINTR) break;  // there is none
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return cpu_s;
}

double ChildProcess::look_at_memory() {
  double sum = 0;
  for (const pid_t id : all()) {
    const Resident resident = resident_of(id);
    sum += resident.now_mb;
    peak_rss_mb_ = std::max(peak_rss_mb_, resident.peak_mb);
  }
  peak_rss_mb_ = std::max(peak_rss_mb_, sum);
  return sum;
}

std::optional<ChildEnd> ChildProcess::poll() {
  if (id_ < 0) return std::nullopt;  // it was told before
  int status = 0;
  rusage usage{};
  if (::wait4(id_, &status, WNOHANG, &usage) == id_) {
    if (!adopts_) ::kill(-id_, SIGKILL);  // what it has started and left behind
    const double adopted_s = adopts_ ? end_adopted() : 0;
    id_ = -1;
    const bool exited = WIFEXITED(status);
    ChildEnd end;
    end.cause = limit_ ? *limit_ : exited ? ChildEnd::Cause::exit : ChildEnd::Cause::signal;
    end.code = exited ? WEXITSTATUS(status) : WTERMSIG(status);
    end.wall_s = wall_s();
    end.cpu_s = seconds(usage.ru_utime) + seconds(usage.ru_stime) + adopted_s;
    end.peak_rss_mb = peak_rss_mb_;  // ru_maxrss would be that of this process, if larger: it survives exec
    return end;
  }
  if (!limit_ && wall_s() > limits_.time_s) {
    limit_ = ChildEnd::Cause::time_limit;
    interrupt();  // to write what it has
  }
  if (look_at_memory() > limits_.memory_mb) limit_ = ChildEnd::Cause::memory_limit;
  if (limit_ == ChildEnd::Cause::memory_limit || wall_s() > limits_.time_s + kTimeToEnd) kill();
  return std::nullopt;
}

void ChildProcess::interrupt() const {
  if (id_ > 0) ::kill(id_, SIGTERM);
}

void ChildProcess::kill() const {
  if (id_ <= 0) return;
  // Those with a session of their own are in no group of ours.
  for (const pid_t id : all()) ::kill(id, SIGKILL);
  ::kill(-id_, SIGKILL);
  ::kill(id_, SIGKILL);  // before it has a group of its own
}

}  // namespace aslio::experiment
