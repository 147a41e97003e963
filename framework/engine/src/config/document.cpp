#include "aslio/config/document.hpp"

#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/exceptions.h>
#include <yaml-cpp/parser.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <optional>
#include <set>
#include <sstream>
#include <tuple>
#include <utility>

#include "aslio/config/problems.hpp"
#include "aslio/core/errors.hpp"
#include "scalars.hpp"

namespace aslio::config {
namespace {

[[noreturn]] void fail(const Location& at, const std::string& message) {
  throw ConfigError(at.text() + ": " + message);
}

/// Events to nodes. yaml-cpp reports anchors and tags as it goes, so what is refused is refused here.
class TreeBuilder final : public YAML::EventHandler {
 public:
  /// With `fixed`, every node is at `at` (an override has no lines); otherwise at its mark in the source of `at`.
  TreeBuilder(Location at, bool fixed, Problems& problems)
      : base_(std::move(at)), fixed_(fixed), problems_(problems), root_(Node::null(base_)) {}

  void OnDocumentStart(const YAML::Mark&) override {}
  void OnDocumentEnd() override {}
  void OnAnchor(const YAML::Mark& mark, const std::string& name) override {
    problems_.add(place(mark), "anchors are not supported (&" + name + "): write the values out");
  }
  void OnAlias(const YAML::Mark& mark, YAML::anchor_t) override {
    whole_ = false;
    problems_.add(place(mark), "aliases (*name) are not supported: write the values out");
    put(Node::null(place(mark)));
  }
  void OnNull(const YAML::Mark& mark, YAML::anchor_t) override { put(Node::null(place(mark))); }
  void OnScalar(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t, const std::string& value) override {
    check_tag(mark, tag);
    put(Node::scalar(value, tag == "!", place(mark)));
  }
  void OnSequenceStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t,
                       YAML::EmitterStyle::value) override {
    open(mark, tag, false);
  }
  void OnSequenceEnd() override {
    Level level = close();
    put(Node::list(std::move(level.items), std::move(level.at)));
  }
  void OnMapStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t, YAML::EmitterStyle::value) override {
    open(mark, tag, true);
  }
  void OnMapEnd() override {
    Level level = close();
    put(Node::map(std::move(level.members), std::move(level.at)));
  }

  /// False when something that was refused left a hole: what is missing then must not be reported as well.
  bool whole() const { return whole_; }
  Node take() { return std::move(root_); }
  Location place(const YAML::Mark& mark) const {
    Location at = base_;
    if (!fixed_ && !mark.is_null()) {
      at.line = mark.line + 1;
      at.column = mark.column + 1;
    }
    return at;
  }

 private:
  struct Level {
    bool is_map = false;
    Location at;
    std::vector<Node> items;
    std::vector<Member> members;
    std::set<std::string> keys;
    bool has_key = false;   ///< a key waits for its value
    bool drop_key = false;  ///< that key was refused, and its value goes with it
    std::string key;
    Location key_at;
  };

  void check_tag(const YAML::Mark& mark, const std::string& tag) {
    if (!tag.empty() && tag != "?" && tag != "!") {
      problems_.add(place(mark), "tags are not supported (" + tag + "): write the plain value");
    }
  }

  void open(const YAML::Mark& mark, const std::string& tag, bool is_map) {
    check_tag(mark, tag);
    if (levels_.size() >= kMaxDepth) fail(place(mark), "nested deeper than " + std::to_string(kMaxDepth) + " levels");
    Level level;
    level.is_map = is_map;
    level.at = place(mark);
    levels_.push_back(std::move(level));
  }

  Level close() {
    Level level = std::move(levels_.back());
    levels_.pop_back();
    return level;
  }

  void put(Node node) {
    if (++nodes_ > kMaxNodes) fail(node.at(), "more than " + std::to_string(kMaxNodes) + " values");
    if (levels_.empty()) {
      root_ = std::move(node);
      return;
    }
    Level& level = levels_.back();
    if (!level.is_map) {
      level.items.push_back(std::move(node));
    } else if (!level.has_key) {
      put_key(level, node);
    } else {
      level.has_key = false;
      if (level.drop_key) return;
      // An empty value has no place of its own: yaml-cpp gives that of whatever follows.
      Node value = node.is_null() ? Node::null(level.key_at) : std::move(node);
      level.members.push_back({std::move(level.key), level.key_at, std::move(value)});
    }
  }

  void put_key(Level& level, const Node& node) {
    level.has_key = true;
    level.drop_key = true;
    level.key_at = node.at();
    if (!node.is_scalar() || node.text().empty()) {
      whole_ = false;
      problems_.add(node.at(), "a key must be a name");
    } else if (node.text() == "<<") {
      whole_ = false;
      problems_.add(node.at(), "merge keys (<<) are not supported: write the keys out");
    } else if (!level.keys.insert(node.text()).second) {
      problems_.add(node.at(), "duplicate key " + quote(node.text()) + ": remove one of them");
    } else {
      level.drop_key = false;
      level.key = node.text();
    }
  }

  Location base_;
  bool fixed_;
  Problems& problems_;
  bool whole_ = true;
  std::vector<Level> levels_;
  std::size_t nodes_ = 0;
  Node root_;
};

/// Control characters have no place in a configuration, and would reach the terminal through messages.
void check_characters(std::string_view text, Location at, bool fixed) {
  int line = 1;
  int column = 1;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if ((byte < 0x20 && c != '\n' && c != '\t' && c != '\r') || byte == 0x7f) {
      if (!fixed) {
        at.line = line;
        at.column = column;
      }
      fail(at, "control character (byte " + std::to_string(byte) + "): the file must be UTF-8 text");
    }
    column = c == '\n' ? 1 : column + 1;
    if (c == '\n') ++line;
  }
}

/// The first tab that indents a line, as its line and column; nothing: there is none.
std::optional<std::pair<int, int>> indenting_tab(std::string_view text) {
  int line = 1, column = 1;
  bool indents = true;
  for (const char c : text) {
    if (indents && c == '\t') return std::pair(line, column);
    indents = c == '\n' || (indents && c == ' ');
    column = c == '\n' ? 1 : column + 1;
    if (c == '\n') ++line;
  }
  return std::nullopt;
}

Node build(std::string_view text, const Location& at, bool fixed, Problems& problems) {
  if (text.size() > kMaxFileBytes) {
    fail(at, std::to_string(text.size()) + " bytes, at most " + std::to_string(kMaxFileBytes) + " are read");
  }
  check_characters(text, at, fixed);
  TreeBuilder builder(at, fixed, problems);
  try {
    std::istringstream stream{std::string(text)};
    YAML::Parser parser(stream);
    parser.HandleNextDocument(builder);
    Problems of_second;
    TreeBuilder second(at, fixed, of_second);
    if (parser.HandleNextDocument(second)) fail(at, "more than one document: remove what follows '---'");
  } catch (const YAML::Exception& error) {
    if (const auto tab = indenting_tab(text); tab && !fixed) {
      Location there = at;
      std::tie(there.line, there.column) = *tab;
      fail(there, "a tab indents this line: YAML takes spaces only");
    }
    fail(builder.place(error.mark), "not valid YAML: " + error.msg);
  }
  if (!builder.whole()) problems.raise();
  return builder.take();
}

}  // namespace

Node parse_document(std::string_view text, const std::string& source, Problems& problems) {
  Location at;
  at.source = std::make_shared<const std::string>(source);
  return build(text, at, false, problems);
}

Node parse_document(std::string_view text, const std::string& source) {
  Problems problems;
  Node root = parse_document(text, source, problems);
  problems.raise();
  return root;
}

Node parse_value(std::string_view text, const Location& at) {
  Problems problems;
  Node value = build(text, at, true, problems);
  problems.raise();
  return value;
}

std::string read_text(const std::filesystem::path& path) {
  std::error_code ignored;
  const std::filesystem::file_status status = std::filesystem::status(path, ignored);
  if (std::filesystem::is_directory(status)) throw ConfigError(path.string() + ": is a directory, not a file");
  // Opening a pipe would wait for its writer.
  if (std::filesystem::is_other(status)) throw ConfigError(path.string() + ": is a pipe or device, not a regular file");
  errno = 0;
  std::ifstream file(path, std::ios::binary);
  if (!file) throw ConfigError(path.string() + ": cannot be opened: " + std::strerror(errno));
  std::string text(kMaxFileBytes + 1, '\0');
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (file.bad()) throw ConfigError(path.string() + ": cannot be read: " + std::strerror(errno));
  text.resize(static_cast<std::size_t>(file.gcount()));
  if (text.size() > kMaxFileBytes) {
    throw ConfigError(path.string() + ": larger than " + std::to_string(kMaxFileBytes) +
                      " bytes: no configuration is that long");
  }
  return text;
}

}  // namespace aslio::config
