#include "plugin_file.hpp"

#include <elf.h>
#include <fmt/core.h>
#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <optional>

#include "aslio/core/errors.hpp"

namespace aslio::plugin {
namespace {

namespace fs = std::filesystem;

/// Why somebody besides its owner and group could have put the file there; empty: nobody could. Throws for what is no
/// regular file.
std::string why_untrusted(const fs::path& real, const fs::path& file) {
  const struct stat status = plugin_file_status(real, file);
  if (!S_ISREG(status.st_mode)) refuse_plugin(file, "is not a regular file");
  if ((status.st_mode & S_IWOTH) != 0) return "can be written by anybody: chmod o-w it";
  bool nearest = true;
  for (fs::path directory = real.parent_path();; directory = directory.parent_path()) {
    const mode_t mode = plugin_file_status(directory, file).st_mode;
    // In a directory with the sticky bit nobody can replace the entries of others: enough for all but the file's own.
    if ((mode & S_IWOTH) != 0 && (nearest || (mode & S_ISVTX) == 0)) {
      return fmt::format("its directory {} can be written by anybody: move the plugin elsewhere", directory.string());
    }
    nearest = false;
    if (directory == directory.parent_path()) return {};
  }
}

template <class T>
std::optional<T> read_at(std::ifstream& stream, std::uint64_t offset, std::uint64_t size) {
  T value;
  if (offset > size || size - offset < sizeof(T)) return std::nullopt;
  stream.seekg(static_cast<std::streamoff>(offset));
  stream.read(reinterpret_cast<char*>(&value), sizeof(T));
  return stream ? std::optional(value) : std::nullopt;
}

/// Does [offset, offset + bytes) lie within a file of `size` bytes?
bool within(std::uint64_t offset, std::uint64_t bytes, std::uint64_t size) {
  return offset <= size && bytes <= size - offset;
}

/// The loader maps what the headers name, whether or not the file has it: a page behind the end of a file that was cut
/// short is a bus error. False for such a file.
bool is_whole(const fs::path& real, std::uint64_t size) {
  std::ifstream stream(real, std::ios::binary);
  const auto header = read_at<Elf64_Ehdr>(stream, 0, size);
  const auto own = __BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__ ? ELFDATA2LSB : ELFDATA2MSB;
  if (!header || std::memcmp(header->e_ident, ELFMAG, SELFMAG) != 0 || header->e_ident[EI_CLASS] != ELFCLASS64 ||
      header->e_ident[EI_DATA] != own || header->e_phentsize != sizeof(Elf64_Phdr)) {
    return true;  // the loader refuses it
  }
  // Counts and sizes of entries have 16 bits each.
  if (!within(header->e_shoff, std::uint64_t{header->e_shnum} * header->e_shentsize, size)) return false;
  for (std::uint64_t i = 0; i < header->e_phnum; ++i) {
    const std::uint64_t at = i * sizeof(Elf64_Phdr);
    if (!within(header->e_phoff, at, size)) return false;
    const auto segment = read_at<Elf64_Phdr>(stream, header->e_phoff + at, size);
    if (!segment) return false;
    const bool mapped = segment->p_type == PT_LOAD || segment->p_type == PT_DYNAMIC;
    if (mapped && !within(segment->p_offset, segment->p_filesz, size)) return false;
  }
  return true;
}

}  // namespace

void refuse_plugin(const fs::path& file, const std::string& reason) {
  throw ConfigError(fmt::format("plugin {}: {}", file.string(), reason));
}

struct stat plugin_file_status(const fs::path& path, const fs::path& file) {
  struct stat status {};
  if (stat(path.c_str(), &status) != 0) refuse_plugin(file, fmt::format("{}: {}", path.string(), std::strerror(errno)));
  return status;
}

CheckedPlugin check_plugin_file(const fs::path& file, WritablePlugins writable) {
  std::error_code error;
  CheckedPlugin checked{fs::canonical(file, error), {}};
  if (error) refuse_plugin(file, fmt::format("cannot be found: {}", error.message()));
  if (const std::string why = why_untrusted(checked.path, file); !why.empty()) {
    if (writable == WritablePlugins::refused) {
      refuse_plugin(file, fmt::format("{}. Where rights cannot be set (a Windows drive under WSL, a shared folder of a "
                                      "virtual machine, some containers), {}=1 allows it for --plugin",
                                      why, kAllowWritableVariable));
    }
    checked.warning = fmt::format("plugin {}: {}; loaded, by {}", file.string(), why, kAllowWritableVariable);
  }
  const auto size = static_cast<std::uint64_t>(std::max<off_t>(plugin_file_status(checked.path, file).st_size, 0));
  if (!is_whole(checked.path, size)) {
    refuse_plugin(file, fmt::format("is cut short or damaged: its headers name parts that lie behind its {} bytes; "
                                    "build it again, or copy it again from its origin",
                                    size));
  }
  return checked;
}

}  // namespace aslio::plugin
