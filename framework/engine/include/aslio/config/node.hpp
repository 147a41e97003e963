#pragma once
/// The tree a YAML text stands for: ordered, immutable, and every part of it knows where it was written.

#include <cstddef>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace aslio::config {

/// Where something was written: a file with line and column, or an override (no line).
struct Location {
  std::shared_ptr<const std::string> source;  ///< file name, or the text of the override ("--set window.period=0.05")
  int order = 0;                              ///< sources in the order in which they are reported; the file is 0
  int line = 0;                               ///< 1-based; 0: the source as a whole
  int column = 0;                             ///< 1-based

  /// "file.yaml:2:1" or "--set window.period=0.05".
  std::string text() const;
};

struct Member;

/// A value: empty, a scalar, a list or a map with distinct keys. Copies are deep.
class Node {
 public:
  enum class Kind : unsigned char { null, scalar, list, map };

  Node() = default;
  static Node scalar(std::string text, bool quoted, Location at);
  static Node list(std::vector<Node> items, Location at);
  /// Pre: keys are distinct.
  static Node map(std::vector<Member> members, Location at);
  static Node null(Location at);

  Kind kind() const { return kind_; }
  bool is_null() const { return kind_ == Kind::null; }
  bool is_scalar() const { return kind_ == Kind::scalar; }
  bool is_list() const { return kind_ == Kind::list; }
  bool is_map() const { return kind_ == Kind::map; }
  const Location& at() const { return at_; }

  /// Text of a scalar as it was written, less quotes and escapes.
  const std::string& text() const { return text_; }
  /// A quoted scalar is text, whatever it looks like.
  bool quoted() const { return quoted_; }
  const std::vector<Node>& items() const { return items_; }
  const std::vector<Member>& members() const { return members_; }
  /// Null when this is no map or has no such key.
  const Member* find(std::string_view key) const;

 private:
  Kind kind_ = Kind::null;
  bool quoted_ = false;
  std::string text_;
  std::vector<Node> items_;
  std::vector<Member> members_;
  Location at_;
};

struct Member {
  std::string key;
  Location at;  ///< of the key
  Node value;
};

/// Where `path` ("estimator.residual", "samplers.2") is written; as far down as it is, the begin of the file for a key
/// that is left to its default.
Location place_of(const Node& root, std::string_view path);

/// Same structure and scalars (order of keys included, places and quotes left out).
bool same(const Node& a, const Node& b);

/// YAML text that document.hpp reads back to the same tree; blocks indented by two, lists of scalars on one line.
/// Pre: `map` is a map.
std::string to_yaml(const Node& map);

/// One line, for messages and tables: "0.1", "[0.1, 0.2]", "{type: fixed, period: 0.1}".
std::string to_line(const Node& node);

}  // namespace aslio::config
