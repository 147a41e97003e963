#pragma once
/// Round columns, bent bars and profiles swept along a curve. Curves are tessellated so that a chord is nowhere farther
/// from its arc than kChordError.

#include <span>
#include <vector>

#include "aslio/simulator/mesh.hpp"

namespace aslio::simulator::curved {

/// Largest distance between an arc and the chord that stands for it [m].
inline constexpr double kChordError = 0.0015;

/// Sides of a whole circle of this radius [m], at least `least`.
int sides_of(double radius, int least = 24);
/// Points on an arc from one angle to another [rad], both included.
std::vector<Vec2> arc(const Vec2& centre, double radius, double from, double to);

/// Where a profile stands while it is swept: `along` is a level unit vector.
struct Station {
  Vec3 at = Vec3::Zero();  ///< [m]
  Vec2 along = Vec2::UnitX();
};
/// Surface of an open line (x: to the left of the way, y: up) that moves from station to station. Ends stay open.
void sweep(MeshBuilder& builder, std::span<const Vec2> profile, std::span<const Station> stations,
           std::uint8_t reflectivity);

/// Round pillar or tapered tower with its caps; `least` sides.
void add_column(MeshBuilder& builder, const Vec3& foot, double foot_radius, double top_radius, double height,
                std::uint8_t reflectivity, int least = 32);

/// One end of a piece of a bent round bar.
struct Ring {
  Vec3 at = Vec3::Zero();  ///< [m]
  double radius = 0.1;     ///< [m]
};
/// Bar with `sides` faces through rings, in any direction; closed at both ends.
void add_bar(MeshBuilder& builder, std::span<const Ring> rings, int sides, std::uint8_t reflectivity);
/// Straight bar with as many sides as its radius needs.
void add_bar(MeshBuilder& builder, const Vec3& from, const Vec3& to, double radius, std::uint8_t reflectivity);

}  // namespace aslio::simulator::curved
