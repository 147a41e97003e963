// Node to YAML text.
#include <algorithm>

#include "aslio/config/node.hpp"
#include "scalars.hpp"

namespace aslio::config {
namespace {

bool plain_character(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '.' ||
         c == '/' || c == '+' || c == '-';
}

/// Read back without quotes the text would be the same scalar, and not empty, a list or a document mark.
bool plain(const std::string& text) {
  if (text.empty() || !std::all_of(text.begin(), text.end(), plain_character)) return false;
  if (text == "null" || text == "Null" || text == "NULL" || text == "-") return false;
  return !text.starts_with("---") && text != "...";
}

/// A reader might take it for a number or a truth value.
bool looks_typed(const std::string& text) {
  return text == "true" || text == "false" || text.find_first_of("0123456789+-.") == 0;
}

std::string double_quoted(const std::string& text) {
  std::string result = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') result += '\\';
    result += printable(std::string_view(&c, 1));
  }
  return result + '"';
}

std::string scalar_text(const std::string& text, bool quoted) {
  return !plain(text) || (quoted && looks_typed(text)) ? double_quoted(text) : text;
}

bool one_line(const Node& node) {
  if (node.is_map()) return node.members().empty();
  return std::all_of(node.items().begin(), node.items().end(),
                     [](const Node& item) { return !item.is_map() && one_line(item); });
}

void append_block(std::string& out, const Node& map, std::size_t indent, bool first_inline);

void append_value(std::string& out, const Node& value, std::size_t indent) {
  if (one_line(value)) {
    out += ' ' + to_line(value) + '\n';
  } else if (value.is_map()) {
    out += '\n';
    append_block(out, value, indent, false);
  } else {
    out += '\n';
    for (const Node& item : value.items()) {
      out += std::string(indent, ' ') + '-';
      if (item.is_map() && !item.members().empty()) {
        out += ' ';
        append_block(out, item, indent + 2, true);
      } else {
        append_value(out, item, indent + 2);
      }
    }
  }
}

void append_block(std::string& out, const Node& map, std::size_t indent, bool first_inline) {
  for (const Member& member : map.members()) {
    if (!first_inline) out += std::string(indent, ' ');
    first_inline = false;
    out += scalar_text(member.key, true) + ':';
    append_value(out, member.value, indent + 2);
  }
}

}  // namespace

std::string to_yaml(const Node& map) {
  std::string out;
  append_block(out, map, 0, false);
  return out;
}

std::string to_line(const Node& node) {
  switch (node.kind()) {
    case Node::Kind::null:
      return "null";
    case Node::Kind::scalar:
      return scalar_text(node.text(), node.quoted());
    case Node::Kind::list: {
      std::string out = "[";
      for (const Node& item : node.items()) out += (out.size() > 1 ? ", " : "") + to_line(item);
      return out + "]";
    }
    case Node::Kind::map: {
      std::string out = "{";
      for (const Member& member : node.members()) {
        out += (out.size() > 1 ? ", " : "") + scalar_text(member.key, true) + ": " + to_line(member.value);
      }
      return out + "}";
    }
  }
  return {};
}

}  // namespace aslio::config
