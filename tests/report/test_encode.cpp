/// Thinning, packing and escaping: nothing may be lost beyond its bound, and no text may leave its place.

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "aslio/io/markup.hpp"
#include "aslio/report/encode.hpp"
#include "study_fixture.hpp"

using namespace aslio;
using namespace aslio::report;

namespace {

double interpolated(const std::vector<double>& t, const std::vector<double>& v, const std::vector<std::uint32_t>& kept,
                    double at) {
  std::size_t k = 0;
  while (k + 2 < kept.size() && t[kept[k + 1]] <= at) ++k;
  const double begin = t[kept[k]], end = t[kept[k + 1]];
  return v[kept[k]] + (at - begin) / (end - begin) * (v[kept[k + 1]] - v[kept[k]]);
}

/// What the page does with packed_integers().
std::vector<std::int64_t> unpacked(const std::string& text) {
  constexpr std::string_view kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::vector<std::uint8_t> bytes;
  for (std::size_t i = 0; i < text.size(); i += 4) {
    std::uint32_t group = 0;
    for (std::size_t k = 0; k < 4; ++k) {
      const std::size_t digit = kDigits.find(text[i + k]);
      group = group << 6 | static_cast<std::uint32_t>(digit == std::string_view::npos ? 0 : digit);
    }
    const std::size_t count = text[i + 2] == '=' ? 1 : text[i + 3] == '=' ? 2 : 3;
    for (std::size_t k = 0; k < count; ++k) bytes.push_back(static_cast<std::uint8_t>(group >> (16 - 8 * k) & 255U));
  }
  std::vector<std::int64_t> values;
  std::uint64_t value = 0, last = 0;
  unsigned shift = 0;
  for (const std::uint8_t byte : bytes) {
    value |= static_cast<std::uint64_t>(byte & 127U) << shift;
    shift += 7;
    if (byte > 127) continue;
    last += (value >> 1) ^ (~(value & 1) + 1);
    values.push_back(static_cast<std::int64_t>(last));
    value = 0;
    shift = 0;
  }
  return values;
}

}  // namespace

TEST_CASE("what is left out lies within the tolerance of the line between its neighbours") {
  std::vector<double> t, v;
  for (int i = 0; i < 5000; ++i) {
    t.push_back(0.01 * i + 0.003 * std::sin(i));
    v.push_back(std::sin(0.02 * i) + 0.01 * std::sin(1.7 * i) + (i == 2500 ? 3 : 0));
  }
  for (const double tolerance : {0.0, 1e-3, 0.02, 0.2}) {
    const auto kept = decimated(t, v, tolerance);
    CAPTURE(tolerance, kept.size());
    REQUIRE(kept.front() == 0);
    REQUIRE(kept.back() == 4999);
    double worst = 0;
    for (std::size_t i = 0; i < t.size(); ++i) worst = std::max(worst, std::abs(interpolated(t, v, kept, t[i]) - v[i]));
    CHECK(worst <= tolerance + 1e-12);
  }
  CHECK(decimated(t, v, 0.02).size() < 1000);
}

TEST_CASE("a straight line needs its ends, and a sample none but itself") {
  const std::vector<double> t = {0, 1, 2, 3, 4}, v = {1, 3, 5, 7, 9};
  CHECK(decimated(t, v, 1e-9) == std::vector<std::uint32_t>{0, 4});
  CHECK(decimated(std::span(t).first(1), std::span(v).first(1), 1) == std::vector<std::uint32_t>{0});
  CHECK(decimated({}, {}, 1).empty());
}

TEST_CASE("positions in space stay within the distance") {
  std::vector<double> t, x, y, z;
  for (int i = 0; i < 2000; ++i) {
    t.push_back(0.05 * i);
    x.push_back(5 * std::cos(0.01 * i));
    y.push_back(5 * std::sin(0.01 * i));
    z.push_back(0.1 * std::sin(0.1 * i));
  }
  const auto kept = decimated(t, x, y, z, 0.005);
  CHECK(kept.size() < 700);
  for (std::size_t i = 0; i < t.size(); ++i) {
    const double dx = interpolated(t, x, kept, t[i]) - x[i], dy = interpolated(t, y, kept, t[i]) - y[i];
    REQUIRE(std::hypot(dx, dy, interpolated(t, z, kept, t[i]) - z[i]) <= 0.005 + 1e-12);
  }
}

TEST_CASE("base64 is that of RFC 4648") {
  const auto encoded = [](std::string_view text) {
    return io::base64(std::vector<std::uint8_t>(text.begin(), text.end()));
  };
  CHECK(encoded("") == "");
  CHECK(encoded("f") == "Zg==");
  CHECK(encoded("fo") == "Zm8=");
  CHECK(encoded("foo") == "Zm9v");
  CHECK(encoded("foobar") == "Zm9vYmFy");
}

TEST_CASE("packed integers read back, the extremes included") {
  const std::vector<std::int64_t> values = {0,
                                            1,
                                            -1,
                                            63,
                                            -64,
                                            64,
                                            1'000'000'007,
                                            -5,
                                            4'000'000'000'000'000,
                                            -4'000'000'000'000'000,
                                            std::numeric_limits<std::int64_t>::max(),
                                            std::numeric_limits<std::int64_t>::min()};
  CHECK(unpacked(packed_integers(values)) == values);
  CHECK(unpacked(packed_numbers(std::vector<double>{0.1004, -2.3, 1e30}, 1e-3)) ==
        std::vector<std::int64_t>{100, -2300, 4'000'000'000'000'000});
}

TEST_CASE("what is no number is packed as 0, and what is too large as the largest") {
  const double none = std::nan(""), all = std::numeric_limits<double>::infinity();
  CHECK(packed_numbers(std::vector<double>{none, all, -all, 2}, 0.5) ==
        packed_integers(std::vector<std::int64_t>{0, 4'000'000'000'000'000, -4'000'000'000'000'000, 4}));
}

TEST_CASE("JSON in a script can neither end it nor begin a comment") {
  const nlohmann::ordered_json json = {{"name", aslio::test::kHostileText}};
  const std::string text = script_safe(json);
  CHECK(text.find_first_of("<>&") == std::string::npos);
  for (const char c : text) REQUIRE((c >= ' ' && c <= '~'));
  CHECK(text.find("\\u2028") != std::string::npos);
  const auto back = nlohmann::ordered_json::parse(text);
  CHECK(back["name"].get<std::string>().starts_with("</script><script>fail()"));
  CHECK(back["name"].get<std::string>().find("\xef\xbf\xbd end") != std::string::npos);
}

TEST_CASE("texts keep their place in HTML, LaTeX and Markdown") {
  CHECK(io::html_escaped("<a href=\"x\" b='y'>&") == "&lt;a href=&quot;x&quot; b=&#39;y&#39;&gt;&amp;");
  CHECK(latex_escaped("50 % of a_b #1 {x} \\input~^$&") ==
        "50 \\% of a\\_b \\#1 \\{x\\} \\textbackslash{}input\\textasciitilde{}\\textasciicircum{}\\$\\&");
  CHECK(markdown_cell("a|b\n<c>*") == "a\\|b &lt;c&gt;\\*");
}
