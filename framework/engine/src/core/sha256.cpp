#include "aslio/core/sha256.hpp"

#include <openssl/evp.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <vector>

#include "aslio/core/errors.hpp"
#include "aslio/core/input_file.hpp"

namespace aslio {

namespace {
constexpr std::uint64_t kLargestDigested = std::uint64_t{1} << 42U;
}

struct Sha256::Context {
  std::unique_ptr<EVP_MD_CTX, decltype(&EVP_MD_CTX_free)> evp{EVP_MD_CTX_new(), &EVP_MD_CTX_free};
};

Sha256::Sha256() : context_(std::make_unique<Context>()) {
  if (!context_->evp || EVP_DigestInit_ex(context_->evp.get(), EVP_sha256(), nullptr) != 1) {
    throw DataError("OpenSSL offers no SHA-256 here");
  }
}

Sha256::~Sha256() = default;

void Sha256::add(const void* data, std::size_t size) {
  if (EVP_DigestUpdate(context_->evp.get(), data, size) != 1) throw DataError("OpenSSL failed in SHA-256");
}

std::string Sha256::hex() {
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
  unsigned size = 0;
  if (EVP_DigestFinal_ex(context_->evp.get(), digest.data(), &size) != 1) {
    throw DataError("OpenSSL failed in SHA-256");
  }
  constexpr std::string_view kHex = "0123456789abcdef";
  std::string text;
  for (unsigned i = 0; i < size; ++i) text += {kHex[digest[i] >> 4U], kHex[digest[i] & 15U]};
  return text;
}

std::string sha256_of(std::string_view bytes) {
  Sha256 digest;
  digest.add(bytes.data(), bytes.size());
  return digest.hex();
}

std::string sha256_of_file(const std::filesystem::path& path) {
  require_input(path, kLargestDigested);
  errno = 0;
  std::ifstream file(path, std::ios::binary);
  std::vector<char> block(1U << 16U);
  Sha256 digest;
  while (file) {
    file.read(block.data(), static_cast<std::streamsize>(block.size()));
    digest.add(block.data(), static_cast<std::size_t>(file.gcount()));
  }
  // A file that ended has failed to fill the last block; anything else is a failure to read.
  if (!file.eof()) throw DataError(path.string() + ": cannot be read: " + std::strerror(errno));
  return digest.hex();
}

}  // namespace aslio
