#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "aslio/evaluation/association.hpp"

namespace aslio::evaluation {

/// In the unit of the values.
struct Statistics {
  std::size_t n = 0;
  double rmse = 0, mean = 0, median = 0, std = 0, min = 0, max = 0;
};

/// Weighted statistics; weights >= 0, not all zero. std divides by the sum of weights. With equal weights they are the
/// usual ones, the median of an even number being the mean of the middle two. Nothing of nothing: n = 0. eq. EVAL-7
Statistics weighted_statistics(std::span<const double> values, std::span<const double> weights);

/// The time [s] each pair stands for: half the gap to either neighbour, gaps counted up to `max_gap`. So a method that
/// emits more poses in turns is not judged by its turns. A single pair weighs 1. eq. EVAL-8
std::vector<double> time_weights(std::span<const PosePair> pairs, TimeNs max_gap);

}  // namespace aslio::evaluation
