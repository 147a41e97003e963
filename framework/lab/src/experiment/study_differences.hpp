#pragma once
/// Whether `differs` of a study names what there is.

#include <map>
#include <string>
#include <vector>

#include "aslio/experiment/study.hpp"

namespace aslio::experiment {

/// Of `names`, those that are neither a key nor a block of any method's resolved pipeline, each with the key or block
/// that was probably meant (empty: nothing is near).
std::map<std::string, std::string> strange_keys(const std::vector<StudyMethod>& methods,
                                                const std::vector<std::string>& names);

}  // namespace aslio::experiment
