#pragma once
/// The points of one class of the last sweep, and what a point of the next one matches among them (LOAM, scan to scan).

#include <span>
#include <vector>

#include "aslio/core/lie.hpp"
#include "aslio/stages/points.hpp"
#include "aslio/stages/surface.hpp"

namespace aslio::plugins {

/// Points in cells of 1 m, searched in growing shells. All storage is reused.
class SweepIndex {
 public:
  struct Reach {
    double distance = 5.0;  ///< the nearest point lies within it [m]
    int lines = 2;          ///< scan lines that count as near to each other
  };

  explicit SweepIndex(const Reach& reach) : reach_(reach) {}
  /// The points of class `feature` among `points`; those that are not finite or 2^20 m away are left out.
  void build(std::span<const WorldPoint> points, std::uint8_t feature);
  void clear() { entries_.clear(), keys_.clear(), begins_.clear(); }
  std::size_t size() const { return entries_.size(); }

  /// The line through the nearest point and the nearest one of another, near scan line. eq. SWP-1
  Surface line(const Vec3& query) const;
  /// The plane through the nearest point, the nearest other one of its scan line, and the nearest one of another, near
  /// scan line. eq. SWP-1
  Surface plane(const Vec3& query) const;

 private:
  struct Entry {
    Vec3 p = Vec3::Zero();
    std::uint64_t key = 0;
    std::uint32_t order = 0;
    std::uint8_t line = 0;
  };

  template <class Admit>
  const Entry* nearest(const Vec3& query, const Admit& admit) const;
  bool near_other_line(const Entry& a, const Entry& b) const;

  Reach reach_;
  std::vector<Entry> entries_;         ///< by cell, then in the order given
  std::vector<std::uint64_t> keys_;    ///< cells that hold points, ascending
  std::vector<std::uint32_t> begins_;  ///< [cell], into entries_; one more at the end
};

}  // namespace aslio::plugins
