#include "study_methods.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

namespace aslio::experiment {

std::optional<std::size_t> find_method(const Study& study, const std::string& name) {
  for (std::size_t i = 0; i < study.methods.size(); ++i) {
    if (study.methods[i].name == name) return i;
  }
  return std::nullopt;
}

std::optional<std::size_t> find_variant(const Study& study, const std::string& name,
                                        const std::vector<std::string>& axes) {
  for (std::size_t i = 0; i < study.methods.size(); ++i) {
    if (study.methods[i].base == name && study.methods[i].axes == axes) return i;
  }
  return find_method(study, name);
}

std::string method_names(const Study& study) {
  std::vector<std::string> names;
  for (const StudyMethod& method : study.methods) {
    if (std::find(names.begin(), names.end(), method.base) == names.end()) names.push_back(method.base);
  }
  return names.empty() ? "none" : fmt::format("{}", fmt::join(names, ", "));
}

}  // namespace aslio::experiment
