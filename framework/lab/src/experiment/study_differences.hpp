#pragma once
/// Whether `differs` of a study names what there is.

#include "aslio/config/node.hpp"
#include "aslio/config/problems.hpp"
#include "aslio/experiment/study.hpp"

namespace aslio::experiment {

/// Adds a problem for each name in `differs`, of the study or of a method, that is neither a key nor a block of any
/// method's resolved pipeline: it would excuse nothing, and tables would tell it as what is compared. `root`: the file.
void require_known_differences(const Study& study, const config::Node& root, config::Problems& problems);

}  // namespace aslio::experiment
