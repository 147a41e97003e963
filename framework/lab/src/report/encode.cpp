#include "aslio/report/encode.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "aslio/io/markup.hpp"

namespace aslio::report {

namespace {

/// Range of slopes of the lines from a sample that pass all later ones within the tolerance.
struct Cone {
  double low = -std::numeric_limits<double>::infinity(), high = std::numeric_limits<double>::infinity();

  bool holds(double slope) const { return low <= slope && slope <= high; }
  void narrow(double dt, double difference, double tolerance) {
    low = std::max(low, (difference - tolerance) / dt);
    high = std::min(high, (difference + tolerance) / dt);
  }
};

/// From each sample that is kept, as far as one straight line serves all between: a line may end at a sample when its
/// slope to that sample lies in the cones of all before. Per coordinate, so in space within a box.
std::vector<std::uint32_t> cones(std::span<const double> t, std::span<const std::span<const double>> values,
                                 double tolerance) {
  std::vector<std::uint32_t> kept;
  if (t.empty()) return kept;
  kept.push_back(0);
  std::vector<Cone> open(values.size());
  std::size_t from = 0;
  for (std::size_t i = 1; i < t.size(); ++i) {
    const auto fits = [&](std::size_t k) {
      const double slope = (values[k][i] - values[k][from]) / (t[i] - t[from]);
      return open[k].holds(slope);
    };
    bool all = true;
    for (std::size_t k = 0; k < values.size() && all; ++k) all = fits(k);
    if (!all) {
      from = i - 1;
      kept.push_back(static_cast<std::uint32_t>(from));
      open.assign(values.size(), Cone{});
    }
    for (std::size_t k = 0; k < values.size(); ++k) {
      open[k].narrow(t[i] - t[from], values[k][i] - values[k][from], tolerance);
    }
  }
  if (kept.back() + 1 != t.size()) kept.push_back(static_cast<std::uint32_t>(t.size() - 1));
  return kept;
}

}  // namespace

std::vector<std::uint32_t> decimated(std::span<const double> t, std::span<const double> values, double tolerance) {
  const std::array<std::span<const double>, 1> all = {values};
  return cones(t, all, tolerance);
}

std::vector<std::uint32_t> decimated(std::span<const double> t, std::span<const double> x, std::span<const double> y,
                                     std::span<const double> z, double tolerance) {
  const std::array<std::span<const double>, 3> all = {x, y, z};
  return cones(t, all, tolerance / std::sqrt(3.0));
}

std::string packed_integers(std::span<const std::int64_t> values) {
  std::vector<std::uint8_t> bytes;
  bytes.reserve(2 * values.size());
  std::int64_t last = 0;
  for (const std::int64_t value : values) {
    const auto difference = static_cast<std::uint64_t>(value) - static_cast<std::uint64_t>(last);
    last = value;
    std::uint64_t left = difference << 1 ^ (difference >> 63 != 0 ? ~std::uint64_t{0} : 0);
    for (; left > 127; left >>= 7) bytes.push_back(static_cast<std::uint8_t>(left | 128U));
    bytes.push_back(static_cast<std::uint8_t>(left));
  }
  return io::base64(bytes);
}

std::string packed_numbers(std::span<const double> values, double unit) {
  constexpr double kLargest = 4e15;  // what the page's numbers still hold exactly
  std::vector<std::int64_t> integers;
  integers.reserve(values.size());
  for (const double value : values) {
    const double scaled = std::round(value / unit);
    integers.push_back(std::isnan(scaled) ? 0 : static_cast<std::int64_t>(std::clamp(scaled, -kLargest, kLargest)));
  }
  return packed_integers(integers);
}

std::string script_safe(const nlohmann::ordered_json& json) {
  const std::string text = json.dump(-1, ' ', true, nlohmann::ordered_json::error_handler_t::replace);
  std::string out;
  out.reserve(text.size());
  for (const char c : text) {
    // Outside strings JSON has none of these.
    if (c == '<' || c == '>' || c == '&') {
      out += fmt::format("\\u{:04x}", static_cast<unsigned>(c));
    } else {
      out += c;
    }
  }
  return out;
}

std::string latex_escaped(std::string_view text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '\\':
        out += "\\textbackslash{}";
        break;
      case '~':
        out += "\\textasciitilde{}";
        break;
      case '^':
        out += "\\textasciicircum{}";
        break;
      case '#':
      case '$':
      case '%':
      case '&':
      case '_':
      case '{':
      case '}':
        out += '\\';
        [[fallthrough]];
      default:
        out += c == '\n' ? ' ' : c;
    }
  }
  return out;
}

std::string markdown_cell(std::string_view text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '|':
      case '\\':
      case '*':
      case '`':
      case '[':
      case ']':
        out += '\\';
        out += c;
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '&':
        out += "&amp;";
        break;
      case '\n':
      case '\r':
        out += ' ';
        break;
      default:
        out += c;
    }
  }
  return out;
}

}  // namespace aslio::report
