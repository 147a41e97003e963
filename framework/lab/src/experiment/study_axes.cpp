#include "study_axes.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "aslio/config/binder.hpp"

namespace aslio::experiment {

namespace {

using config::Member;
using config::Node;

bool name_character(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '.' ||
         c == '+' || c == '-';
}

/// A value as part of a name: what a name may not have becomes '_'.
std::string label(const Node& value) {
  const std::string text = value.is_scalar() ? value.text() : config::to_line(value);
  std::string out;
  for (const char c : text) {
    if (name_character(c)) {
      out += c;
    } else if (!out.empty() && out.back() != '_') {
      out += '_';
    }
  }
  while (out.ends_with('_')) out.pop_back();
  return out;
}

std::string last_word(const std::string& path) { return path.substr(path.rfind('.') + 1); }

void append(AxisPoint& point, const std::string& path, const Node& value) {
  const std::string text = label(value);
  point.suffix += fmt::format("_{}_{}", last_word(path), text);
  point.assignments.push_back(path + "=" + config::to_line(value));
  point.values.push_back(text);
}

/// Lists of one length, one at least.
bool in_step(const Node& zip) {
  const auto length = [](const Member& member) { return member.value.items().size(); };
  return zip.is_map() && !zip.members().empty() && length(zip.members().front()) > 0 &&
         std::all_of(zip.members().begin(), zip.members().end(), [&](const Member& member) {
           return member.value.is_list() && length(member) == length(zip.members().front());
         });
}

/// {name: .., set: {..}}
bool named_point(const Node& item) {
  const Member *name = item.find("name"), *set = item.find("set");
  return item.members().size() == 2 && name != nullptr && name->value.is_scalar() && valid_name(name->value.text()) &&
         set != nullptr && set->value.is_map() && !set->value.members().empty();
}

bool named_points(const Node& list) {
  return list.is_list() && !list.items().empty() && std::all_of(list.items().begin(), list.items().end(), named_point);
}

}  // namespace

bool valid_name(const std::string& name) {
  return !name.empty() && name.size() <= 120 && name.front() != '.' && name.front() != '-' &&
         std::all_of(name.begin(), name.end(), name_character);
}

void StudyAxisConfig::describe(config::Binder& b, StudyAxisConfig& axis) {
  b.text("path", axis.path, "dotted path of the pipelines; with `values`: a grid with the other axes");
  b.tree("values", axis.values, "list of values to set there");
  b.tree("zip", axis.zip, "block of dotted paths with lists of one length, whose values change in step");
  b.tree("list", axis.list, "list of {name, set}: single points, each with a block of paths and values");
  b.text("name", axis.name, "column of a `list` in tables");
  b.texts("methods", axis.methods, {}, "methods that vary along this axis; empty: all");
  const int kinds = (axis.path.empty() ? 0 : 1) + (axis.zip.is_null() ? 0 : 1) + (axis.list.is_null() ? 0 : 1);
  b.require(kinds == 1, "path", "with `values`, `zip` and `list` exclude each other, and one is required");
  b.require(axis.path.empty() || (axis.values.is_list() && !axis.values.items().empty()), "values",
            "must be a list of values, as in [0.1, 0.2]");
  b.require(!axis.path.empty() || axis.values.is_null(), "values", "goes with `path`");
  b.require(
      axis.zip.is_null() || in_step(axis.zip), "zip",
      "must be a block of paths with lists of one length, as in {overlap.voxel: [0.1, 0.2], map.voxel: [0.5, 1]}");
  b.require(axis.list.is_null() || named_points(axis.list), "list",
            "must be a list of names with blocks to set, as in [{name: small, set: {map.voxel: 0.5}}]");
  b.require(valid_name(axis.name), "name", fmt::format("'{}' {}", axis.name, kNameRule));
}

std::vector<std::string> axis_columns(const StudyAxisConfig& axis) {
  if (!axis.path.empty()) return {axis.path};
  if (axis.zip.is_null()) return {axis.name};
  std::vector<std::string> columns;
  for (const Member& member : axis.zip.members()) columns.push_back(member.key);
  return columns;
}

std::vector<AxisPoint> axis_points(const StudyAxisConfig& axis) {
  std::vector<AxisPoint> points;
  for (const Node& value : axis.values.items()) append(points.emplace_back(), axis.path, value);
  for (const Member& member : axis.zip.members()) {
    points.resize(member.value.items().size());
    for (std::size_t i = 0; i < points.size(); ++i) append(points[i], member.key, member.value.items()[i]);
  }
  for (const Node& item : axis.list.items()) {
    const std::string& name = item.find("name")->value.text();
    AxisPoint point{.suffix = "_" + name, .assignments = {}, .values = {name}};
    for (const Member& member : item.find("set")->value.members()) {
      point.assignments.push_back(member.key + "=" + config::to_line(member.value));
    }
    points.push_back(std::move(point));
  }
  return points;
}

Grid grid_of(Grid points, const std::vector<StudyAxisConfig>& axes, const std::string& method) {
  for (std::size_t k = 0; k < points.size(); ++k) {
    const std::vector<std::string>& methods = axes[k].methods;
    if (methods.empty() || std::find(methods.begin(), methods.end(), method) != methods.end()) continue;
    const std::vector<std::string> none(axis_columns(axes[k]).size(), "-");
    points[k] = {AxisPoint{.suffix = "", .assignments = {}, .values = none}};
  }
  return points;
}

std::vector<std::string> made_later(const std::vector<std::string>& assignments) {
  std::vector<std::string> keys;
  for (const std::string& assignment : assignments) {
    const bool later = assignment.find("{run:") != std::string::npos || assignment.find("{data}") != std::string::npos;
    if (later) keys.push_back(assignment.substr(0, assignment.find_first_of(".=")));
  }
  return keys;
}

std::vector<std::string> with_seed(std::vector<std::string> assignments, std::uint64_t seed) {
  constexpr std::string_view kSeed = "{seed}";
  const std::string number = std::to_string(seed);
  for (std::string& text : assignments) {
    for (std::size_t at = text.find(kSeed); at != std::string::npos; at = text.find(kSeed, at + number.size()))
      text.replace(at, kSeed.size(), number);
  }
  return assignments;
}

bool advance(const Grid& grid, std::vector<std::size_t>& at_axes) {
  for (std::size_t k = at_axes.size(); k-- > 0;) {
    if (++at_axes[k] < grid[k].size()) return true;
    at_axes[k] = 0;
  }
  return false;
}

}  // namespace aslio::experiment
