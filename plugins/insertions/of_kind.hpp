#pragma once

#include <algorithm>
#include <iterator>
#include <span>
#include <vector>

#include "aslio/stages/points.hpp"

namespace aslio::plugins {

/// The points of one feature_class::kind: the batch itself where it holds no other, else a copy in `storage`.
inline std::span<const WorldPoint> of_kind(std::span<const WorldPoint> points, std::uint8_t kind,
                                           std::vector<WorldPoint>& storage) {
  const auto belongs = [kind](const WorldPoint& point) { return feature_class::kind(point.feature) == kind; };
  if (std::all_of(points.begin(), points.end(), belongs)) return points;
  storage.clear();
  std::copy_if(points.begin(), points.end(), std::back_inserter(storage), belongs);
  return storage;
}

}  // namespace aslio::plugins
