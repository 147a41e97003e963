#pragma once

#include <algorithm>
#include <iterator>
#include <span>
#include <vector>

#include "aslio/stages/map.hpp"

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

/// Hands the points of each kind to `insert(points, kind)`, which returns how many have entered.
template <class Insert>
InsertCount insert_by_kind(std::span<const WorldPoint> points, std::vector<WorldPoint>& storage, const Insert& insert) {
  InsertCount count{points.size(), 0};
  for (const std::uint8_t kind : {feature_class::plane, feature_class::line}) {
    const auto own = of_kind(points, kind, storage);
    if (!own.empty()) count.inserted += insert(own, kind);
  }
  return count;
}

}  // namespace aslio::plugins
