#include "child.hpp"

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <thread>

namespace aslio::test {

namespace {

/// Async-signal-safe work between fork and exec.
using Prepare = std::function<void()>;

[[noreturn]] void become(const std::vector<std::string>& arguments, const std::string& out, const std::string& err,
                         const Prepare& prepare) {
  const auto redirect = [](const std::string& path, int to) {
    const int fd = ::open(path.c_str(), O_CREAT | O_TRUNC | O_WRONLY, 0600);
    if (fd < 0 || ::dup2(fd, to) < 0) ::_exit(127);
  };
  redirect(out, STDOUT_FILENO);
  redirect(err, STDERR_FILENO);
  std::vector<char*> argv{const_cast<char*>(ASLIO_PROGRAM)};
  for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
  argv.push_back(nullptr);
  prepare();
  ::execv(ASLIO_PROGRAM, argv.data());
  ::_exit(127);
}

Ended run(const std::vector<std::string>& arguments, const std::function<bool(pid_t, const std::string&)>& during,
          const Prepare& prepare, const std::string& stdout_path = {}) {
  const TemporaryFolder folder;
  const std::string out = stdout_path.empty() ? (folder / "out").string() : stdout_path, err = folder / "err";
  const pid_t child = ::fork();
  if (child < 0) throw std::runtime_error("fork failed");
  if (child == 0) become(arguments, out, err, prepare);
  int status = 0;
  bool done = !during, ended = false;
  while (!done && !ended) {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
    ended = ::waitpid(child, &status, WNOHANG) == child;
    done = !ended && during(child, content(err));
  }
  if (!ended) ::waitpid(child, &status, 0);
  const int code = WIFEXITED(status) ? WEXITSTATUS(status) : 256 + WTERMSIG(status);
  return {code, stdout_path.empty() ? content(out) : std::string(), content(err)};
}

}  // namespace

Ended run_aslio(const std::vector<std::string>& arguments) {
  return run(arguments, nullptr, [] {});
}

Ended run_aslio(const std::vector<std::string>& arguments,
                const std::function<bool(pid_t, const std::string&)>& during) {
  return run(arguments, during, [] {});
}

Ended run_aslio_to(const std::string& out, const std::vector<std::string>& arguments) {
  return run(
      arguments, nullptr, [] {}, out);
}

Ended run_aslio_without(const std::vector<int>& streams, const std::vector<std::string>& arguments) {
  return run(arguments, nullptr, [&streams] {
    for (const int stream : streams) ::close(stream);
  });
}

Ended run_aslio_with_file_limit(const std::vector<std::string>& arguments, std::size_t bytes) {
  return run(arguments, nullptr, [bytes] {
    const rlimit limit{bytes, bytes};
    ::setrlimit(RLIMIT_FSIZE, &limit);
  });
}

std::string content(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  std::ostringstream text;
  text << stream.rdbuf();
  return text.str();
}

void write_text(const std::filesystem::path& file, const std::string& text) {
  std::ofstream(file, std::ios::binary) << text;
}

std::vector<std::string> column(const std::filesystem::path& csv, const std::string& name) {
  const auto cells = [](const std::string& line) {
    std::vector<std::string> out;
    std::istringstream stream(line);
    for (std::string cell; std::getline(stream, cell, ',');) out.push_back(cell);
    return out;
  };
  std::ifstream stream(csv);
  std::string line;
  std::getline(stream, line);
  const auto names = cells(line);
  const auto at = std::find(names.begin(), names.end(), name);
  std::vector<std::string> out;
  if (at == names.end()) return out;
  while (std::getline(stream, line)) out.push_back(cells(line).at(static_cast<std::size_t>(at - names.begin())));
  return out;
}

std::size_t line_count(const std::filesystem::path& file) {
  const std::string text = content(file);
  return static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
}

}  // namespace aslio::test
