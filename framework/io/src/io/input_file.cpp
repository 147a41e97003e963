#include "input_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "aslio/core/errors.hpp"

namespace aslio::io {

InputFile::InputFile(std::filesystem::path path) : path_(std::move(path)) {
  const auto require_regular = [this](mode_t mode) {
    if (S_ISREG(mode)) return;
    throw DataError(fmt::format("{}: is a {}, not a regular file: copy the recording to a file", path_.string(),
                                S_ISDIR(mode) ? "folder" : "pipe or device"));
  };
  struct stat info {};
  // Before opening: a pipe would wait for its writer, and a device may act on being opened.
  if (::stat(path_.c_str(), &info) == 0) require_regular(info.st_mode);
  fd_ = ::open(path_.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (fd_ < 0 || ::fstat(fd_, &info) != 0) {
    const int error = errno;
    if (fd_ >= 0) ::close(fd_);
    throw DataError(fmt::format("{}: cannot open: {}", path_.string(), std::strerror(error)));
  }
  if (!S_ISREG(info.st_mode)) ::close(fd_);
  require_regular(info.st_mode);
  size_ = static_cast<std::uint64_t>(info.st_size);
}

InputFile::~InputFile() { ::close(fd_); }

void InputFile::read(std::uint64_t offset, std::span<std::uint8_t> to) const {
  std::size_t done = 0;
  while (done < to.size()) {
    const ssize_t got = ::pread(fd_, to.data() + done, to.size() - done, static_cast<off_t>(offset + done));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) {
      throw DataError(fmt::format("{}: cannot read at offset {}: {}", path_.string(), offset + done,
                                  got < 0 ? std::strerror(errno) : "the file became shorter while it was read"));
    }
    done += static_cast<std::size_t>(got);
  }
}

std::string read_small_file(const std::filesystem::path& path, std::uint64_t most, std::string_view what) {
  const InputFile file(path);
  if (file.size() > most) {
    throw DataError(
        fmt::format("{}: {} bytes are too many for {} (at most {})", path.string(), file.size(), what, most));
  }
  std::string text(static_cast<std::size_t>(file.size()), '\0');
  file.read(0, {reinterpret_cast<std::uint8_t*>(text.data()), text.size()});
  return text;
}

const std::uint8_t* ByteView::at(std::uint64_t offset, std::size_t count) {
  if (memory_ != nullptr) return memory_ + offset;
  if (offset < window_begin_ || offset + count > window_end_) {
    constexpr std::size_t kWindow = 64 * 1024;
    const std::uint64_t want = std::max<std::uint64_t>(count, kWindow);
    const std::size_t length = static_cast<std::size_t>(std::min(want, size_ - offset));
    if (window_.size() < length) window_.resize(length);
    window_begin_ = window_end_ = offset;
    file_->read(offset, std::span(window_).first(length));
    window_end_ = offset + length;
  }
  return window_.data() + (offset - window_begin_);
}

}  // namespace aslio::io
