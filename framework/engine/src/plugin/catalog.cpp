#include <algorithm>
#include <utility>

#include "aslio/core/errors.hpp"
#include "aslio/plugin/registry.hpp"

namespace aslio::plugin {

void Catalog::add(Entry entry) {
  if (const Entry* taken = find(entry.family, entry.type)) {
    throw ConfigError("stage " + entry.family + '/' + entry.type + " of " + entry.origin +
                      " is registered already, by " + taken->origin + ": rename one of them");
  }
  declare(entry.family);
  entries_.push_back(std::make_unique<Entry>(std::move(entry)));
}

const Entry* Catalog::find(std::string_view family, std::string_view type) const {
  for (const auto& entry : entries_) {
    if (entry->family == family && entry->type == type) return entry.get();
  }
  return nullptr;
}

std::vector<std::string> Catalog::families() const {
  std::vector<std::string> names = families_;
  std::sort(names.begin(), names.end());
  return names;
}

std::vector<std::string> Catalog::types(std::string_view family) const {
  std::vector<std::string> names;
  for (const auto& entry : entries_) {
    if (entry->family == family) names.push_back(entry->type);
  }
  std::sort(names.begin(), names.end());
  return names;
}

void Catalog::declare(std::string_view family) {
  if (std::find(families_.begin(), families_.end(), family) == families_.end()) families_.emplace_back(family);
}

}  // namespace aslio::plugin
