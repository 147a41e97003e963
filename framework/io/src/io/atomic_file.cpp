#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <system_error>

#include "aslio/core/errors.hpp"
#include "aslio/io/writers.hpp"

namespace aslio::io {
namespace {

[[noreturn]] void fail(const std::filesystem::path& path, std::string_view what, int error) {
  const char* remedy = error == ENOSPC   ? "free space on that disk or choose another output folder"
                       : error == EACCES ? "choose an output folder you may write to"
                       : error == ENOENT ? "create the folder first"
                                         : "check the disk and the output path";
  throw DataError(fmt::format("{}: {}: {}; {}", path.string(), what, std::strerror(error), remedy));
}

/// What follows the name of a file in that of its temporary file.
std::string temporary_suffix(pid_t process, int attempt) { return fmt::format(".{}-{}.part", process, attempt); }

/// The process that wrote a temporary file of that suffix; 0 when it is none.
pid_t writer_of(std::string_view suffix) {
  pid_t process = 0;
  int attempt = -1;
  if (suffix.empty()) return 0;
  const char* const end = suffix.data() + suffix.size();
  const auto [dash, bad_process] = std::from_chars(suffix.data() + 1, end, process);
  if (bad_process != std::errc{} || dash == end || process <= 0) return 0;
  if (std::from_chars(dash + 1, end, attempt).ec != std::errc{} || attempt < 0) return 0;
  return suffix == temporary_suffix(process, attempt) ? process : 0;
}

/// Removes what a process that was killed left beside `target`; nobody else will. On a shared file system the process
/// may live on another machine, so that a file must not have been written to for an hour, either.
void remove_leftovers(const std::filesystem::path& target) {
  constexpr std::time_t kAbandoned = 3600;  // s
  const std::string name = target.filename().string();
  const std::filesystem::path folder = target.has_parent_path() ? target.parent_path() : ".";
  std::error_code ignored;
  for (std::filesystem::directory_iterator it(folder, ignored), end; it != end; it.increment(ignored)) {
    const std::string entry = it->path().filename().string();
    if (!entry.starts_with(name)) continue;
    const pid_t process = writer_of(std::string_view(entry).substr(name.size()));
    if (process == 0 || ::kill(process, 0) == 0 || errno != ESRCH) continue;
    struct stat facts {};
    if (::lstat(it->path().c_str(), &facts) != 0 || !S_ISREG(facts.st_mode)) continue;
    if (std::time(nullptr) - facts.st_mtime > kAbandoned) ::unlink(it->path().c_str());
  }
}

/// Creates a file that did not exist; a symbolic link planted under the name is not followed.
int create_exclusive(const std::filesystem::path& target, std::filesystem::path& temporary) {
  for (int attempt = 0; attempt < 100; ++attempt) {
    temporary = target;
    temporary += temporary_suffix(::getpid(), attempt);
    const int fd = ::open(temporary.c_str(), O_CREAT | O_EXCL | O_NOFOLLOW | O_WRONLY | O_CLOEXEC, 0666);
    if (fd >= 0 || errno != EEXIST) return fd;
  }
  return -1;
}

}  // namespace

AtomicFile::AtomicFile(std::filesystem::path path, bool binary) : path_(std::move(path)) {
  std::error_code ignored;
  // A device (/dev/stdout, /dev/null) cannot be replaced by a rename: it is written to directly.
  const bool device = std::filesystem::exists(path_, ignored) && std::filesystem::is_other(path_, ignored);
  if (std::filesystem::is_directory(path_, ignored)) fail(path_, "cannot write", EISDIR);
  if (!device) remove_leftovers(path_);
  const int fd = device ? ::open(path_.c_str(), O_WRONLY | O_CLOEXEC) : create_exclusive(path_, temporary_);
  if (fd < 0) {
    const int error = errno;
    temporary_.clear();
    fail(path_, "cannot create", error);
  }
  file_ = ::fdopen(fd, binary ? "wb" : "w");
}

AtomicFile::~AtomicFile() {
  if (file_ != nullptr) {
    std::fclose(file_);
    if (!temporary_.empty()) ::unlink(temporary_.c_str());
  }
}

void AtomicFile::write(std::string_view text) {
  if (std::fwrite(text.data(), 1, text.size(), file_) != text.size()) give_up("cannot write");
  written_ += text.size();
}

void AtomicFile::patch(std::uint64_t offset, std::string_view text) {
  if (offset + text.size() > written_) {
    throw DataError(fmt::format("{}: patch of {} bytes at {} reaches past the {} bytes written", path_.string(),
                                text.size(), offset, written_));
  }
  if (std::fseek(file_, static_cast<long>(offset), SEEK_SET) != 0) give_up("cannot seek");
  if (std::fwrite(text.data(), 1, text.size(), file_) != text.size()) give_up("cannot write");
  if (std::fseek(file_, 0, SEEK_END) != 0) give_up("cannot seek");
}

void AtomicFile::give_up(const char* what) {
  error_ = error_ != 0 ? error_ : errno;
  fail(path_, what, error_);
}

void AtomicFile::close() { close(false); }

void AtomicFile::close_durably() { close(true); }

void AtomicFile::close(bool durably) {
  if (file_ == nullptr) return;
  // Delayed write errors surface in either call.
  const bool flushed = std::fflush(file_) == 0;
  int error = error_ != 0 ? error_ : flushed ? 0 : errno;
  // A device has nothing to be brought to a disk. After a loss of power, a renamed file may be there without its
  // content.
  if (durably && flushed && !temporary_.empty() && ::fsync(::fileno(file_)) != 0) error = errno;
  if (std::fclose(file_) != 0 && error == 0) error = errno;
  file_ = nullptr;
  if (error == 0 && !temporary_.empty() && ::rename(temporary_.c_str(), path_.c_str()) != 0) error = errno;
  if (error != 0) {
    if (!temporary_.empty()) ::unlink(temporary_.c_str());
    fail(path_, "cannot write", error);
  }
}

}  // namespace aslio::io
