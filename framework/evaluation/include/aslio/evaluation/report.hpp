#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "aslio/evaluation/evaluation.hpp"

namespace aslio::evaluation {

/// Flat headline figures first (ate_m, ate_deg, end_to_end_m, matched, covered), then everything. Keys carry units.
nlohmann::ordered_json to_json(const Evaluation& evaluation);

/// An aligned table for a terminal, ends with a newline.
std::string to_text(const Evaluation& evaluation);

}  // namespace aslio::evaluation
