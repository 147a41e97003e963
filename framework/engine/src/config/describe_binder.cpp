#include "describe_binder.hpp"

#include <fmt/core.h>

#include "aslio/config/names.hpp"
#include "aslio/config/node.hpp"
#include "ranges.hpp"
#include "scalars.hpp"

namespace aslio::config {
namespace {

std::string joined(const std::vector<std::string>& names, char separator) {
  std::string text;
  for (const std::string& name : names) {
    if (!text.empty()) text += separator;
    text += name;
  }
  return text;
}

}  // namespace

std::string DescribeBinder::path(std::string_view key) const {
  std::string text = joined(prefix_, '.');
  if (!text.empty()) text += '.';
  return text.append(key);
}

void DescribeBinder::add(std::string_view key, std::string type, std::string_view unit, const Range& range,
                         std::string default_value, std::string_view doc) {
  Field field;
  field.path = path(key);
  field.type = std::move(type);
  field.unit = unit;
  field.range = range_text(range, unit);
  if (field.range == "any") field.range.clear();
  field.default_value = std::move(default_value);
  field.doc = doc;
  found_.fields.push_back(std::move(field));
}

void DescribeBinder::real(std::string_view key, double& value, std::string_view unit, Range range,
                          std::string_view doc) {
  add(key, "number", unit, range, format_real(value), doc);
}

void DescribeBinder::optional_real(std::string_view key, std::optional<double>& value, std::string_view unit,
                                   Range range, std::string_view when_absent, std::string_view doc) {
  add(key, "number or null", unit, range, value ? format_real(*value) : fmt::format("null ({})", when_absent), doc);
}

void DescribeBinder::integer(std::string_view key, std::int64_t& value, std::string_view unit, Range range,
                             std::string_view doc) {
  add(key, "integer", unit, range, std::to_string(value), doc);
}

void DescribeBinder::flag(std::string_view key, bool& value, std::string_view doc) {
  add(key, "true|false", "", {}, value ? "true" : "false", doc);
}

void DescribeBinder::text(std::string_view key, std::string& value, std::string_view doc) {
  add(key, "text", "", {}, to_line(Node::scalar(value, true, {})), doc);
}

void DescribeBinder::reals(std::string_view key, std::vector<double>& value, std::size_t size, std::string_view unit,
                           Range range, std::string_view doc) {
  std::vector<Node> items;
  for (const double v : value) items.push_back(Node::scalar(format_real(v), false, {}));
  add(key, size > 0 ? fmt::format("list of {} numbers", size) : "list of numbers", unit, range,
      to_line(Node::list(std::move(items), {})), doc);
}

void DescribeBinder::texts(std::string_view key, std::vector<std::string>& value,
                           const std::vector<std::string>& allowed, std::string_view doc) {
  std::vector<Node> items;
  for (const std::string& v : value) items.push_back(Node::scalar(v, true, {}));
  add(key, allowed.empty() ? "list of texts" : fmt::format("list of {}", joined(allowed, '|')), "", {},
      to_line(Node::list(std::move(items), {})), doc);
}

void DescribeBinder::tree(std::string_view key, Node& value, std::string_view doc) {
  add(key, "any", "", {}, to_line(value), doc);
}

void DescribeBinder::removed(std::string_view key, std::string_view advice) {
  found_.removed.push_back({path(key), std::string(advice)});
}

void DescribeBinder::choice_index(std::string_view key, std::size_t& index, const std::vector<std::string>& names,
                                  std::string_view doc) {
  add(key, fmt::format("one of {}", joined(names, '|')), "", {}, names.at(index), doc);
}

std::shared_ptr<const StageRecipe> DescribeBinder::stage_recipe(std::string_view key, std::string_view family,
                                                                std::string_view default_type, std::string_view doc) {
  add(key, fmt::format("stage of {}", family), "", {},
      default_type.empty() ? std::string("required") : std::string(default_type), doc);
  found_.fields.back().family = family;
  return nullptr;
}

std::optional<std::vector<std::shared_ptr<const StageRecipe>>> DescribeBinder::stage_recipes(
    std::string_view key, std::string_view family, const std::vector<std::string>& default_types,
    std::string_view doc) {
  add(key, fmt::format("list of stages of {}", family), "", {}, fmt::format("[{}]", join(default_types)), doc);
  found_.fields.back().family = family;
  return std::nullopt;
}

bool DescribeBinder::begin_group(std::string_view key, std::string_view doc) {
  add(key, "block", "", {}, "", doc);
  prefix_.emplace_back(key);
  return true;
}

std::optional<Binder::ListPlan> DescribeBinder::begin_list(std::string_view key, std::size_t size,
                                                           std::string_view doc) {
  add(key, "list of blocks", "", {}, size == 0 ? "[]" : fmt::format("{} blocks", size), doc);
  prefix_.emplace_back(key);
  return ListPlan{1, true};
}

bool DescribeBinder::begin_item(std::size_t) {
  prefix_.emplace_back("N");
  return true;
}

}  // namespace aslio::config
