#include <algorithm>
#include <cmath>
#include <iterator>

#include "aslio/core/angles.hpp"
#include "aslio/evaluation/evaluation.hpp"

namespace aslio::evaluation {

namespace {

/// A pair is taken when its length is within this share of the one asked for, as evo does.
constexpr double kTolerance = 0.1;

/// The first after `i` of those nearest to `target`. `place` never falls, and stays where nothing moves.
std::size_t nearest_after(std::size_t i, std::span<const double> place, double target) {
  const auto first = place.begin() + static_cast<std::ptrdiff_t>(i) + 1;
  auto found = std::lower_bound(first, place.end(), target);
  if (found == place.end() || (found != first && target - *std::prev(found) <= *found - target)) --found;
  return static_cast<std::size_t>(std::lower_bound(first, place.end(), *found) - place.begin());
}

/// Errors over pairs (i, j) where j is the sample whose `place` is nearest to place_i + delta. eq. EVAL-11
RelativeError relative_error(std::span<const PosePair> pairs, std::span<const double> weights,
                             std::span<const double> place, double delta) {
  RelativeError result;
  result.delta = delta;
  double total = 0.0, translation = 0.0, rotation = 0.0;
  for (std::size_t i = 0; i + 1 < pairs.size(); ++i) {
    const double target = place[i] + delta;
    if (target > place.back() + 1e-6 * delta) break;  // would end before the trajectory has gone that far
    const std::size_t j = nearest_after(i, place, target);
    if (std::abs(place[j] - target) > kTolerance * delta) continue;
    const Pose truth = pairs[i].reference.inverse() * pairs[j].reference;
    const Pose error = truth.inverse() * (pairs[i].estimate.inverse() * pairs[j].estimate);
    total += weights[i];
    translation += weights[i] * error.p.squaredNorm();
    rotation += weights[i] * log_so3(error.R).squaredNorm();
    ++result.pairs;
  }
  if (total > 0.0) {
    result.translation_rmse = std::sqrt(translation / total);
    result.rotation_rmse = kDegPerRad * std::sqrt(rotation / total);
  }
  return result;
}

}  // namespace

RelativeError relative_error_over_distance(std::span<const PosePair> pairs, std::span<const double> weights,
                                           double delta) {
  std::vector<double> path(pairs.size(), 0.0);
  for (std::size_t i = 1; i < pairs.size(); ++i) {
    path[i] = path[i - 1] + (pairs[i].reference.p - pairs[i - 1].reference.p).norm();
  }
  RelativeError result = relative_error(pairs, weights, path, delta);
  result.unit = DeltaUnit::metres;
  return result;
}

RelativeError relative_error_over_time(std::span<const PosePair> pairs, std::span<const double> weights, double delta) {
  std::vector<double> time(pairs.size());
  for (std::size_t i = 0; i < pairs.size(); ++i) time[i] = to_seconds(pairs[i].t - pairs.front().t);
  RelativeError result = relative_error(pairs, weights, time, delta);
  result.unit = DeltaUnit::seconds;
  return result;
}

}  // namespace aslio::evaluation
