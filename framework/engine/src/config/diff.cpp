#include "aslio/config/diff.hpp"

#include <algorithm>

#include "aslio/config/document.hpp"
#include "aslio/config/node.hpp"

namespace aslio::config {
namespace {

std::string join_path(const std::string& path, const std::string& key) {
  return path.empty() ? key : std::string(path).append(1, '.').append(key);
}

/// Type of a stage's block; empty for anything else.
std::string type_of(const Node& node) {
  const Member* type = node.find("type");
  return type != nullptr && type->value.is_scalar() ? type->value.text() : std::string();
}

bool holds_blocks(const Node& list) {
  return std::any_of(list.items().begin(), list.items().end(), [](const Node& item) { return item.is_map(); });
}

class Comparison {
 public:
  void compare(const Node& a, const Node& b, const std::string& path) {
    if (a.is_map() && b.is_map() && type_of(a) == type_of(b)) {
      compare_maps(a, b, path);
    } else if (a.is_list() && b.is_list() && (holds_blocks(a) || holds_blocks(b))) {
      compare_lists(a, b, path);
    } else if (!same(a, b)) {
      found_.push_back({path, to_line(a), to_line(b)});
    }
  }
  std::vector<Difference> take() { return std::move(found_); }

 private:
  void compare_maps(const Node& a, const Node& b, const std::string& path) {
    for (const Member& member : a.members()) {
      const std::string at = join_path(path, member.key);
      if (const Member* other = b.find(member.key)) {
        compare(member.value, other->value, at);
      } else {
        found_.push_back({at, to_line(member.value), std::nullopt});
      }
    }
    for (const Member& member : b.members()) {
      if (a.find(member.key) == nullptr) {
        found_.push_back({join_path(path, member.key), std::nullopt, to_line(member.value)});
      }
    }
  }

  void compare_lists(const Node& a, const Node& b, const std::string& path) {
    const std::size_t n = std::max(a.items().size(), b.items().size());
    for (std::size_t i = 0; i < n; ++i) {
      const std::string at = join_path(path, std::to_string(i));
      if (i >= b.items().size()) {
        found_.push_back({at, to_line(a.items()[i]), std::nullopt});
      } else if (i >= a.items().size()) {
        found_.push_back({at, std::nullopt, to_line(b.items()[i])});
      } else {
        compare(a.items()[i], b.items()[i], at);
      }
    }
  }

  std::vector<Difference> found_;
};

}  // namespace

std::vector<Difference> diff(std::string_view resolved_a, std::string_view resolved_b) {
  Comparison comparison;
  comparison.compare(parse_document(resolved_a, "A"), parse_document(resolved_b, "B"), "");
  return comparison.take();
}

std::string to_text(const std::vector<Difference>& differences) {
  std::string text;
  for (const Difference& d : differences) {
    text += d.path;
    text += ": ";
    if (d.a && d.b) {
      text.append(*d.a).append(" -> ").append(*d.b);
    } else {
      text.append(d.a ? *d.a : d.b.value_or("")).append(d.a ? " (only in A)" : " (only in B)");
    }
    text += '\n';
  }
  return text;
}

}  // namespace aslio::config
