#pragma once

#include <optional>
#include <vector>

#include "aslio/experiment/summary.hpp"

namespace aslio::experiment {

/// Nothing when fewer than three poses have a reference.
std::optional<Accuracy> measure_accuracy(const std::vector<StampedPose>& estimate, const Trajectory& reference);

}  // namespace aslio::experiment
