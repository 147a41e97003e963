#include "folder_lock.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

#include "aslio/core/errors.hpp"

namespace aslio::experiment {

namespace fs = std::filesystem;

namespace {

/// File systems of clusters may lack flock.
bool has_no_locks(int error) { return error == ENOSYS || error == ENOLCK || error == EOPNOTSUPP; }

}  // namespace

FolderLock::~FolderLock() {
  if (file_ >= 0) ::close(file_);
}

FolderLock::FolderLock(FolderLock&& other) noexcept
    : file_(std::exchange(other.file_, -1)), excludes_(other.excludes_) {}

FolderLock& FolderLock::operator=(FolderLock&& other) noexcept {
  std::swap(file_, other.file_);
  std::swap(excludes_, other.excludes_);
  return *this;
}

std::optional<FolderLock> FolderLock::take(const fs::path& folder, bool exclusive) {
  constexpr int kTries = 10;
  for (int i = 0; i < kTries; ++i) {
    FolderLock lock;
    lock.file_ = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (lock.file_ < 0) {
      if (errno == ENOENT) return std::nullopt;
      throw DataError(fmt::format("{}: cannot be opened: {}", folder.string(), std::strerror(errno)));
    }
    if (!lock.change(exclusive)) {
      if (errno == EWOULDBLOCK || errno == EINTR) return std::nullopt;
      if (has_no_locks(errno)) {
        lock.excludes_ = false;
        return lock;
      }
      throw DataError(fmt::format("{}: cannot be locked: {}; name a folder on a file system with file locks (flock)",
                                  folder.string(), std::strerror(errno)));
    }
    // Who held the lock may have put another folder in its place since it was opened.
    if (lock.is_of(folder)) return lock;
  }
  return std::nullopt;
}

bool FolderLock::is_of(const fs::path& folder) const {
  struct stat locked {
  }, named{};
  return ::fstat(file_, &locked) == 0 && ::stat(folder.c_str(), &named) == 0 && locked.st_dev == named.st_dev &&
         locked.st_ino == named.st_ino;
}

FolderLock FolderLock::of_output(const fs::path& folder, const fs::path& output) {
  constexpr int kTries = 60;
  for (int i = 0; i < kTries; ++i) {
    if (auto lock = take(folder, true)) return std::move(*lock);
    ::poll(nullptr, 0, 50);
  }
  throw ConfigError(
      fmt::format("--output {}: another `aslio experiment` is at work there; wait for it, or name another folder",
                  output.string()));
}

bool FolderLock::is_held(const fs::path& folder, bool exclusive) {
  std::error_code ignored;
  if (!fs::exists(folder, ignored)) return false;
  try {
    return !take(folder, exclusive).has_value();
  } catch (const DataError&) {
    return false;
  }
}

bool FolderLock::change(bool exclusive) const { return ::flock(file_, (exclusive ? LOCK_EX : LOCK_SH) | LOCK_NB) == 0; }

std::string FolderLock::without_locks(const fs::path& folder) {
  return fmt::format("warning: {}: its file system has no file locks; start nothing else there meanwhile",
                     folder.string());
}

}  // namespace aslio::experiment
