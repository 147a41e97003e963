#pragma once
/// Interiors as unions of axis-parallel rooms: walls, floors and ceilings follow from where the rooms end.

#include <vector>

#include "aslio/simulator/mesh.hpp"
#include "aslio/simulator/route.hpp"

namespace aslio::simulator::indoor {

/// Thickness of a wall with a door in it [m].
inline constexpr double kWall = 0.15;
/// Top of door openings [m].
inline constexpr double kDoorHead = 2.25;

/// Upright rectangle in the plan [m].
struct Rect {
  Vec2 low = Vec2::Zero(), high = Vec2::Zero();
  Rect grown(double by) const { return {low.array() - by, high.array() + by}; }
  Vec2 centre() const { return 0.5 * (low + high); }
  Vec2 size() const { return high - low; }
  /// Common area, beyond touching by a tenth of a millimetre.
  bool overlaps(const Rect& other) const;
  bool contains(const Vec2& p) const;
};

/// Straight part of a route with the edges on the same line that touch or overlap.
struct Run {
  int axis = 0;           ///< 0: along x
  double at = 0;          ///< the other coordinate [m]
  double lo = 0, hi = 0;  ///< along the axis [m]

  Vec2 point(double along, double across = 0) const;
  /// From `begin` to `end` along the run, from `right` to `left` of it in the sense of +axis x +other axis.
  Rect rect(double begin, double end, double right, double left) const;
};

/// Runs in order of axis, line, begin. Throws ConfigError, naming the edge, when one is not parallel to an axis.
std::vector<Run> runs_of(const Route& route, const char* world);

/// What furniture must leave free: `by` round the line and a bit more at the corners, which a walk cuts.
std::vector<Rect> clear_zones(const Route& route, double by);

/// Free space: everything else is solid.
struct Space {
  Rect area;
  double floor = 0, ceiling = 2.7;  ///< [m]
};

/// Wall between two heights, seen from the side of its normal.
struct WallFace {
  Vec2 a = Vec2::Zero(), b = Vec2::Zero();
  Vec2 normal = Vec2::UnitX();
  double low = 0, high = 0;
  double length() const { return (b - a).norm(); }
};

/// Spaces, in millimetres so that walls meant to be one are one.
class FloorPlan {
 public:
  void add(const Space& space);
  /// Whether any space has area in common with `area`.
  bool meets(const Rect& area) const;
  const std::vector<Space>& spaces() const { return spaces_; }

 private:
  std::vector<Space> spaces_;
};

/// The union of a plan's spaces on the grid of all their coordinates. A cell reaches from the lowest floor to the
/// highest ceiling of the spaces that cover it.
class PlanGrid {
 public:
  explicit PlanGrid(const FloorPlan& plan);

  /// Whether all of `area` is free between the heights.
  bool free(const Rect& area, double low, double high) const;
  /// Every surface between free and solid that stands upright, in merged runs.
  std::vector<WallFace> walls() const;

  struct Surfaces {
    std::uint8_t wall = material::kPlaster, floor = 60, ceiling = material::kWhitePaint;
  };
  /// Adds walls, floors and ceilings.
  void build(MeshBuilder& builder, const Surfaces& surfaces) const;

 private:
  struct Cell {
    double floor = 0, ceiling = 0;  ///< equal: solid
    bool solid() const { return ceiling <= floor; }
  };
  Cell cell(int i, int j) const;
  void add_walls(int axis, std::vector<WallFace>& faces) const;
  /// Merged rectangles of equal height; `ceiling` chooses which.
  void add_slabs(MeshBuilder& builder, bool ceiling, std::uint8_t reflectivity) const;

  std::vector<double> x_, y_;
  std::vector<Cell> cells_;
};

/// What stands where: nothing twice, nothing in walls, nothing in the way.
class Site {
 public:
  Site(const PlanGrid& grid, std::vector<Rect> keep_clear) : grid_(&grid), taken_(std::move(keep_clear)) {}
  /// Takes the area when it is free up to `height` [m].
  bool claim(const Rect& area, double height = 2.0);
  /// As claim(), of a rectangle in a placement turned by a multiple of 90 deg.
  bool claim(const Placement& placement, const Vec2& low, const Vec2& high, double height = 2.0);
  /// Keeps an area free.
  void reserve(const Rect& area) { taken_.push_back(area); }
  const PlanGrid& grid() const { return *grid_; }

 private:
  const PlanGrid* grid_;
  std::vector<Rect> taken_;
};

/// Frame at `at` on a wall: y along the normal, x along the wall.
Placement at_wall(const Vec2& at, const Vec2& normal);
/// Frame of a face whose x runs from 0 to its length.
Placement at_wall(const WallFace& face);

/// An opening of `width` in a wall, or a closed leaf in a recess.
struct Door {
  Vec2 at = Vec2::Zero();       ///< middle of the opening, on the wall face of the side of `normal`
  Vec2 normal = Vec2::UnitX();  ///< out of the wall
  double width = 0.9, depth = kWall;
  bool open = true;
  double swing = 1.7;      ///< of the leaf [rad]; 0 is closed
  bool hinge_left = true;  ///< seen along the normal's opposite

  /// The opening, or the recess of 0.1 m.
  Rect area() const;
};
/// Its opening or recess.
void add_door(FloorPlan& plan, const Door& door);
/// Frame, handle, and the open leaf on the far side where there is room for it.
void build_door(MeshBuilder& builder, Site& site, const Door& door);

/// Niches in those walls of rooms behind which nothing lies; the panes for build_windows().
std::vector<Rect> add_windows(FloorPlan& plan, const std::vector<Rect>& rooms, double ceiling);
void build_windows(MeshBuilder& builder, const std::vector<Rect>& panes, double ceiling);

}  // namespace aslio::simulator::indoor
