#pragma once
/// Fills parameters from a tree, gathers everything that is wrong, and writes down the effective value of every key.

#include <functional>
#include <set>
#include <string>
#include <vector>

#include "aslio/config/binder.hpp"
#include "aslio/config/problems.hpp"
#include "aslio/config/stage_lookup.hpp"

namespace aslio::config {

class ParseBinder final : public Binder {
 public:
  using Describe = std::function<void(Binder&)>;

  ParseBinder(const StageLookup& stages, Problems& problems) : stages_(stages), problems_(problems) {}

  /// Reads the keys of `map` with `describe`; then, if nothing was wrong with them, evaluates its cross-checks. Keys in
  /// `first` have been dealt with and lead the result. Returns the keys at their effective values.
  Node bind(const Node& map, const std::string& path, const std::vector<Member>& first, const Describe& describe);
  /// "family/type" of every stage seen.
  const std::set<std::string>& plugin_types() const { return plugin_types_; }

  void real(std::string_view key, double& value, std::string_view unit, Range range, std::string_view doc) override;
  void optional_real(std::string_view key, std::optional<double>& value, std::string_view unit, Range range,
                     std::string_view when_absent, std::string_view doc) override;
  void integer(std::string_view key, std::int64_t& value, std::string_view unit, Range range,
               std::string_view doc) override;
  void flag(std::string_view key, bool& value, std::string_view doc) override;
  void text(std::string_view key, std::string& value, std::string_view doc) override;
  void reals(std::string_view key, std::vector<double>& value, std::size_t size, std::string_view unit, Range range,
             std::string_view doc) override;
  void texts(std::string_view key, std::vector<std::string>& value, const std::vector<std::string>& allowed,
             std::string_view doc) override;
  void tree(std::string_view key, Node& value, std::string_view doc) override;
  void removed(std::string_view key, std::string_view advice) override;
  void require(bool ok, std::string_view key, std::string_view message) override;

 protected:
  void choice_index(std::string_view key, std::size_t& index, const std::vector<std::string>& names,
                    std::string_view doc) override;
  std::shared_ptr<const StageRecipe> stage_recipe(std::string_view key, std::string_view family,
                                                  std::string_view default_type, std::string_view doc) override;
  std::optional<std::vector<std::shared_ptr<const StageRecipe>>> stage_recipes(
      std::string_view key, std::string_view family, const std::vector<std::string>& default_types,
      std::string_view doc) override;
  bool begin_group(std::string_view key, std::string_view doc) override;
  void end_group() override;
  std::optional<ListPlan> begin_list(std::string_view key, std::size_t size, std::string_view doc) override;
  bool begin_item(std::size_t index) override;
  void end_list() override;

 private:
  /// A block being read. A list of blocks is a level of its own, so that its items find their place.
  struct Level {
    Node node;  ///< a map, or a list of maps
    std::string path;
    std::vector<std::string> known, removed;
    std::vector<Member> resolved;
    std::vector<Node> resolved_items;
  };
  struct StageChoice;

  std::string path_of(std::string_view key) const;
  std::string quoted_path(std::string_view key) const;
  /// The value given for a key that the block has; null when absent.
  const Node* take(std::string_view key);
  void put(std::string_view key, Node value);
  void put_scalar(std::string_view key, std::string text, bool quoted = false);
  void mistyped(const Node& node, std::string_view key, const std::string& expected);
  std::optional<double> read_real(const Node& node, std::string_view key, std::string_view unit, const Range& range);
  std::optional<std::string> read_text(const Node& node, std::string_view key, const std::vector<std::string>& allowed);
  /// Tells a value that is not; such a one is not taken, so that no rule between keys meets it.
  bool in_range(const Node& node, double value, std::string_view key, std::string_view unit, const Range& range);
  std::optional<StageChoice> choose(const Node* node, std::string_view key, std::string_view family,
                                    std::string_view default_type);
  std::shared_ptr<const StageRecipe> read_stage(const Node* node, std::string_view key, std::string_view family,
                                                std::string_view default_type, Node& resolved);
  void open(Node node, std::string path);
  Node close();
  void report_unknown_keys(const Level& level);

  const StageLookup& stages_;
  Problems& problems_;
  std::set<std::string> plugin_types_;
  std::vector<Level> levels_;
  /// Second pass over a block that was read without error: only cross-checks, no value is touched.
  bool checking_ = false;
};

}  // namespace aslio::config
