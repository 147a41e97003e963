#pragma once
/// What a template asks its user to write, where it is still there.

#include <string>
#include <vector>

#include "aslio/experiment/study.hpp"

namespace aslio::experiment {

/// One text for each of question, prediction and rule that still is a request of a template ("Write here ..", as
/// `aslio new-plugin` writes it), with file, line and remedy. Reads the file of the study again; throws ConfigError
/// where that is gone.
std::vector<std::string> placeholder_warnings(const Study& study);

}  // namespace aslio::experiment
