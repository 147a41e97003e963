#include "aslio/config/override.hpp"

#include <algorithm>
#include <optional>
#include <utility>

#include "aslio/config/document.hpp"
#include "aslio/config/problems.hpp"
#include "aslio/core/errors.hpp"
#include "scalars.hpp"

namespace aslio::config {
namespace {

using Segments = std::span<const std::string>;

[[noreturn]] void refuse(const Location& at, const std::string& message) {
  throw ConfigError(printable(at.text() + ": " + message));
}

std::optional<std::size_t> as_index(const std::string& segment) {
  const auto value = parse_integer(segment);
  return value && *value >= 0 ? std::optional<std::size_t>(static_cast<std::size_t>(*value)) : std::nullopt;
}

/// A later override may not silently undo an earlier one.
void refuse_dropped(const Node& dropped, const Location& at) {
  if (dropped.at().order > 0 && !dropped.is_map()) {
    refuse(dropped.at(), "would be undone by the later " + at.text() + ": put it behind that");
  }
  for (const Node& item : dropped.items()) refuse_dropped(item, at);
  for (const Member& member : dropped.members()) refuse_dropped(member.value, at);
}

/// One assignment being applied.
class Assignment {
 public:
  Assignment(std::vector<std::string> path, Node value, Location at)
      : path_(std::move(path)), value_(std::move(value)), at_(std::move(at)) {}

  Node apply(const Node& root) const { return set(root, 0); }

 private:
  /// "samplers.2", the path down to but not including segment `depth`.
  std::string prefix(std::size_t depth) const {
    std::string text;
    for (std::size_t i = 0; i < depth; ++i) text += (i == 0 ? "" : ".") + path_[i];
    return text;
  }

  Node set(const Node& node, std::size_t depth) const {
    if (depth == path_.size()) {
      if (node.is_map() || node.is_list()) refuse_dropped(node, at_);
      return value_;
    }
    if (node.is_list() || (node.is_null() && as_index(path_[depth]))) return set_item(node, depth);
    return set_member(node, depth);
  }

  Node set_item(const Node& list, std::size_t depth) const {
    const auto index = as_index(path_[depth]);
    const std::string name = quote(prefix(depth));
    if (!index) refuse(at_, name + " is a list: give an index, as in " + prefix(depth) + ".0");
    std::vector<Node> items = list.items();
    if (*index > items.size()) {
      refuse(at_, name + " has " + std::to_string(items.size()) + " elements: the index must be at most " +
                      std::to_string(items.size()) + " (which appends one)");
    }
    if (*index == items.size()) items.push_back(Node::null(at_));
    items[*index] = set(items[*index], depth + 1);
    return Node::list(std::move(items), list.is_null() ? at_ : list.at());
  }

  Node set_member(const Node& node, std::size_t depth) const {
    const std::string& key = path_[depth];
    const bool is_type = key == "type" && depth + 1 == path_.size();
    std::vector<Member> members;
    if (node.is_map() && !is_type) {
      members = node.members();
    } else if (node.is_map()) {
      // The other keys belong to the old type. The old type itself may have been set before: the last one counts.
      for (const Member& member : node.members()) {
        if (member.key != "type") refuse_dropped(member.value, at_);
      }
    } else if (node.is_scalar() && !is_type) {
      // The short form of a stage: `window: fixed` stands for `window: {type: fixed}`.
      members.push_back({"type", node.at(), node});
    }
    const auto found = std::find_if(members.begin(), members.end(), [&](const Member& m) { return m.key == key; });
    if (found != members.end()) {
      found->value = set(found->value, depth + 1);
      found->at = at_;
    } else {
      members.push_back({key, at_, set(Node::null(at_), depth + 1)});
    }
    return Node::map(std::move(members), node.is_map() ? node.at() : at_);
  }

  std::vector<std::string> path_;
  Node value_;
  Location at_;
};

Assignment read(const Override& override_, int order) {
  const std::string& text = override_.assignment;
  Location at;
  at.source = std::make_shared<const std::string>("--set " + text);
  at.order = order;
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos) refuse(at, "must be KEY=VALUE, as in window.period=0.05");
  std::vector<std::string> path;
  std::size_t begin = 0;
  while (begin <= equals) {
    const std::size_t end = std::min(text.find('.', begin), equals);
    path.push_back(text.substr(begin, end - begin));
    if (path.back().empty()) refuse(at, "the key has an empty part: write KEY=VALUE, as in window.period=0.05");
    begin = end + 1;
  }
  if (path.size() > kMaxDepth) refuse(at, "nested deeper than " + std::to_string(kMaxDepth) + " levels");
  if (path.front() == "schema") refuse(at, "the schema says what the file is and cannot be set");
  const std::string value = text.substr(equals + 1);
  if (value.find_first_not_of(" \t") == std::string::npos) refuse(at, "has no value: write null to unset a key");
  return {std::move(path), parse_value(value, at), at};
}

}  // namespace

Node apply_overrides(const Node& root, std::span<const Override> overrides) {
  Node tree = root;
  int order = 0;
  for (const Override& override_ : overrides) tree = read(override_, ++order).apply(tree);
  return tree;
}

}  // namespace aslio::config
