#include "slurm_queue.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <fstream>
#include <sstream>

#include "aslio/core/errors.hpp"
#include "aslio/core/sha256.hpp"
#include "aslio/io/writers.hpp"
#include "study_files.hpp"

namespace aslio::experiment {

namespace {

namespace fs = std::filesystem;

constexpr int kNotFound = 127;
constexpr std::chrono::seconds kPatience{120};  // Slurm itself gives up on its controller sooner

struct Answer {
  int code = 0;
  std::string out, error;  ///< what it wrote to stdout and stderr
  std::string text() const { return out + (out.empty() || out.ends_with('\n') ? "" : "\n") + error; }
};

/// False: the end of what the other side writes has not come in time.
bool read_all(std::array<int, 2> files, Answer& answer) {
  const auto end = std::chrono::steady_clock::now() + kPatience;
  std::array<char, 4096> buffer{};
  while (true) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(end - std::chrono::steady_clock::now());
    if (left.count() <= 0) return false;
    std::array<pollfd, 2> wait{};
    for (std::size_t i = 0; i < 2; ++i) wait[i] = {.fd = files[i], .events = POLLIN, .revents = 0};  // -1: passed over
    if (::poll(wait.data(), wait.size(), static_cast<int>(left.count())) <= 0) continue;
    for (std::size_t i = 0; i < 2; ++i) {
      if (files[i] < 0 || wait[i].revents == 0) continue;
      const ssize_t got = ::read(files[i], buffer.data(), buffer.size());
      if (got > 0) (i == 0 ? answer.out : answer.error).append(buffer.data(), static_cast<std::size_t>(got));
      if (got == 0 || (got < 0 && errno != EINTR)) files[i] = -1;
    }
    if (files[0] < 0 && files[1] < 0) return true;
  }
}

/// Runs a program of Slurm to its end, or until it has been waited for long enough.
Answer ask(const std::vector<std::string>& words) {
  std::vector<std::string> copy = words;
  std::vector<char*> argv;
  for (std::string& word : copy) argv.push_back(word.data());
  argv.push_back(nullptr);
  std::array<int, 2> ends{-1, -1}, error_ends{-1, -1};
  if (::pipe2(ends.data(), O_CLOEXEC) != 0 || ::pipe2(error_ends.data(), O_CLOEXEC) != 0) {
    throw DataError("no pipe can be made for " + words.front());
  }
  const pid_t id = ::fork();
  if (id < 0) throw DataError(words.front() + " cannot be started");
  if (id == 0) {
    ::dup2(ends[1], STDOUT_FILENO);
    ::dup2(error_ends[1], STDERR_FILENO);
    ::execvp(argv[0], argv.data());
    ::_exit(kNotFound);
  }
  ::close(ends[1]);
  ::close(error_ends[1]);
  Answer answer;
  const bool in_time = read_all({ends[0], error_ends[0]}, answer);
  ::close(ends[0]);
  ::close(error_ends[0]);
  if (!in_time) ::kill(id, SIGKILL);
  int status = 0;
  while (::waitpid(id, &status, 0) < 0 && errno == EINTR) {
  }
  answer.code = in_time && WIFEXITED(status) ? WEXITSTATUS(status) : 1;
  if (!in_time) answer.error += "timed out";
  if (answer.code == kNotFound) {
    throw ConfigError(
        fmt::format("--executor slurm: {} cannot be started; call this where Slurm's commands are, or leave the option "
                    "out",
                    words.front()));
  }
  return answer;
}

/// A controller that restarts or is overloaded, not a wrong option.
bool unreachable(const std::string& answer) {
  constexpr std::array<std::string_view, 6> kWords = {
      "contact slurm", "timed out", "onnection", "temporarily", "Zero Bytes were transmitted", "protocol"};
  return std::any_of(kWords.begin(), kWords.end(),
                     [&](std::string_view word) { return answer.find(word) != std::string::npos; });
}

/// The last line that is `digits` or `digits;cluster`: sites print notes before it. Empty: there is none.
std::string job_id(const std::string& out) {
  std::istringstream lines(out);
  std::string id;
  for (std::string line; std::getline(lines, line);) {
    const std::string number = line.substr(0, line.find(';'));
    if (!number.empty() && number.find_first_not_of("0123456789") == std::string::npos) id = number;
  }
  return id;
}

std::string quoted(const std::string& word) {
  std::string out = "'";
  for (const char c : word) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return out + "'";
}

std::vector<std::string> lines_of(const fs::path& path) {
  std::ifstream stream(path);
  std::vector<std::string> lines;
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

void write(const fs::path& path, const std::string& text) {
  io::AtomicFile file(path);
  file.write(text);
  file.close();
}

/// The mark of its end is made by renaming; a task that was told to stop leaves none.
std::string script(const fs::path& folder, const std::vector<std::string>& command) {
  std::string line;
  for (const std::string& word : command) line += quoted(word) + " ";
  return fmt::format(
      "#!/bin/bash\n"
      "# A task of `aslio experiment --executor slurm`.\n"
      "folder={}\n"
      "name=$(sed -n \"$((SLURM_ARRAY_TASK_ID + 1))p\" \"$folder/tasks.txt\")\n"
      "{}\"$name\"\n"
      "code=$?\n"
      "[ $code -ge 126 ] && exit $code\n"
      "echo $code >\"$folder/done/$SLURM_ARRAY_TASK_ID.new\" && mv \"$folder/done/$SLURM_ARRAY_TASK_ID.new\" "
      "\"$folder/done/$SLURM_ARRAY_TASK_ID\"\n"
      "[ $code -gt 1 ] && exit $code\n"
      "exit 0\n",
      quoted(folder.string()), line);
}

}  // namespace

std::string SlurmArray::task(std::size_t index) const { return fmt::format("{}_{}", job, index); }

std::optional<int> SlurmArray::ended(std::size_t index) const {
  std::ifstream stream(folder / "done" / fmt::to_string(index));
  int code = 0;
  return stream >> code ? std::optional(code) : std::nullopt;
}

SlurmQueue::SlurmQueue(const fs::path& folder, const SlurmOptions& options)
    : folder_(fs::absolute(folder)), options_(options) {
  create_folder(folder_);
}

std::string SlurmQueue::name() const { return "aslio-" + sha256_of(folder_.string()).substr(0, 12); }

std::vector<SlurmArray> SlurmQueue::earlier() const {
  std::vector<SlurmArray> arrays;
  for (int k = 0;; ++k) {
    const fs::path folder = folder_ / fmt::to_string(k);
    std::error_code ignored;
    if (!fs::exists(folder, ignored)) return arrays;
    const auto job = lines_of(folder / "job_id");
    if (!job.empty()) arrays.push_back({folder, job.front(), lines_of(folder / "tasks.txt")});
  }
}

std::optional<SlurmArray> SlurmQueue::submit(const std::vector<std::string>& names, int jobs) {
  int k = 0;
  std::error_code error;
  while (fs::exists(folder_ / fmt::to_string(k), error)) ++k;
  SlurmArray array{folder_ / fmt::to_string(k), {}, names};
  fs::create_directories(array.folder / "done", error);
  write(array.folder / "tasks.txt", fmt::format("{}\n", fmt::join(names, "\n")));
  write(array.folder / "job.sh", script(array.folder, options_.command));
  std::vector<std::string> words = {"sbatch",
                                    "--parsable",
                                    "--job-name=" + name(),
                                    fmt::format("--array=0-{}%{}", names.size() - 1, options_.throttle),
                                    "--output=" + (array.folder / "log-%a.txt").string(),
                                    "--open-mode=append",
                                    "--requeue",
                                    "--ntasks=1",
                                    fmt::format("--cpus-per-task={}", jobs)};
  words.insert(words.end(), options_.sbatch.begin(), options_.sbatch.end());
  words.push_back((array.folder / "job.sh").string());
  const Answer answer = ask(words);
  if (answer.code == 0) {
    array.job = job_id(answer.out);
    // Not once more: the tasks may well be in the queue.
    if (array.job.empty()) {
      throw ConfigError(
          fmt::format("--executor slurm: sbatch printed no job id; look with `squeue --name={}` whether the "
                      "tasks are there, and cancel them. It printed: {}",
                      name(), answer.text()));
    }
    write(array.folder / "job_id", array.job + "\n");
    return array;
  }
  fs::remove_all(array.folder, error);
  if (unreachable(answer.text())) return std::nullopt;
  throw ConfigError(fmt::format("--executor slurm: sbatch refuses: {}", answer.text()));
}

std::optional<std::set<std::string>> SlurmQueue::alive() const {
  const Answer answer = ask({"squeue", "--noheader", "--array", "--format=%F_%K", "--name=" + name()});
  if (answer.code != 0) return std::nullopt;
  std::set<std::string> tasks;
  std::istringstream stream(answer.out);
  for (std::string task; stream >> task;) tasks.insert(task);
  return tasks;
}

}  // namespace aslio::experiment
