#pragma once

#include <string>
#include <vector>

#include "aslio/config/description.hpp"

namespace aslio::config {

/// Writes down what a describe() declares; touches no value.
class DescribeBinder final : public Binder {
 public:
  Description take() { return std::move(found_); }

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
  void require(bool, std::string_view, std::string_view) override {}

 protected:
  void choice_index(std::string_view key, std::size_t& index, const std::vector<std::string>& names,
                    std::string_view doc) override;
  std::shared_ptr<const StageRecipe> stage_recipe(std::string_view key, std::string_view family,
                                                  std::string_view default_type, std::string_view doc) override;
  std::optional<std::vector<std::shared_ptr<const StageRecipe>>> stage_recipes(
      std::string_view key, std::string_view family, const std::vector<std::string>& default_types,
      std::string_view doc) override;
  bool begin_group(std::string_view key, std::string_view doc) override;
  void end_group() override { prefix_.pop_back(); }
  std::optional<ListPlan> begin_list(std::string_view key, std::size_t size, std::string_view doc) override;
  bool begin_item(std::size_t index) override;
  void end_list() override { prefix_.pop_back(); }

 private:
  std::string path(std::string_view key) const;
  void add(std::string_view key, std::string type, std::string_view unit, const Range& range, std::string default_value,
           std::string_view doc);

  Description found_;
  std::vector<std::string> prefix_;
};

}  // namespace aslio::config
