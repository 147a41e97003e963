#include "parse_binder.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "aslio/config/names.hpp"
#include "aslio/config/node.hpp"
#include "ranges.hpp"
#include "scalars.hpp"

namespace aslio::config {
namespace {

std::string join_path(const std::string& path, std::string_view key) {
  return path.empty() ? std::string(key) : path + '.' + std::string(key);
}

std::string what_stands_there(const Node& node) {
  switch (node.kind()) {
    case Node::Kind::null:
      return "empty";
    case Node::Kind::list:
      return "a list";
    case Node::Kind::map:
      return "a block of keys";
    case Node::Kind::scalar:
      return (node.quoted() ? "the quoted text " : "") + quote(node.text());
  }
  return {};
}

/// Where the value of a key was set by an override: its own place, or that of the first such element of a list.
const Location* override_of(const Node& value) {
  if (value.at().order > 0) return &value.at();
  for (const Node& item : value.items()) {
    if (item.is_scalar() && item.at().order > 0) return &item.at();
  }
  return nullptr;
}

bool contains(const std::vector<std::string>& names, std::string_view name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

}  // namespace

Node ParseBinder::bind(const Node& map, const std::string& path, const std::vector<Member>& first,
                       const Describe& describe) {
  const bool outer = std::exchange(checking_, false);
  const std::size_t before = problems_.size();
  open(map, path);
  for (const Member& member : first) {
    levels_.back().known.push_back(member.key);
    levels_.back().resolved.push_back(member);
  }
  describe(*this);
  report_unknown_keys(levels_.back());
  if (problems_.size() == before) {
    checking_ = true;
    describe(*this);
  }
  checking_ = outer;
  return close();
}

void ParseBinder::open(Node node, std::string path) {
  Level level;
  level.node = std::move(node);
  level.path = std::move(path);
  levels_.push_back(std::move(level));
}

Node ParseBinder::close() {
  Level level = std::move(levels_.back());
  levels_.pop_back();
  return Node::map(std::move(level.resolved), level.node.at());
}

void ParseBinder::report_unknown_keys(const Level& level) {
  for (const Member& member : level.node.members()) {
    if (contains(level.known, member.key) || contains(level.removed, member.key)) continue;
    problems_.add(member.at,
                  "unknown key " + quote(join_path(level.path, member.key)) + suggestion(member.key, level.known));
  }
}

std::string ParseBinder::path_of(std::string_view key) const { return join_path(levels_.back().path, key); }

std::string ParseBinder::quoted_path(std::string_view key) const { return quote(path_of(key)); }

const Node* ParseBinder::take(std::string_view key) {
  Level& level = levels_.back();
  if (contains(level.known, key)) throw std::logic_error("describe() declares " + quoted_path(key) + " twice");
  level.known.emplace_back(key);
  const Member* member = level.node.find(key);
  return member != nullptr ? &member->value : nullptr;
}

void ParseBinder::put(std::string_view key, Node value) {
  levels_.back().resolved.push_back({std::string(key), {}, std::move(value)});
}

void ParseBinder::put_scalar(std::string_view key, std::string text, bool quoted) {
  put(key, Node::scalar(std::move(text), quoted, {}));
}

void ParseBinder::mistyped(const Node& node, std::string_view key, const std::string& expected) {
  problems_.add(node.at(), quoted_path(key) + " must be " + expected + ", is " + what_stands_there(node));
}

bool ParseBinder::in_range(const Node& node, double value, std::string_view key, std::string_view unit,
                           const Range& range) {
  if (admits(range, value)) return true;
  problems_.add(node.at(), fmt::format("{} is out of range: {}{}{}, admissible is {}", quoted_path(key), node.text(),
                                       unit.empty() ? "" : " ", unit, range_text(range, unit)));
  return false;
}

std::optional<double> ParseBinder::read_real(const Node& node, std::string_view key, std::string_view unit,
                                             const Range& range) {
  const auto value = node.is_scalar() && !node.quoted() ? parse_real(node.text()) : std::nullopt;
  if (!value) mistyped(node, key, "a finite decimal number" + unit_text(unit));
  return value && in_range(node, *value, key, unit, range) ? value : std::nullopt;
}

std::optional<std::string> ParseBinder::read_text(const Node& node, std::string_view key,
                                                  const std::vector<std::string>& allowed) {
  if (!node.is_scalar()) {
    mistyped(node, key, allowed.empty() ? "text" : "one of " + join(allowed));
    return std::nullopt;
  }
  if (!allowed.empty() && !contains(allowed, node.text())) {
    const std::string near = nearest(node.text(), allowed);
    problems_.add(node.at(), quoted_path(key) + " must be one of " + join(allowed) + ", is " + quote(node.text()) +
                                 (near.empty() ? "" : " (did you mean '" + near + "'?)"));
    return std::nullopt;
  }
  return node.text();
}

void ParseBinder::real(std::string_view key, double& value, std::string_view unit, Range range, std::string_view) {
  if (checking_) return;
  if (const Node* node = take(key)) value = read_real(*node, key, unit, range).value_or(value);
  put_scalar(key, format_real(value));
}

void ParseBinder::optional_real(std::string_view key, std::optional<double>& value, std::string_view unit, Range range,
                                std::string_view, std::string_view) {
  if (checking_) return;
  if (const Node* node = take(key)) {
    value = node->is_null() ? std::nullopt : read_real(*node, key, unit, range);
  }
  put(key, value ? Node::scalar(format_real(*value), false, {}) : Node());
}

void ParseBinder::integer(std::string_view key, std::int64_t& value, std::string_view unit, Range range,
                          std::string_view) {
  if (checking_) return;
  if (const Node* node = take(key)) {
    const auto read = node->is_scalar() && !node->quoted() ? parse_integer(node->text()) : std::nullopt;
    if (!read) mistyped(*node, key, "a whole decimal number" + unit_text(unit));
    if (read && in_range(*node, static_cast<double>(*read), key, unit, range)) value = *read;
  }
  put_scalar(key, std::to_string(value));
}

void ParseBinder::flag(std::string_view key, bool& value, std::string_view) {
  if (checking_) return;
  if (const Node* node = take(key)) {
    if (node->is_scalar() && !node->quoted() && (node->text() == "true" || node->text() == "false")) {
      value = node->text() == "true";
    } else {
      mistyped(*node, key, "true or false");
    }
  }
  put_scalar(key, value ? "true" : "false");
}

void ParseBinder::text(std::string_view key, std::string& value, std::string_view) {
  if (checking_) return;
  if (const Node* node = take(key)) value = read_text(*node, key, {}).value_or(value);
  put_scalar(key, value, true);
}

void ParseBinder::choice_index(std::string_view key, std::size_t& index, const std::vector<std::string>& names,
                               std::string_view) {
  if (checking_) return;
  if (const Node* node = take(key)) {
    if (const auto name = read_text(*node, key, names)) {
      index = static_cast<std::size_t>(std::find(names.begin(), names.end(), *name) - names.begin());
    }
  }
  put_scalar(key, names.at(index), true);
}

void ParseBinder::reals(std::string_view key, std::vector<double>& value, std::size_t size, std::string_view unit,
                        Range range, std::string_view) {
  if (checking_) return;
  if (const Node* node = take(key)) {
    if (!node->is_list() || (size > 0 && node->items().size() != size)) {
      const std::string count = size > 0 ? std::to_string(size) + ' ' : std::string();
      const std::string got = node->is_list() ? " of " + std::to_string(node->items().size()) : std::string();
      problems_.add(node->at(), quoted_path(key) + " must be a list of " + count + "numbers" + unit_text(unit) +
                                    ", is " + what_stands_there(*node) + got);
    } else {
      std::vector<double> read;
      for (std::size_t i = 0; i < node->items().size(); ++i) {
        const std::string item = std::string(key) + '.' + std::to_string(i);
        if (const auto v = read_real(node->items()[i], item, unit, range)) read.push_back(*v);
      }
      if (read.size() == node->items().size()) value = std::move(read);
    }
  }
  std::vector<Node> items;
  for (const double v : value) items.push_back(Node::scalar(format_real(v), false, {}));
  put(key, Node::list(std::move(items), {}));
}

void ParseBinder::texts(std::string_view key, std::vector<std::string>& value, const std::vector<std::string>& allowed,
                        std::string_view) {
  if (checking_) return;
  if (const Node* node = take(key)) {
    if (!node->is_list()) {
      mistyped(*node, key, "a list of " + (allowed.empty() ? std::string("texts") : "names from " + join(allowed)));
    } else {
      value.clear();
      for (std::size_t i = 0; i < node->items().size(); ++i) {
        const std::string item = std::string(key) + '.' + std::to_string(i);
        value.push_back(read_text(node->items()[i], item, allowed).value_or(std::string()));
      }
    }
  }
  std::vector<Node> items;
  for (const std::string& v : value) items.push_back(Node::scalar(v, true, {}));
  put(key, Node::list(std::move(items), {}));
}

void ParseBinder::tree(std::string_view key, Node& value, std::string_view) {
  if (checking_) return;
  if (const Node* node = take(key)) value = *node;
  put(key, value);
}

void ParseBinder::removed(std::string_view key, std::string_view advice) {
  if (checking_) return;
  levels_.back().removed.emplace_back(key);
  if (const Member* member = levels_.back().node.find(key)) {
    problems_.add(member->at, quoted_path(key) + " was removed: " + std::string(advice));
  }
}

void ParseBinder::require(bool ok, std::string_view key, std::string_view message) {
  if (!checking_ || ok) return;
  const Level& level = levels_.back();
  const Member* given = level.node.find(key);
  std::string text = quoted_path(key);
  const auto effective =
      std::find_if(level.resolved.begin(), level.resolved.end(), [&](const Member& m) { return m.key == key; });
  if (effective != level.resolved.end() && !effective->value.is_map()) {
    text += " = " + to_line(effective->value) + (given == nullptr ? " (default)" : "");
  }
  const Location& at = given != nullptr ? given->value.at() : level.node.at();
  text.append(" ").append(message);
  // The place is that of the key complained of; what broke the rule may be an override of another key of the block.
  for (const Member& member : level.node.members()) {
    const Location* set = override_of(member.value);
    if (set == nullptr || set->order == at.order) continue;
    text += fmt::format(" ({} was set by {})", path_of(member.key), set->text());
  }
  problems_.add(at, text);
}

}  // namespace aslio::config
