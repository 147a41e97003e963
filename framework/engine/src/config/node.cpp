#include "aslio/config/node.hpp"

#include <algorithm>
#include <utility>

#include "scalars.hpp"

namespace aslio::config {

std::string Location::text() const {
  const std::string name = source ? *source : std::string("configuration");
  return line > 0 ? name + ':' + std::to_string(line) + ':' + std::to_string(column) : name;
}

Node Node::scalar(std::string text, bool quoted, Location at) {
  Node node;
  node.kind_ = Kind::scalar;
  node.text_ = std::move(text);
  node.quoted_ = quoted;
  node.at_ = std::move(at);
  return node;
}

Node Node::list(std::vector<Node> items, Location at) {
  Node node;
  node.kind_ = Kind::list;
  node.items_ = std::move(items);
  node.at_ = std::move(at);
  return node;
}

Node Node::map(std::vector<Member> members, Location at) {
  Node node;
  node.kind_ = Kind::map;
  node.members_ = std::move(members);
  node.at_ = std::move(at);
  return node;
}

Node Node::null(Location at) {
  Node node;
  node.at_ = std::move(at);
  return node;
}

const Member* Node::find(std::string_view key) const {
  for (const Member& member : members_) {
    if (member.key == key) return &member;
  }
  return nullptr;
}

Location place_of(const Node& root, std::string_view path) {
  const Node* node = &root;
  while (!path.empty()) {
    const std::size_t end = std::min(path.find('.'), path.size());
    const std::string_view key = path.substr(0, end);
    path.remove_prefix(std::min(end + 1, path.size()));
    const Node* next = nullptr;
    if (const Member* member = node->find(key)) next = &member->value;
    if (const auto index = parse_integer(key); node->is_list() && index && *index >= 0) {
      const auto i = static_cast<std::size_t>(*index);
      if (i < node->items().size()) next = &node->items()[i];
    }
    if (next == nullptr) break;
    node = next;
  }
  Location at = node->at();
  if (node == &root) at.line = at.column = 1;
  return at;
}

bool same(const Node& a, const Node& b) {
  if (a.kind() != b.kind() || a.text() != b.text() || a.items().size() != b.items().size() ||
      a.members().size() != b.members().size()) {
    return false;
  }
  for (std::size_t i = 0; i < a.items().size(); ++i) {
    if (!same(a.items()[i], b.items()[i])) return false;
  }
  for (std::size_t i = 0; i < a.members().size(); ++i) {
    if (a.members()[i].key != b.members()[i].key || !same(a.members()[i].value, b.members()[i].value)) return false;
  }
  return true;
}

}  // namespace aslio::config
