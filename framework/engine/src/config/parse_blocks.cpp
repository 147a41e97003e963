// ParseBinder: nested stages, blocks and lists of blocks.
#include <utility>

#include "aslio/config/names.hpp"
#include "aslio/config/node.hpp"
#include "parse_binder.hpp"
#include "scalars.hpp"

namespace aslio::config {

/// A type that exists, and its parameters as written.
struct ParseBinder::StageChoice {
  const StageEntry* entry = nullptr;
  Node parameters;  ///< a map, with or without `type`
};

std::optional<ParseBinder::StageChoice> ParseBinder::choose(const Node* node, std::string_view key,
                                                            std::string_view family, std::string_view default_type) {
  const std::vector<std::string> types = stages_.types(family);
  const std::string there_are = types.empty() ? "none is registered" : "there are " + join(types);
  const Location here = node != nullptr ? node->at() : levels_.back().node.at();
  if (node != nullptr && !node->is_map() && !node->is_scalar()) {
    problems_.add(here, quoted_path(key) + " must be a type of " + std::string(family) + " or a block with one, is " +
                            (node->is_list() ? "a list" : "empty") + "; " + there_are);
    return std::nullopt;
  }
  const Node* type = node;
  if (node != nullptr && node->is_map()) {
    const Member* member = node->find("type");
    type = member != nullptr ? &member->value : nullptr;
  }
  if (type == nullptr && default_type.empty()) {
    problems_.add(here, quoted_path(node == nullptr ? std::string(key) : std::string(key) + ".type") +
                            " is missing: name a type of " + std::string(family) + "; " + there_are);
    return std::nullopt;
  }
  if (type != nullptr && !type->is_scalar()) {
    problems_.add(type->at(), quoted_path(std::string(key) + ".type") + " must be a name; " + there_are);
    return std::nullopt;
  }
  const std::string name = type != nullptr ? type->text() : std::string(default_type);
  const StageEntry* entry = stages_.find(family, name);
  if (entry == nullptr) {
    const std::string near = nearest(name, types);
    problems_.add(
        type != nullptr ? type->at() : here,
        quoted_path(key) + " names unknown type " + quote(name) + " of " + std::string(family) +
            (near.empty() ? "" : " (did you mean '" + near + "'?)") + "; " + there_are +
            (near.empty() ? ". One of a plugin needs --plugin FILE.so, or its folder in ASLIO_PLUGIN_PATH" : ""));
    return std::nullopt;
  }
  return StageChoice{entry, node != nullptr && node->is_map() ? *node : Node::map({}, here)};
}

std::shared_ptr<const StageRecipe> ParseBinder::read_stage(const Node* node, std::string_view key,
                                                           std::string_view family, std::string_view default_type,
                                                           Node& resolved) {
  const auto chosen = choose(node, key, family, default_type);
  if (!chosen) return nullptr;
  const StageEntry& entry = *chosen->entry;
  const std::shared_ptr<void> params = entry.defaults();
  const std::size_t before = problems_.size();
  const std::vector<Member> first{{"type", {}, Node::scalar(entry.type, true, {})}};
  resolved =
      bind(chosen->parameters, path_of(key), first, [&](Binder& binder) { entry.describe(binder, params.get()); });
  if (problems_.size() != before) return nullptr;
  plugin_types_.insert(entry.family + '/' + entry.type);
  auto recipe = std::make_shared<StageRecipe>();
  recipe->family = entry.family;
  recipe->type = entry.type;
  recipe->make = [make = entry.make, params](const BuildContext& context) { return make(params.get(), context); };
  return recipe;
}

std::shared_ptr<const StageRecipe> ParseBinder::stage_recipe(std::string_view key, std::string_view family,
                                                             std::string_view default_type, std::string_view) {
  if (checking_) return nullptr;
  const Node* node = take(key);
  Node resolved;
  auto recipe = read_stage(node, key, family, default_type, resolved);
  put(key, std::move(resolved));
  return recipe;
}

std::optional<std::vector<std::shared_ptr<const StageRecipe>>> ParseBinder::stage_recipes(
    std::string_view key, std::string_view family, const std::vector<std::string>& default_types, std::string_view) {
  if (checking_) return std::nullopt;
  const Node* node = take(key);
  if (node != nullptr && !node->is_list()) {
    mistyped(*node, key, "a list of " + std::string(family) + ", as in [{type: ..}]");
    return std::nullopt;
  }
  const std::size_t count = node != nullptr ? node->items().size() : default_types.size();
  std::vector<std::shared_ptr<const StageRecipe>> recipes;
  std::vector<Node> resolved(count);
  bool complete = true;
  for (std::size_t i = 0; i < count; ++i) {
    const Node* item = node != nullptr ? &node->items()[i] : nullptr;
    const std::string_view default_type = node != nullptr ? std::string_view() : std::string_view(default_types[i]);
    recipes.push_back(read_stage(item, std::string(key) + '.' + std::to_string(i), family, default_type, resolved[i]));
    complete = complete && recipes.back() != nullptr;
  }
  put(key, Node::list(std::move(resolved), {}));
  if (!complete) return std::nullopt;
  return recipes;
}

bool ParseBinder::begin_group(std::string_view key, std::string_view) {
  const std::string path = path_of(key);
  if (checking_) {
    // The level of the first pass is gone: rebuild it from what it left behind.
    Level level;
    const Member* given = levels_.back().node.find(key);
    level.node = given != nullptr ? given->value : Node::map({}, levels_.back().node.at());
    level.path = path;
    for (const Member& member : levels_.back().resolved) {
      if (member.key == key) level.resolved = member.value.members();
    }
    levels_.push_back(std::move(level));
    return true;
  }
  const Node* node = take(key);
  if (node != nullptr && !node->is_map()) {
    mistyped(*node, key, "a block of keys");
    return false;
  }
  open(node != nullptr ? *node : Node::map({}, levels_.back().node.at()), path);
  return true;
}

void ParseBinder::end_group() {
  if (checking_) {
    levels_.pop_back();
    return;
  }
  report_unknown_keys(levels_.back());
  const std::string path = levels_.back().path;
  Node resolved = close();
  if (levels_.back().node.is_list()) {
    levels_.back().resolved_items.push_back(std::move(resolved));
  } else {
    put(path.substr(path.rfind('.') + 1), std::move(resolved));
  }
}

std::optional<Binder::ListPlan> ParseBinder::begin_list(std::string_view key, std::size_t size, std::string_view) {
  const std::string path = path_of(key);
  if (checking_) {
    const Member* given = levels_.back().node.find(key);
    Level level;
    level.node = given != nullptr ? given->value : Node::list({}, levels_.back().node.at());
    level.path = path;
    for (const Member& member : levels_.back().resolved) {
      if (member.key == key) level.resolved_items = member.value.items();
    }
    levels_.push_back(std::move(level));
    return ListPlan{size, false};
  }
  const Node* node = take(key);
  if (node != nullptr && !node->is_list()) {
    mistyped(*node, key, "a list of blocks");
    return std::nullopt;
  }
  open(node != nullptr ? *node : Node::list({}, levels_.back().node.at()), path);
  return node != nullptr ? ListPlan{node->items().size(), true} : ListPlan{size, false};
}

bool ParseBinder::begin_item(std::size_t index) {
  const Level& list = levels_.back();
  const bool given = index < list.node.items().size();
  Node node = given ? list.node.items()[index] : Node::map({}, list.node.at());
  const std::string item = std::to_string(index);
  if (!node.is_map()) {
    mistyped(node, item, "a block of keys");
    return false;
  }
  std::vector<Member> resolved;
  if (checking_ && index < list.resolved_items.size()) resolved = list.resolved_items[index].members();
  open(std::move(node), path_of(item));
  levels_.back().resolved = std::move(resolved);
  return true;
}

void ParseBinder::end_list() {
  Level level = std::move(levels_.back());
  levels_.pop_back();
  if (checking_) return;
  put(level.path.substr(level.path.rfind('.') + 1), Node::list(std::move(level.resolved_items), {}));
}

}  // namespace aslio::config
