#pragma once
/// The line that a car drives: straights and bends, known at any distance along it.

#include <vector>

#include "aslio/simulator/mesh.hpp"

namespace aslio::simulator {

/// From the first to the last of some points, an open line. Every corner between them becomes a bend whose heading
/// follows the septic step of the way: four times continuously differentiable. Straight on beyond both ends.
class RoadLine {
 public:
  /// Of a bend, the curvature's peak over its mean.
  static constexpr double kPeak = 2.1875;

  struct Bend {
    double begin = 0, length = 0;  ///< along the line [m]
    double angle = 0;              ///< change of heading, positive to the left [rad]
    double radius() const;         ///< the tightest one [m]
  };
  struct Place {
    Vec2 at = Vec2::Zero();
    double heading = 0;          ///< [rad]
    double curvature = 0;        ///< positive to the left [1/m]
    double curvature_slope = 0;  ///< by the way [1/m^2]
    /// `lateral` metres to the left of the line.
    Vec2 beside(double lateral) const;
  };

  /// `bend_radius` is the tightest radius [m] of the bends; a bend takes at most half of the edges that it joins and is
  /// tighter where they are short. Throws ConfigError for fewer than 2 points, an edge shorter than 1 m or a corner
  /// sharper than 150 deg.
  RoadLine(const std::vector<Vec2>& points, double bend_radius);

  /// `s` metres along the line from its first point; any real number.
  Place at(double s) const;
  double length() const { return length_; }  ///< [m]
  const std::vector<Bend>& bends() const { return bends_; }

 private:
  /// A straight (angle 0, no knots) or a bend, from `begin` on.
  struct Piece {
    double begin = 0, length = 0, heading = 0, angle = 0;
    Vec2 from = Vec2::Zero();
    std::vector<Vec2> knots;  ///< of a bend, at equal distances
  };
  void add_straight(double length);
  void add_bend(double length, double angle);
  Place on(const Piece& piece, double along) const;

  std::vector<Piece> pieces_;
  std::vector<Bend> bends_;
  double length_ = 0, heading_ = 0;  ///< while the line grows
  Vec2 end_ = Vec2::Zero();
};

}  // namespace aslio::simulator
