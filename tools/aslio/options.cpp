#include "options.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <numeric>
#include <system_error>
#include <utility>

#include "console.hpp"
#include "data_folder.hpp"

namespace aslio::cli {

namespace {

constexpr double kMaxSeconds = 1e9;  // some 30 years; in nanoseconds it still fits

template <class T>
std::errc parse(const std::string& text, T& value) {
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  return error == std::errc() && stop != end ? std::errc::invalid_argument : error;
}

std::string check_seconds(const std::string& text, bool positive) {
  double value = 0;
  const std::errc error = parse(text, value);
  if (error == std::errc::invalid_argument) return fmt::format("'{}' is not a number", printable(text));
  if (error == std::errc() && !std::isfinite(value)) return fmt::format("'{}' is not a finite number", text);
  if (value < 0 || (positive && value == 0 && error == std::errc())) {
    return fmt::format("'{}' is {}; give seconds {} 0", text, value < 0 ? "negative" : "no duration",
                       positive ? "above" : "from");
  }
  if (error != std::errc() || value > kMaxSeconds) {
    return fmt::format("'{}' is out of range; give at most {:.0e} seconds", text, kMaxSeconds);
  }
  return {};
}

std::string check_whole(const std::string& text, std::uint64_t min, std::uint64_t max) {
  std::uint64_t value = 0;
  const std::errc error = parse(text, value);
  const std::string range = fmt::format("give a whole number from {} to {}", min, max);
  if (error == std::errc::invalid_argument) {
    double number = 0;
    const bool is_number = parse(text, number) == std::errc();
    const char* what = !is_number ? "not a number" : number < 0 ? "negative" : "not a whole number";
    return fmt::format("'{}' is {}; {}", printable(text), what, range);
  }
  if (error != std::errc() || value < min || value > max) return fmt::format("'{}' is out of range; {}", text, range);
  return {};
}

std::string check_number(const std::string& text, double min, double max) {
  double value = 0;
  const std::errc error = parse(text, value);
  if (error == std::errc::invalid_argument) return fmt::format("'{}' is not a number", printable(text));
  if (error == std::errc() && value >= min && value <= max) return {};
  return fmt::format("'{}' is out of range; give a number from {:g} to {:g}", text, min, max);
}

std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i + 1;
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i] == b[j] ? 0 : 1);
      diagonal = row[j + 1];
      row[j + 1] = std::min({replaced, row[j] + 1, row[j + 1] + 1});
    }
  }
  return row.back();
}

}  // namespace

CLI::Validator shipped_file(std::string kind) {
  return {[kind = std::move(kind)](std::string& text) {
            namespace fs = std::filesystem;
            std::error_code ignored;
            if (fs::is_regular_file(text, ignored)) return std::string();
            const fs::path folder = data_path("configs/" + kind);
            std::vector<std::string> names;
            for (const auto& entry : fs::directory_iterator(folder)) names.push_back(entry.path().stem());
            std::sort(names.begin(), names.end());
            // By its name, or as it lies in a clone of the project.
            const fs::path asked = text;
            const std::string name = asked.stem().string();
            const bool named = asked == asked.stem() || asked == fs::path("configs") / kind / (name + ".yaml");
            if (named && std::binary_search(names.begin(), names.end(), name)) {
              text = (folder / (name + ".yaml")).string();
              return std::string();
            }
            if (fs::exists(text, ignored)) return fmt::format("{}: not a file", text);
            const bool known = std::binary_search(names.begin(), names.end(), name);
            const std::string near = known ? name : nearest_name(name, names);
            return fmt::format(
                "{}: no such file{}; {} in {}: {}", text,
                near.empty() ? "" : fmt::format(" (did you mean {}?)", (folder / (near + ".yaml")).string()), kind,
                folder.string(), fmt::join(names, ", "));
          },
          ""};
}

std::string unknown_options(const CLI::App& app, const std::vector<std::string>& extras) {
  std::vector<std::string> names;
  for (const CLI::Option* option : app.get_options()) {
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  }
  std::string text;
  for (const std::string& word : extras) {
    if (!text.empty()) text += "; ";
    const std::string name = word.substr(0, word.find('='));
    const std::string near = name.starts_with("--") ? nearest_name(name, names) : "";
    text += fmt::format("unknown {} '{}'{}", word.starts_with('-') ? "option" : "argument", printable(word),
                        near.empty() ? "" : fmt::format(" (did you mean '{}'?)", near));
  }
  return fmt::format("{}; `aslio {} --help` shows what there is", text, app.get_name());
}

CLI::Validator seconds(bool positive) {
  return {[positive](std::string& text) { return check_seconds(text, positive); }, ""};
}

CLI::Validator number(double min, double max) {
  return {[min, max](std::string& text) { return check_number(text, min, max); }, ""};
}

CLI::Validator one_of(std::string_view what, std::vector<std::string> names) {
  return {[what = std::string(what), names = std::move(names)](std::string& text) {
            if (std::find(names.begin(), names.end(), text) != names.end()) return std::string();
            const std::string near = nearest_name(text, names);
            return fmt::format("unknown {} '{}'{}; there are: {}", what, printable(text),
                               near.empty() ? "" : fmt::format(" (did you mean '{}'?)", near), fmt::join(names, ", "));
          },
          ""};
}

CLI::Validator whole_number(std::uint64_t min, std::uint64_t max) {
  return {[min, max](std::string& text) { return check_whole(text, min, max); }, ""};
}

std::string nearest_name(std::string_view wrong, const std::vector<std::string>& names) {
  std::string best;
  std::size_t least = 3;
  for (const std::string& name : names) {
    if (const std::size_t distance = edit_distance(wrong, name); distance < least) {
      least = distance;
      best = name;
    }
  }
  return best;
}

}  // namespace aslio::cli
