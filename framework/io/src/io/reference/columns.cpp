#include "columns.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "aslio/core/errors.hpp"
#include "stamps.hpp"

namespace aslio::io {
namespace {

constexpr std::array<std::string_view, kRoles> kNames = {"t",   "sec", "nsec", "x",   "y",   "z",   "qx",
                                                         "qy",  "qz",  "qw",   "r11", "r12", "r13", "r21",
                                                         "r22", "r23", "r31",  "r32", "r33"};

std::optional<std::size_t> role_of(std::string_view name) {
  const auto found = std::find(kNames.begin(), kNames.end(), name);
  return found == kNames.end() ? std::nullopt : std::optional<std::size_t>(found - kNames.begin());
}

Columns laid_out(std::string_view roles) {
  Columns columns;
  columns.how = roles;
  for (std::string_view left = roles; !left.empty(); ++columns.width) {
    const std::size_t end = std::min(left.find(' '), left.size());
    if (const auto role = role_of(left.substr(0, end))) columns.at[*role] = columns.width;
    left.remove_prefix(std::min(end + 1, left.size()));
  }
  return columns;
}

/// What lacks of a time, a position and the orientation that was begun; empty: nothing.
std::string lacking(const Columns& columns, bool needs_time) {
  if (needs_time && !columns.timed()) return "t, or sec and nsec";
  if (columns.has(Role::sec) != columns.has(Role::nsec)) return columns.has(Role::sec) ? "nsec" : "sec";
  const auto group = [&](Role first, std::size_t count, bool required) -> std::string {
    std::size_t there = 0;
    std::string missing;
    for (std::size_t i = static_cast<std::size_t>(first); i < static_cast<std::size_t>(first) + count; ++i) {
      columns.at[i] ? ++there : (missing.append(missing.empty() ? "" : ", ").append(kNames[i]), 0);
    }
    return there == count || (there == 0 && !required) ? std::string() : missing;
  };
  for (const std::string& missing : {group(Role::x, 3, true), group(Role::qx, 4, false), group(Role::r11, 9, false)}) {
    if (!missing.empty()) return missing;
  }
  return {};
}

/// Words of a name in lower case: `p_RS_R_x [m]` has p, rs, r, x, m; without what stands in brackets.
std::vector<std::string> words_of(std::string_view name) {
  std::vector<std::string> words(1);
  for (const char c : name.substr(0, name.find_first_of("[("))) {
    const char lower = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
    if ((lower >= 'a' && lower <= 'z') || (lower >= '0' && lower <= '9')) {
      words.back() += lower;
    } else if (!words.back().empty()) {
      words.emplace_back();
    }
  }
  if (words.back().empty()) words.pop_back();
  return words;
}

bool any_of(const std::vector<std::string>& words, std::initializer_list<std::string_view> of) {
  return std::any_of(words.begin(), words.end(),
                     [&](const std::string& word) { return std::find(of.begin(), of.end(), word) != of.end(); });
}

/// The role that a name of a header tells, as drivers and data sets write them.
std::optional<Role> told_by(std::string_view name) {
  const std::vector<std::string> words = words_of(name);
  if (words.empty()) return std::nullopt;
  const std::string& last = words.back();
  if (last == "sec" || last == "secs") return Role::sec;
  if (last == "nsec" || last == "nsecs" || last == "nanosec") return Role::nsec;
  if (any_of(words, {"t", "time", "timestamp", "timestamps", "stamp"}) && !any_of({last}, {"x", "y", "z", "w"})) {
    return Role::t;
  }
  const std::string axis =
      last.size() == 2 && std::string_view("tpq").find(last[0]) != std::string_view::npos ? last.substr(1) : last;
  const bool turned = last.starts_with('q') || any_of(words, {"q", "quat", "quaternion", "orientation", "rotation"});
  if (turned && axis.size() == 1) {
    const std::size_t index = std::string_view("xyzw").find(axis[0]);
    if (index != std::string_view::npos) return static_cast<Role>(static_cast<std::size_t>(Role::qx) + index);
  }
  const bool placed = words.size() == 1 || any_of(words, {"p", "pos", "position", "t", "trans", "translation"});
  if (!turned && placed && axis.size() == 1) {
    const std::size_t index = std::string_view("xyz").find(axis[0]);
    if (index != std::string_view::npos) return static_cast<Role>(static_cast<std::size_t>(Role::x) + index);
  }
  return std::nullopt;
}

bool whole(std::string_view cell) { return !cell.empty() && cell.find_first_not_of("0123456789") == std::string::npos; }

/// Stamps of nanoseconds since 1970.
bool like_nanoseconds(std::string_view cell) { return whole(cell) && cell.size() >= 18; }

std::string shown(std::span<const std::string_view> header) {
  return header.empty() ? "the file has no header" : fmt::format("the header has {}", fmt::join(header, ", "));
}

}  // namespace

Columns listed_columns(std::span<const std::string> written, std::span<const std::string_view> header) {
  Columns columns;
  columns.how = fmt::format("{}, as listed", fmt::join(written, " "));
  bool by_name = false;
  for (std::size_t i = 0; i < written.size(); ++i) {
    const std::size_t equal = written[i].find('=');
    const std::string role_name = written[i].substr(0, equal);
    if (role_name == "-") continue;
    const auto role = role_of(role_name);
    if (!role) {
      throw ConfigError(
          fmt::format("columns: '{}' is none of {}, and - for others", role_name, fmt::join(kNames, ", ")));
    }
    std::size_t index = i;
    if (equal != std::string::npos) {
      by_name = true;
      const std::string wanted = written[i].substr(equal + 1);
      const auto found = std::find(header.begin(), header.end(), wanted);
      if (found == header.end()) {
        throw ConfigError(fmt::format("columns: there is no column '{}'; {}", wanted, shown(header)));
      }
      index = static_cast<std::size_t>(found - header.begin());
    }
    if (columns.at[*role]) throw ConfigError(fmt::format("columns: '{}' is listed twice", role_name));
    columns.at[*role] = index;
    if (*role == 0 && index < header.size()) columns.time_name = header[index];
  }
  columns.width = by_name ? header.size() : written.size();
  const std::string missing = lacking(columns, true);
  if (!missing.empty()) throw ConfigError(fmt::format("columns: {} is missing", missing));
  return columns;
}

std::optional<Columns> named_columns(std::span<const std::string_view> header) {
  Columns columns;
  columns.width = header.size();
  columns.how = "by the names of the header";
  for (std::size_t i = 0; i < header.size(); ++i) {
    const auto role = told_by(header[i]);
    if (!role) continue;
    auto& at = columns.at[static_cast<std::size_t>(*role)];
    // The stamp of the measurement goes before that of the recorder (`%time,field.header.stamp`).
    if (at && (role != Role::t || header[i].find("stamp") == std::string_view::npos)) continue;
    at = i;
    if (role == Role::t) columns.time_name = header[i];
  }
  if (columns.has(Role::sec) && !columns.has(Role::nsec) && !columns.has(Role::t)) {  // seconds alone are the stamp
    std::swap(columns.at[static_cast<std::size_t>(Role::t)], columns.at[static_cast<std::size_t>(Role::sec)]);
    columns.time_name = "sec";
  }
  if (columns.has(Role::t) && columns.has(Role::sec) && !columns.has(Role::nsec)) {
    columns.at[static_cast<std::size_t>(Role::sec)].reset();
  }
  return lacking(columns, true).empty() ? std::optional(columns) : std::nullopt;
}

std::optional<Columns> counted_columns(std::span<const std::string_view> first, ReferenceFormat format,
                                       char separator) {
  constexpr std::string_view kTum = kTumColumns, kEuroc = "t x y z qw qx qy qz";
  constexpr std::string_view kMatrix = "r11 r12 r13 x r21 r22 r23 y r31 r32 r33 z";
  const std::size_t count = first.size();
  if (format == ReferenceFormat::euroc) {
    if (count < 8) return std::nullopt;
    Columns columns = laid_out(kEuroc);
    columns.width = count;
    return columns;
  }
  if (count == 12 && (format == ReferenceFormat::automatic || format == ReferenceFormat::kitti))
    return laid_out(kMatrix);
  if (format == ReferenceFormat::kitti) return std::nullopt;
  if (format == ReferenceFormat::tum) return count == 8 ? std::optional(laid_out(kTum)) : std::nullopt;
  if (count == 4) return laid_out("t x y z");
  if (count == 8) {
    // By commas and in nanoseconds both orders of the quaternion are in use.
    if (separator != ' ' && like_nanoseconds(first[0])) return std::nullopt;
    return laid_out(kTum);
  }
  const bool split = count > 1 && whole(first[0]) && whole(first[1]) && first[1].size() <= 9;
  if (count == 9 && split) return laid_out("sec nsec x y z qx qy qz qw");
  if (count == 5 && split) return laid_out("sec nsec x y z");
  if (count == 13) return laid_out(fmt::format("t {}", kMatrix));
  if (count == 17 && like_nanoseconds(first[0])) {
    Columns columns = laid_out(kEuroc);
    columns.width = count;
    return columns;
  }
  return std::nullopt;
}

}  // namespace aslio::io
