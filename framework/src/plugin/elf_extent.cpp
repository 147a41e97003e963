#include "elf_extent.hpp"

#include <elf.h>
#include <fmt/core.h>
#include <link.h>

#include <cstdint>
#include <cstring>
#include <fstream>
#include <optional>

namespace aslio::plugin {
namespace {

using Header = ElfW(Ehdr);
using Segment = ElfW(Phdr);
using Section = ElfW(Shdr);

/// What the headers of a file say of where its parts end.
class Extents {
 public:
  Extents(std::ifstream& file, std::uint64_t size) : file_(file), size_(size) {}

  /// Empty: all parts are inside the file.
  std::string trouble() {
    Header header{};
    if (!read(0, header)) return {};  // too short for the loader, too
    constexpr unsigned char kClass = sizeof(void*) == 8 ? ELFCLASS64 : ELFCLASS32;
    if (std::memcmp(header.e_ident, ELFMAG, SELFMAG) != 0 || header.e_ident[EI_CLASS] != kClass) return {};
    if (header.e_phnum == 0 || header.e_phentsize != sizeof(Segment)) return "its program headers are damaged";
    if (header.e_shnum != 0 && header.e_shentsize != sizeof(Section)) return "its section headers are damaged";
    demand("program headers", header.e_phoff, std::uint64_t{header.e_phnum} * sizeof(Segment));
    demand("section headers", header.e_shoff, std::uint64_t{header.e_shnum} * sizeof(Section));
    for (std::uint64_t i = 0; trouble_.empty() && i < header.e_phnum; ++i) {
      Segment segment{};
      if (!read(header.e_phoff + i * sizeof(Segment), segment)) return "its program headers cannot be read";
      if (segment.p_type != PT_NULL) demand("segments", segment.p_offset, segment.p_filesz);
    }
    for (std::uint64_t i = 0; trouble_.empty() && i < header.e_shnum; ++i) {
      Section section{};
      if (!read(header.e_shoff + i * sizeof(Section), section)) return "its section headers cannot be read";
      if (section.sh_type != SHT_NULL && section.sh_type != SHT_NOBITS) {
        demand("sections", section.sh_offset, section.sh_size);
      }
    }
    return trouble_;
  }

 private:
  template <class T>
  bool read(std::uint64_t offset, T& to) {
    if (offset > size_ || sizeof(T) > size_ - offset) return false;
    file_.seekg(static_cast<std::streamoff>(offset));
    char bytes[sizeof(T)];
    if (!file_.read(bytes, sizeof(T))) return false;
    std::memcpy(&to, bytes, sizeof(T));
    return true;
  }

  void demand(const char* what, std::uint64_t offset, std::uint64_t length) {
    if (!trouble_.empty() || (offset <= size_ && length <= size_ - offset)) return;
    trouble_ = fmt::format("its {} reach beyond its end, {} bytes: it was cut short", what, size_);
  }

  std::ifstream& file_;
  std::uint64_t size_;
  std::string trouble_;
};

}  // namespace

std::string why_cut_short(const std::filesystem::path& file) {
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(file, error);
  std::ifstream stream(file, std::ios::binary);
  if (error || !stream) return {};
  return Extents(stream, size).trouble();
}

}  // namespace aslio::plugin
