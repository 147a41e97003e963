#pragma once
/// A smooth line that ends where it begins, cheap to follow.

#include <vector>

#include "aslio/simulator/ground.hpp"
#include "aslio/simulator/mesh.hpp"
#include "aslio/simulator/route.hpp"

namespace aslio::simulator {

/// Cubic pieces between knots at equal distances along the line; continuous in position and direction.
class ClosedLine {
 public:
  /// A polygon whose corners are rounded by averaging over `rounding` to either side [m], laid on the ground.
  ClosedLine(const std::vector<Vec2>& polygon, double rounding, const Ground& ground);

  struct Place {
    Vec3 at = Vec3::Zero();          ///< on the ground
    Vec2 direction = Vec2::UnitX();  ///< unit vector in the plan
  };
  /// `s` metres along the line; any real number, rounds repeat.
  Place at(double s) const;
  /// In the plan [m].
  double length() const { return spacing_ * static_cast<double>(knots_.size()); }
  /// Where the line comes nearest to a point while it goes the same way as `direction` [m].
  double nearest(const Vec2& p, const Vec2& direction) const;

 private:
  struct Knot {
    Vec3 at, slope;  ///< slope per piece
  };
  std::vector<Knot> knots_;
  double spacing_ = 1;
};

/// The line beside a route, `lateral` metres to its left (negative: right). Round the outside of corners and ends, cut
/// on the inside.
std::vector<Vec2> beside(const Route& route, double lateral);

}  // namespace aslio::simulator
