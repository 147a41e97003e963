#pragma once
/// What the summary of any run says of its measuring.

#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "aslio/evaluation/evaluation.hpp"

namespace aslio::experiment {

/// The block `metrics` of summary.json; null is what was not measured.
nlohmann::ordered_json metrics_json(const std::optional<evaluation::Evaluation>& evaluation,
                                    const std::optional<double>& end_to_end_m, const std::optional<double>& failed_at,
                                    const std::string& error);

/// Why an error is one that no table may show as a good run, whatever the run itself says; empty: it is none.
std::string off_reference(const std::optional<evaluation::Evaluation>& evaluation);

}  // namespace aslio::experiment
