#include "aslio/io/markup.hpp"

#include <openssl/evp.h>

#include <algorithm>
#include <vector>

namespace aslio::io {

std::string base64(std::span<const std::uint8_t> bytes) {
  constexpr std::size_t kGroup = 3, kDigits = 4;
  constexpr std::size_t kPart = kGroup << 20U;                                          // OpenSSL counts in int
  std::vector<unsigned char> text((bytes.size() + kGroup - 1) / kGroup * kDigits + 1);  // and ends with a zero
  for (std::size_t i = 0; i < bytes.size(); i += kPart) {
    const auto part = bytes.subspan(i, std::min(kPart, bytes.size() - i));
    EVP_EncodeBlock(text.data() + i / kGroup * kDigits, part.data(), static_cast<int>(part.size()));
  }
  return {text.begin(), text.end() - 1};
}

std::string html_escaped(std::string_view text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      case '\'':
        out += "&#39;";
        break;
      case '\0':
        break;
      default:
        out += c;
    }
  }
  return out;
}

}  // namespace aslio::io
