#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "aslio/stages/points.hpp"

namespace aslio::plugins {

/// The points of the last updates, in time order, until they leave the window.
class WindowPoints {
 public:
  /// Pre: in time order, all later than those held; `sequence` is the update that measured them.
  void append(std::span<const WorldPoint> points, std::uint32_t sequence) {
    points_.insert(points_.end(), points.begin(), points.end());
    if (!points.empty()) slices_.push_back({sequence, points_.size()});
  }

  /// Calls take(points, sequence) for what is no later than `until`, update by update, and lets go of it.
  template <class Take>
  void leave(TimeNs until, Take take) {
    std::size_t done = 0;
    for (const Slice& slice : slices_) {
      const std::size_t begin = head_;
      while (head_ < slice.end && points_[head_].t <= until) ++head_;
      if (head_ > begin) take(std::span(points_).subspan(begin, head_ - begin), slice.sequence);
      if (head_ < slice.end) break;
      ++done;
    }
    slices_.erase(slices_.begin(), slices_.begin() + static_cast<std::ptrdiff_t>(done));
    if (head_ <= points_.size() / 2) return;
    points_.erase(points_.begin(), points_.begin() + static_cast<std::ptrdiff_t>(head_));
    for (Slice& slice : slices_) slice.end -= head_;
    head_ = 0;
  }

  void clear() {
    points_.clear();
    slices_.clear();
    head_ = 0;
  }

  std::span<const WorldPoint> inside() const { return std::span(points_).subspan(head_); }

 private:
  /// Points of one update.
  struct Slice {
    std::uint32_t sequence = 0;
    std::size_t end = 0;  ///< in points_
  };

  std::vector<WorldPoint> points_;  ///< those before head_ have left
  std::vector<Slice> slices_;
  std::size_t head_ = 0;
};

}  // namespace aslio::plugins
