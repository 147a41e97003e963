#pragma once
/// Methods of a study by their names.

#include <optional>
#include <string>
#include <vector>

#include "aslio/experiment/study.hpp"

namespace aslio::experiment {

std::optional<std::size_t> find_method(const Study& study, const std::string& name);

/// The method of this name, or the variant of the method of this name at the same values of all axes.
std::optional<std::size_t> find_variant(const Study& study, const std::string& name,
                                        const std::vector<std::string>& axes);

/// Names without suffixes, each once, with commas between; "none" where there is none.
std::string method_names(const Study& study);

}  // namespace aslio::experiment
