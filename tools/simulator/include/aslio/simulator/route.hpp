#pragma once
/// Where a walk goes: a closed line in the plan, from the start through its corners and back.

#include <vector>

#include "aslio/simulator/mesh.hpp"

namespace aslio::simulator {

/// A closed polygon. Point 0 is the start, where the walk ends as well; the others are corners (a point on a straight
/// edge is allowed). An edge may be walked in both directions (out and back).
class Route {
 public:
  /// Throws ConfigError for fewer than 2 points or an edge shorter than 1 m.
  explicit Route(std::vector<Vec2> points);

  struct Place {
    Vec2 at = Vec2::Zero();
    Vec2 direction = Vec2::UnitX();  ///< unit vector along the edge
  };
  const std::vector<Vec2>& points() const { return points_; }
  /// Of the whole round [m].
  double length() const { return length_; }
  /// `s` metres along the line; any real number, rounds repeat.
  Place at(double s) const;
  /// Distance of a point to the line [m].
  double distance(const Vec2& p) const;
  /// The smallest upright rectangle round the line.
  Vec2 low() const;
  Vec2 high() const;

 private:
  std::vector<Vec2> points_;
  std::vector<double> start_of_edge_;
  double length_ = 0;
};

}  // namespace aslio::simulator
