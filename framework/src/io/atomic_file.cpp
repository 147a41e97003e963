#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <system_error>

#include "aslio/core/errors.hpp"
#include "aslio/io/writers.hpp"

namespace aslio::io {
namespace {

constexpr std::size_t kBufferBytes = 1 << 18;

[[noreturn]] void fail(const std::filesystem::path& path, std::string_view what, int error) {
  const char* remedy = error == ENOSPC   ? "free space on that disk or choose another output folder"
                       : error == EACCES ? "choose an output folder you may write to"
                       : error == ENOENT ? "create the folder first"
                                         : "check the disk and the output path";
  throw DataError(fmt::format("{}: {}: {}; {}", path.string(), what, std::strerror(error), remedy));
}

/// Creates a file that did not exist; a symbolic link planted under the name is not followed.
int create_exclusive(const std::filesystem::path& target, std::filesystem::path& temporary) {
  for (int attempt = 0; attempt < 100; ++attempt) {
    temporary = target;
    temporary += fmt::format(".{}-{}.part", ::getpid(), attempt);
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
  const int fd = device ? ::open(path_.c_str(), O_WRONLY | O_CLOEXEC) : create_exclusive(path_, temporary_);
  if (fd < 0) {
    const int error = errno;
    temporary_.clear();
    fail(path_, "cannot create", error);
  }
  file_ = ::fdopen(fd, binary ? "wb" : "w");
  std::setvbuf(file_, nullptr, _IOFBF, kBufferBytes);
}

AtomicFile::~AtomicFile() {
  if (file_ != nullptr) {
    std::fclose(file_);
    if (!temporary_.empty()) ::unlink(temporary_.c_str());
  }
}

void AtomicFile::write(std::string_view text) {
  if (std::fwrite(text.data(), 1, text.size(), file_) != text.size()) fail(path_, "cannot write", errno);
  written_ += text.size();
}

void AtomicFile::patch(std::uint64_t offset, std::string_view text) {
  if (offset + text.size() > written_) {
    throw DataError(fmt::format("{}: patch of {} bytes at {} reaches past the {} bytes written", path_.string(),
                                text.size(), offset, written_));
  }
  if (std::fseek(file_, static_cast<long>(offset), SEEK_SET) != 0) fail(path_, "cannot seek", errno);
  if (std::fwrite(text.data(), 1, text.size(), file_) != text.size()) fail(path_, "cannot write", errno);
  if (std::fseek(file_, 0, SEEK_END) != 0) fail(path_, "cannot seek", errno);
}

void AtomicFile::close() { close(false); }

void AtomicFile::close_durably() { close(true); }

void AtomicFile::close(bool durably) {
  if (file_ == nullptr) return;
  // Delayed write errors surface in either call.
  const bool flushed = std::fflush(file_) == 0;
  int error = flushed ? 0 : errno;
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
