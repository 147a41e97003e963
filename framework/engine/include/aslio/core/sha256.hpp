#pragma once
/// SHA-256 of what a run has used, for its manifest.

#include <cstddef>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

namespace aslio {

/// Digest of bytes that come in parts.
class Sha256 {
 public:
  /// Throws DataError when the cryptographic library offers no SHA-256.
  Sha256();
  ~Sha256();
  Sha256(const Sha256&) = delete;
  Sha256& operator=(const Sha256&) = delete;

  void add(const void* data, std::size_t size);
  /// 64 lower-case hexadecimal digits. Call once, last.
  std::string hex();

 private:
  struct Context;
  std::unique_ptr<Context> context_;
};

std::string sha256_of(std::string_view bytes);
/// Of a file's content. Throws DataError naming the file when it cannot be read.
std::string sha256_of_file(const std::filesystem::path& path);

}  // namespace aslio
