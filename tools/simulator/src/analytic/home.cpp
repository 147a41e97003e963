#include "home.hpp"

#include <cmath>
#include <numbers>

#include "aslio/core/angles.hpp"

namespace aslio::simulator::home {
namespace {

constexpr double kFloor = -1.4, kCeiling = 1.6, kLintel = 0.7;
constexpr double kWallReflectivity = 0.6, kWoodReflectivity = 0.35;

Box wall(double x0, double x1, double y0, double y1, double z0 = kFloor) {
  return box_between({x0, y0, z0}, {x1, y1, kCeiling}, kWallReflectivity);
}

/// Furniture that stands on the floor.
Box standing(double x, double y, double length, double width, double height, double yaw = 0) {
  return {{x, y, kFloor + height / 2}, {length / 2, width / 2, height / 2}, yaw, kWoodReflectivity};
}

/// Moves smoothly to and fro.
Box person(const Vec3& from, const Vec3& to, double period, double t) {
  const double u = 0.5 - 0.5 * std::cos(2 * std::numbers::pi * t / period);
  Box box = standing(0, 0, 0.35, 0.5, 1.75);
  box.centre.head<2>() = (from + u * (to - from)).head<2>();
  box.reflectivity = 0.25;
  return box;
}

void add_walls(std::vector<Box>& out) {
  // First room: x -3..9, y -4..4.
  for (const Box& b : {wall(-3.2, -3, -4.2, 4.2), wall(9, 9.2, -4.2, 4.2), wall(-3.2, 9.2, -4.2, -4)}) out.push_back(b);
  // Between it and the corridor: doors at x -0.6..0.6 and 4.5..5.7.
  for (const Box& b : {wall(-6.2, -0.6, 4, 4.2), wall(0.6, 4.5, 4, 4.2), wall(5.7, 14.2, 4, 4.2)}) out.push_back(b);
  for (const Box& b : {wall(-0.6, 0.6, 4, 4.2, kLintel), wall(4.5, 5.7, 4, 4.2, kLintel)}) out.push_back(b);
  // Corridor: x -6..14, y 4.2..6.4; door to the second room at x 1.9..3.1.
  for (const Box& b : {wall(-6.2, 1.9, 6.4, 6.6), wall(3.1, 14.2, 6.4, 6.6), wall(1.9, 3.1, 6.4, 6.6, kLintel)})
    out.push_back(b);
  for (const Box& b : {wall(-6.2, -6, 4, 6.6), wall(14, 14.2, 4, 6.6)}) out.push_back(b);
  // Second room: x -1..7, y 6.6..12.
  for (const Box& b : {wall(-1.2, -1, 6.4, 12.2), wall(7, 7.2, 6.4, 12.2), wall(-1.2, 7.2, 12, 12.2)}) out.push_back(b);
  out.push_back(box_between({-7, -5, kFloor - 0.2}, {15, 13, kFloor}, 0.3));
  out.push_back(box_between({-7, -5, kCeiling}, {15, 13, kCeiling + 0.2}, 0.8));
}

}  // namespace

std::vector<Box> solids() {
  std::vector<Box> out;
  add_walls(out);
  for (const Box& b : {
           standing(2.8, -2.6, 1.6, 0.8, 0.75),
           standing(8.7, -1.6, 0.6, 2.8, 2.0),
           standing(2.2, 3.7, 1.4, 0.6, 1.8),
           standing(6.6, -1.8, 1.0, 0.7, 0.9, 0.52),
           standing(-1.6, -2.6, 1.9, 0.8, 0.8, -0.3),
           standing(7.7, 2.6, 1.2, 0.5, 1.5, 0.3),
           standing(3.2, 1.9, 0.4, 0.4, 3.0),
           standing(-2.6, 2.4, 0.6, 1.4, 1.2),
           standing(7.6, 6.2, 0.9, 0.4, 1.9),
           standing(10.8, 4.45, 1.4, 0.5, 0.5),
           standing(-3.2, 4.4, 0.4, 0.4, 3.0),
           standing(-4.6, 6.1, 0.7, 0.5, 1.1, 0.2),
           standing(4.6, 11.0, 1.6, 0.9, 0.75, 0.4),
           standing(-0.7, 9.5, 0.5, 2.2, 2.1),
           standing(1.2, 10.6, 0.7, 0.7, 1.0, -0.5),
       })
    out.push_back(b);
  return out;
}

Walk walk(double time_scale) {
  std::vector<Waypoint> waypoints = {
      {1.0, 0, 0, 0, 0},          {3.0, 2.2, 0, 1.5, 0},     {5.0, 5.0, 0.4, 0.6, 0.7},    {7.0, 5.1, 2.8, 0, 1.4},
      {9.0, 5.0, 5.2, -0.7, 0.3}, {11.5, 2.6, 5.3, -0.9, 0}, {14.0, 0.1, 5.1, -0.5, -0.6}, {16.0, 0, 3.0, 0, -1.3},
      {19.0, 0, 0, 0, 0},
  };
  std::vector<Turn> turns = {
      {4.65, 0.70, 90 * kRadPerDeg},   // in front of the first door: the corridor comes into view
      {8.66, 0.68, 90 * kRadPerDeg},   // along the corridor
      {10.9, 0.80, -85 * kRadPerDeg},  // a look into the second room ..
      {11.9, 0.80, 85 * kRadPerDeg},   // .. and back
      {13.7, 0.66, 90 * kRadPerDeg},   // through the other door
      {17.0, 1.40, 90 * kRadPerDeg},   // as at the start
  };
  return Walk(std::move(waypoints), std::move(turns), Gait{}, time_scale);
}

std::vector<Box> people(double t) {
  return {person({7.5, -0.5, 0}, {2.0, -1.4, 0}, 14, t), person({-4.5, 5.0, 0}, {-1.2, 5.6, 0}, 9, t)};
}

}  // namespace aslio::simulator::home
