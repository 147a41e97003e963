#include "worlds/facade.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "worlds/curved.hpp"

namespace aslio::simulator::outdoor {
namespace {

namespace m = material;

constexpr double kPi = std::numbers::pi;
constexpr double kArcade = 2.2;  // from the columns to the wall behind them [m]
constexpr double kArcadeWall = 0.45;
constexpr double kCornice = 0.22;  // out of the front [m]

/// Part of a front: along it (u), up (z).
struct Cell {
  double u0 = 0, u1 = 0, z0 = 0, z1 = 0;
};
struct Opening {
  Cell hole;
  double depth = 0.2;  ///< of the reveal [m]
  bool arched = false;
  std::uint8_t pane = m::kGlass;
  bool open = false;  ///< without a pane
};

/// Surfaces in the coordinates of the front: u from its left end to the right one along its line, z up, d inwards.
class Front {
 public:
  Front(MeshBuilder& builder, const FrontShape& shape, std::uint8_t reflectivity)
      : builder_(builder), reflectivity_(reflectivity), half_(0.5 * shape.width) {
    if (std::abs(shape.bow) < 1e-6) return;
    // Circle through both ends and the middle.
    const double bow = std::abs(shape.bow);
    radius_ = (half_ * half_ + bow * bow) / (2 * bow);
    centre_ = shape.bow > 0 ? radius_ - bow : -(radius_ - bow);
    out_ = shape.bow > 0 ? -1 : 1;
    half_angle_ = std::asin(std::min(1.0, half_ / radius_));
    step_ = 2 * radius_ * std::acos(1 - curved::kChordError / radius_);
  }

  double length() const { return radius_ > 0 ? 2 * half_angle_ * radius_ : 2 * half_; }
  Vec3 at(double u, double z, double d) const {
    if (radius_ <= 0) return {u - half_, d, z};
    const double angle = u / radius_ - half_angle_, r = radius_ + out_ * d;
    return {r * std::sin(angle), centre_ + out_ * r * std::cos(angle), z};
  }
  /// Upright at one depth.
  void panel(const Cell& c, double d, std::uint8_t reflectivity) {
    strips(c.u0, c.u1, [&](double a, double b) {
      builder_.quad(at(a, c.z0, d), at(b, c.z0, d), at(b, c.z1, d), at(a, c.z1, d), reflectivity);
    });
  }
  /// Level, between two depths.
  void shelf(double u0, double u1, double z, double d0, double d1, std::uint8_t reflectivity) {
    strips(u0, u1, [&](double a, double b) {
      builder_.quad(at(a, z, d0), at(b, z, d0), at(b, z, d1), at(a, z, d1), reflectivity);
    });
  }
  /// From one line to another.
  void slope(double z0, double d0, double z1, double d1, std::uint8_t reflectivity) {
    strips(0, length(), [&](double a, double b) {
      builder_.quad(at(a, z0, d0), at(b, z0, d0), at(b, z1, d1), at(a, z1, d1), reflectivity);
    });
  }
  /// Stands out of the front.
  void block(const Cell& c, double out, std::uint8_t reflectivity) {
    panel(c, -out, reflectivity);
    shelf(c.u0, c.u1, c.z0, -out, 0, reflectivity);
    shelf(c.u0, c.u1, c.z1, -out, 0, reflectivity);
    for (const double u : {c.u0, c.u1}) jamb(u, c.z0, c.z1, -out, 0, reflectivity);
  }
  void jamb(double u, double z0, double z1, double d0, double d1, std::uint8_t reflectivity) {
    builder_.quad(at(u, z0, d0), at(u, z0, d1), at(u, z1, d1), at(u, z1, d0), reflectivity);
  }
  /// The wall of a cell about an opening, and its reveal.
  void wall_with(const Cell& cell, const Opening& opening);

 private:
  template <class Add>
  void strips(double u0, double u1, const Add& add) const {
    const int pieces = std::max(1, static_cast<int>(std::ceil((u1 - u0) / step_ - 1e-9)));
    for (int k = 0; k < pieces; ++k) add(u0 + (u1 - u0) * k / pieces, u0 + (u1 - u0) * (k + 1) / pieces);
  }
  void add_arch(const Cell& cell, const Opening& opening, double spring);

  MeshBuilder& builder_;
  std::uint8_t reflectivity_;
  double half_;
  double radius_ = 0, centre_ = 0, out_ = 1, half_angle_ = 0;
  double step_ = std::numeric_limits<double>::infinity();
};

/// Between the arc and the top of the cell, and the inner side of the arc.
void Front::add_arch(const Cell& cell, const Opening& opening, double spring) {
  const double r = 0.5 * (opening.hole.u1 - opening.hole.u0), mid = opening.hole.u0 + r;
  const std::vector<Vec2> points = curved::arc({mid, spring}, r, kPi, 0);
  for (std::size_t k = 1; k < points.size(); ++k) {
    const Vec2 &p = points[k - 1], &q = points[k];
    builder_.quad(at(p.x(), p.y(), 0), at(q.x(), q.y(), 0), at(q.x(), cell.z1, 0), at(p.x(), cell.z1, 0),
                  reflectivity_);
    builder_.quad(at(p.x(), p.y(), 0), at(q.x(), q.y(), 0), at(q.x(), q.y(), opening.depth),
                  at(p.x(), p.y(), opening.depth), reflectivity_);
    if (!opening.open)
      builder_.quad(at(p.x(), spring, opening.depth), at(q.x(), spring, opening.depth), at(q.x(), q.y(), opening.depth),
                    at(p.x(), p.y(), opening.depth), opening.pane);
  }
}

void Front::wall_with(const Cell& cell, const Opening& opening) {
  const Cell& h = opening.hole;
  const double top = opening.arched ? h.z1 - 0.5 * (h.u1 - h.u0) : h.z1;  // of the upright sides
  panel({cell.u0, h.u0, cell.z0, cell.z1}, 0, reflectivity_);
  panel({h.u1, cell.u1, cell.z0, cell.z1}, 0, reflectivity_);
  if (h.z0 > cell.z0) panel({h.u0, h.u1, cell.z0, h.z0}, 0, reflectivity_);
  for (const double u : {h.u0, h.u1}) jamb(u, h.z0, top, 0, opening.depth, reflectivity_);
  shelf(h.u0, h.u1, h.z0, 0, opening.depth, reflectivity_);
  if (!opening.open) panel({h.u0, h.u1, h.z0, top}, opening.depth, opening.pane);
  if (opening.arched) {
    add_arch(cell, opening, top);
  } else {
    panel({h.u0, h.u1, h.z1, cell.z1}, 0, reflectivity_);
    shelf(h.u0, h.u1, h.z1, 0, opening.depth, reflectivity_);
  }
}

struct Grid {
  int bays = 2;
  double bay = 2, floor = 2.8;
};

void add_ground_floor(MeshBuilder& builder, RandomStream& random, Front& front, const FrontShape& shape,
                      const Grid& grid) {
  const int door = static_cast<int>(random.uniform(0, grid.bays));
  for (int k = 0; k < grid.bays; ++k) {
    const Cell cell{k * grid.bay, (k + 1) * grid.bay, 0, grid.floor};
    const double mid = 0.5 * (cell.u0 + cell.u1);
    if (shape.arcade) {
      const double half = 0.5 * grid.bay - 0.2;
      front.wall_with(cell, {{mid - half, mid + half, 0, grid.floor - 0.15}, kArcadeWall, true, m::kPlaster, true});
    } else if (k == door) {
      front.wall_with(cell, {{mid - 0.6, mid + 0.6, 0, 2.4}, 0.35, true, m::kWood, false});
    } else {
      const double half = std::min(0.5, 0.3 * grid.bay);
      front.wall_with(cell, {{mid - half, mid + half, 1.0, 2.1}, 0.2, false, m::kGlass, false});
      front.block({mid - half - 0.08, mid + half + 0.08, 0.92, 1.0}, 0.07, m::kConcrete);
    }
  }
  if (!shape.arcade) return;
  for (int k = 0; k <= grid.bays; ++k) {
    const Vec3 foot = front.at(std::clamp(k * grid.bay, 0.2, front.length() - 0.2), -shape.below, 0.5 * kArcadeWall);
    curved::add_column(builder, foot, 0.3, 0.26, shape.below + 2.0, m::kConcrete);
  }
  const double height = grid.floor;
  front.panel({0, front.length(), -shape.below, height}, kArcade, m::kPlaster);
  front.shelf(0, front.length(), height, 0, kArcade, m::kPlaster);
}

void add_upper_floor(RandomStream& random, Front& front, const Grid& grid, int floor) {
  const double z = floor * grid.floor, style = random.uniform();
  for (int k = 0; k < grid.bays; ++k) {
    const Cell cell{k * grid.bay, (k + 1) * grid.bay, z, z + grid.floor};
    const double mid = 0.5 * (cell.u0 + cell.u1), half = std::min(0.48, 0.26 * grid.bay), sill = z + 0.8;
    front.wall_with(cell, {{mid - half, mid + half, sill, sill + 1.45}, 0.18, style < 0.3, m::kGlass, false});
    front.block({mid - half - 0.1, mid + half + 0.1, sill - 0.08, sill}, 0.09, m::kConcrete);
    // Shutters stand open.
    if (style > 0.55) {
      front.block({mid - 1.9 * half, mid - half - 0.02, sill, sill + 1.45}, 0.05, m::kWood);
      front.block({mid + half + 0.02, mid + 1.9 * half, sill, sill + 1.45}, 0.05, m::kWood);
    }
  }
  front.block({0, front.length(), z - 0.06, z + 0.06}, 0.05, m::kConcrete);
}

/// Sides, back and a roof with its ridge along the front.
void add_hull(MeshBuilder& builder, Front& front, const FrontShape& shape, std::uint8_t reflectivity) {
  const double w = 0.5 * shape.width, height = shape.height(), ridge = height + 0.35 * shape.depth;
  const double front_end = shape.arcade ? kArcade : 0;
  for (const double x : {-w, w}) {
    builder.wall({x, front_end}, {x, shape.depth}, -shape.below, height, reflectivity);
    if (shape.arcade) builder.wall({x, 0}, {x, kArcade}, shape.floor_height, height, reflectivity);
    builder.triangle({x, 0, height}, {x, shape.depth, height}, {x, 0.5 * shape.depth, ridge}, reflectivity);
  }
  builder.wall({-w, shape.depth}, {w, shape.depth}, -shape.below, height, reflectivity);
  front.block({0, front.length(), height - 0.25, height}, kCornice, m::kConcrete);
  const double eaves = height - 0.02;
  builder.quad({-w, 0.5 * shape.depth, ridge}, {w, 0.5 * shape.depth, ridge}, {w, shape.depth, eaves},
               {-w, shape.depth, eaves}, m::kBrick);
  // From the cornice, curved with the front, up to the straight ridge.
  const int pieces = std::abs(shape.bow) < 1e-6 ? 1 : 16;
  for (int k = 0; k < pieces; ++k) {
    const double a = front.length() * k / pieces, b = front.length() * (k + 1) / pieces;
    const double xa = -w + shape.width * k / pieces, xb = -w + shape.width * (k + 1) / pieces;
    builder.quad(front.at(a, height, -kCornice), front.at(b, height, -kCornice), {xb, 0.5 * shape.depth, ridge},
                 {xa, 0.5 * shape.depth, ridge}, m::kBrick);
  }
}

}  // namespace

void add_old_house(MeshBuilder& builder, RandomStream& random, const FrontShape& shape) {
  const auto reflectivity = static_cast<std::uint8_t>(random.uniform(m::kBrick, m::kPlaster));
  Front front(builder, shape, reflectivity);
  const double wanted = random.uniform(1.9, 2.6);
  const int bays = std::max(1, static_cast<int>(std::floor(front.length() / wanted)));
  const Grid grid{bays, front.length() / bays, shape.floor_height};
  if (!shape.arcade) front.panel({0, front.length(), -shape.below, 0}, 0, m::kConcrete);
  add_ground_floor(builder, random, front, shape, grid);
  for (int floor = 1; floor <= shape.floors; ++floor) add_upper_floor(random, front, grid, floor);
  add_hull(builder, front, shape, reflectivity);
}

}  // namespace aslio::simulator::outdoor
