/// The picture shows the room and the path where they are.

#include <png.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <fstream>
#include <sstream>

#include "recorded.hpp"

using namespace aslio;
using namespace aslio::simulator;
using Catch::Matchers::Contains;
using simulator::test::Recorded;

namespace {

std::string decoded(const std::string& base64) {
  const std::string digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string bytes;
  std::uint32_t group = 0;
  int bits = 0;
  for (const char c : base64) {
    if (c == '=') break;
    group = group << 6U | static_cast<std::uint32_t>(digits.find(c));
    bits += 6;
    if (bits < 8) continue;
    bits -= 8;
    bytes += static_cast<char>(group >> bits & 255U);
  }
  return bytes;
}

/// What stands between two texts.
std::string between(const std::string& text, const std::string& before, const std::string& after) {
  const std::size_t at = text.find(before);
  REQUIRE(at != std::string::npos);
  const std::size_t begin = at + before.size(), end = text.find(after, begin);
  REQUIRE(end != std::string::npos);
  return text.substr(begin, end - begin);
}

struct Picture {
  std::size_t width = 0, height = 0;
  std::vector<png_byte> grey;
};

Picture picture(const std::string& png) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  REQUIRE(png_image_begin_read_from_memory(&image, png.data(), png.size()) != 0);
  image.format = PNG_FORMAT_GRAY;
  Picture out{image.width, image.height, std::vector<png_byte>(PNG_IMAGE_SIZE(image))};
  REQUIRE(png_image_finish_read(&image, nullptr, out.grey.data(), 0, nullptr) != 0);
  return out;
}

}  // namespace

TEST_CASE("a preview shows the walls round the path to scale", "[record]") {
  const Recorded recorded;
  std::ifstream file(recorded / "preview.svg");
  std::ostringstream text;
  text << file.rdbuf();
  const std::string svg = text.str();
  CHECK_THAT(svg, Contains("quick: ") && Contains(">start<") && Contains(" m</text>"));
  const Picture p = picture(decoded(between(svg, "base64,", "\"")));
  // A room of 16 m x 10 m, all of whose walls are seen.
  CHECK(static_cast<double>(p.width) / static_cast<double>(p.height) == Approx(1.6).epsilon(0.03));
  std::size_t dark_inside = 0, dark_border = 0;
  for (std::size_t row = 0; row < p.height; ++row) {
    for (std::size_t column = 0; column < p.width; ++column) {
      const bool border = row < 3 || column < 3 || row + 3 >= p.height || column + 3 >= p.width;
      if (p.grey[row * p.width + column] < 180) ++(border ? dark_border : dark_inside);
    }
  }
  CHECK(dark_border > p.width);
  CHECK(dark_inside == 0);
  const std::string bar = between(svg, "<path ", " m</text>");
  const double pixels = std::stod(between(bar, "v6h", "v-6")), metres = std::stod(bar.substr(bar.rfind('>') + 1));
  const double shown_width = std::stod(between(between(svg, "<image ", "href"), "width=\"", "\""));
  CHECK(pixels / metres == Approx(shown_width / 16).epsilon(0.02));
}
