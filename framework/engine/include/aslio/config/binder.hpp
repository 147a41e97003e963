#pragma once
/// One declaration of a parameter block serves parsing, checking, description and the resolved dump:
///
///   struct Params { double period = 0.1; ... };
///   static void describe(config::Binder& b, Params& p) {
///     b.real("period", p.period, "s", {.above = 0.0, .max = 10.0}, "time between updates");
///     b.choice("cut", p.cut, {{"time", Cut::time}, {"sweep", Cut::sweep}}, "where a window ends");
///     b.require(p.length >= p.period, "length", "must be at least the period");
///   }
///
/// Defaults live in Params alone. A describe() may be called many times (parse, dump, describe) and must not have
/// any effect beyond calls on the binder; `require` is evaluated only once the whole block has been read without error.

#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "aslio/config/nested.hpp"

namespace aslio::config {

class Node;  // config/node.hpp

/// Admissible interval of a number: min <= v <= max and above < v < below.
struct Range {
  double above = -std::numeric_limits<double>::infinity();
  double min = -std::numeric_limits<double>::infinity();
  double max = std::numeric_limits<double>::infinity();
  double below = std::numeric_limits<double>::infinity();
};

class Binder {
 public:
  virtual ~Binder() = default;

  virtual void real(std::string_view key, double& value, std::string_view unit, Range range, std::string_view doc) = 0;
  /// Absent stays nullopt; `when_absent` says what that means ("= period"). YAML null is the same as absent.
  virtual void optional_real(std::string_view key, std::optional<double>& value, std::string_view unit, Range range,
                             std::string_view when_absent, std::string_view doc) = 0;
  virtual void integer(std::string_view key, std::int64_t& value, std::string_view unit, Range range,
                       std::string_view doc) = 0;
  virtual void flag(std::string_view key, bool& value, std::string_view doc) = 0;
  virtual void text(std::string_view key, std::string& value, std::string_view doc) = 0;
  /// A list of numbers; `size` 0 means any length.
  virtual void reals(std::string_view key, std::vector<double>& value, std::size_t size, std::string_view unit,
                     Range range, std::string_view doc) = 0;
  /// A list of names, each one of `allowed` (empty: any text).
  virtual void texts(std::string_view key, std::vector<std::string>& value, const std::vector<std::string>& allowed,
                     std::string_view doc) = 0;

  /// One of the named values of an enum.
  template <class E>
  void choice(std::string_view key, E& value, std::initializer_list<std::pair<std::string_view, E>> values,
              std::string_view doc) {
    std::vector<std::string> names;
    std::size_t index = 0;
    for (const auto& [name, candidate] : values) {
      if (candidate == value) index = names.size();
      names.emplace_back(name);
    }
    choice_index(key, index, names, doc);
    value = (values.begin() + static_cast<std::ptrdiff_t>(index))->second;
  }

  /// A nested stage, built by the same registry: `motion: {type: imu_midpoint, ...}` or, in short, `motion:
  /// imu_midpoint`.
  template <class S>
  void stage(std::string_view key, Nested<S>& slot, std::string_view doc) {
    if (auto recipe = stage_recipe(key, S::family, slot.type(), doc)) slot.resolve(std::move(recipe));
  }
  /// An ordered list of stages.
  template <class S>
  void stages(std::string_view key, std::vector<Nested<S>>& slots, std::string_view doc) {
    std::vector<std::string> default_types;
    for (const Nested<S>& slot : slots) default_types.push_back(slot.type());
    if (auto recipes = stage_recipes(key, S::family, default_types, doc)) {
      slots.clear();
      for (auto& recipe : *recipes) slots.emplace_back().resolve(std::move(recipe));
    }
  }
  /// A nested plain block with its own `describe(Binder&, P&)`, found by argument-dependent lookup or as P::describe.
  template <class P>
  void group(std::string_view key, P& params, std::string_view doc) {
    if (begin_group(key, doc)) {
      if constexpr (requires { P::describe(*this, params); }) {
        P::describe(*this, params);
      } else {
        describe(*this, params);
      }
      end_group();
    }
  }

  /// An ordered list of plain blocks, each described as by group().
  template <class P>
  void groups(std::string_view key, std::vector<P>& blocks, std::string_view doc) {
    const std::optional<ListPlan> plan = begin_list(key, blocks.size(), doc);
    if (!plan) return;
    if (plan->fresh) blocks.assign(plan->count, P{});
    for (std::size_t i = 0; i < plan->count; ++i) {
      if (!begin_item(i)) continue;
      if constexpr (requires { P::describe(*this, blocks[i]); }) {
        P::describe(*this, blocks[i]);
      } else {
        describe(*this, blocks[i]);
      }
      end_group();
    }
    end_list();
  }
  /// A part whose keys the reader of the file gives meaning to (the settings of a study). Absent stays as it is.
  virtual void tree(std::string_view key, Node& value, std::string_view doc) = 0;

  /// A key that existed once: using it is an error that names the replacement ("use frame_length").
  virtual void removed(std::string_view key, std::string_view advice) = 0;
  /// Cross-check; on failure an error at `key` with `message`.
  virtual void require(bool ok, std::string_view key, std::string_view message) = 0;

 protected:
  virtual void choice_index(std::string_view key, std::size_t& index, const std::vector<std::string>& names,
                            std::string_view doc) = 0;
  /// The validated recipe; null when this binder does not parse, or the block had errors (already reported).
  virtual std::shared_ptr<const StageRecipe> stage_recipe(std::string_view key, std::string_view family,
                                                          std::string_view default_type, std::string_view doc) = 0;
  virtual std::optional<std::vector<std::shared_ptr<const StageRecipe>>> stage_recipes(
      std::string_view key, std::string_view family, const std::vector<std::string>& default_types,
      std::string_view doc) = 0;
  virtual bool begin_group(std::string_view key, std::string_view doc) = 0;
  virtual void end_group() = 0;
  /// How many blocks of a list to describe, and whether they start from their defaults.
  struct ListPlan {
    std::size_t count = 0;
    bool fresh = false;
  };
  virtual std::optional<ListPlan> begin_list(std::string_view key, std::size_t size, std::string_view doc) = 0;
  /// Closed by end_group().
  virtual bool begin_item(std::size_t index) = 0;
  virtual void end_list() = 0;
};

}  // namespace aslio::config
