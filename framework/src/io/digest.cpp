#include <fmt/format.h>
#include <openssl/evp.h>

#include <algorithm>
#include <array>
#include <memory>
#include <vector>

#include "aslio/core/errors.hpp"
#include "aslio/io/source.hpp"
#include "rosbag/byte_view.hpp"

namespace aslio::io {
namespace {

namespace fs = std::filesystem;

class Sha256 {
 public:
  Sha256() : context_(EVP_MD_CTX_new(), &EVP_MD_CTX_free) {
    if (!context_ || EVP_DigestInit_ex(context_.get(), EVP_sha256(), nullptr) != 1)
      throw DataError("SHA-256 is missing");
  }
  void add(const void* data, std::size_t size) { EVP_DigestUpdate(context_.get(), data, size); }
  void add_file(const fs::path& path) {
    const rosbag::InputFile file(path);
    std::vector<std::uint8_t> block(std::min<std::uint64_t>(file.size(), 1U << 20U));
    for (std::uint64_t at = 0; at < file.size(); at += block.size()) {
      const auto part =
          std::span(block).first(static_cast<std::size_t>(std::min<std::uint64_t>(block.size(), file.size() - at)));
      file.read(at, part);
      add(part.data(), part.size());
    }
  }
  std::string hex() {
    std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
    unsigned size = 0;
    EVP_DigestFinal_ex(context_.get(), digest.data(), &size);
    std::string text;
    for (unsigned i = 0; i < size; ++i) text += fmt::format("{:02x}", digest[i]);
    return text;
  }

 private:
  std::unique_ptr<EVP_MD_CTX, decltype(&EVP_MD_CTX_free)> context_;
};

}  // namespace

std::string input_digest(const fs::path& path) {
  std::error_code error;
  Sha256 digest;
  if (!fs::is_directory(path, error)) {
    digest.add_file(path);
    return digest.hex();
  }
  std::vector<std::string> names;
  for (const auto& entry : fs::recursive_directory_iterator(path)) {
    if (entry.is_regular_file()) names.push_back(entry.path().lexically_relative(path).generic_string());
  }
  std::sort(names.begin(), names.end());
  for (const std::string& name : names) {
    // The length separates a name from the content that follows.
    const std::string head = fmt::format("{}\n{}\n", name, fs::file_size(path / name));
    digest.add(head.data(), head.size());
    digest.add_file(path / name);
  }
  return digest.hex();
}

}  // namespace aslio::io
