#include "worlds/building.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace aslio::simulator::outdoor {
namespace {

namespace m = material;

constexpr double kFoundation = 2.5;  ///< below the ground [m]
constexpr double kPlinth = 0.45;     ///< height [m]
constexpr double kProud = 1.1;       ///< farthest out of the wall: balconies, canopies [m]
constexpr double kHalfPi = std::numbers::pi / 2;

/// Rectangle of a wall, x along it and z up.
struct Pane {
  double x0 = 0, x1 = 0, z0 = 0, z1 = 0;
};

/// The wall round a hole, the hole's four sides and what closes it `depth` behind the wall.
void add_niche(MeshBuilder& builder, const Pane& wall, const Pane& hole, double depth, std::uint8_t stone,
               std::uint8_t back) {
  const auto face = [&](const Pane& p, double y, std::uint8_t reflectivity) {
    if (p.x1 > p.x0 && p.z1 > p.z0) builder.wall({p.x0, y}, {p.x1, y}, p.z0, p.z1, reflectivity);
  };
  face({wall.x0, hole.x0, wall.z0, wall.z1}, 0, stone);
  face({hole.x1, wall.x1, wall.z0, wall.z1}, 0, stone);
  face({hole.x0, hole.x1, wall.z0, hole.z0}, 0, stone);
  face({hole.x0, hole.x1, hole.z1, wall.z1}, 0, stone);
  for (const double x : {hole.x0, hole.x1}) builder.wall({x, 0}, {x, -depth}, hole.z0, hole.z1, stone);
  for (const double z : {hole.z0, hole.z1}) builder.slab({hole.x0, -depth}, {hole.x1, 0}, z, stone);
  face(hole, -depth, back);
}

/// One side of a building: y points out of the wall, x runs from 0 to `length`.
class Facade {
 public:
  Facade(MeshBuilder& builder, RandomStream& random, const Building& building, double length, bool door)
      : builder_(builder), random_(random), b_(building), length_(length) {
    bays_ = std::max(1, static_cast<int>(std::lround(length / b_.bay)));
    if (door) door_ = static_cast<int>(random.uniform(0, bays_));
  }
  void add() {
    for (int storey = 0; storey < b_.storeys; ++storey)
      for (int k = 0; k < bays_; ++k) add_bay(storey, k);
    builder_.wall({0, 0}, {length_, 0}, -kFoundation, 0, b_.wall);
    const double bay = length_ / bays_, from = door_ * bay + 0.5 * (bay - kDoorWidth);
    const auto plinth = [&](double x0, double x1) {
      builder_.box({x0, -0.02, -kFoundation}, {x1, 0.08, kPlinth}, m::kConcrete);
    };
    if (door_ < 0) {
      plinth(0, length_);
    } else {
      plinth(0, from);
      plinth(from + kDoorWidth, length_);
    }
    for (int storey = 1; b_.bands && storey <= b_.storeys; ++storey)
      builder_.box({0, -0.02, storey * b_.storey - 0.1}, {length_, 0.1, storey * b_.storey + 0.08}, m::kConcrete);
    // Downpipe from the eaves.
    builder_.frustum({0.35, 0.1, -0.2}, 0.05, 0.05, b_.storeys * b_.storey, 8, m::kMetal);
  }

 private:
  static constexpr double kDoorWidth = 1.5;
  void add_bay(int storey, int bay);

  MeshBuilder& builder_;
  RandomStream& random_;
  const Building& b_;
  double length_;
  int bays_ = 1, door_ = -1;
};

void Facade::add_bay(int storey, int k) {
  const double bay = length_ / bays_, z0 = storey * b_.storey, middle = (k + 0.5) * bay;
  const Pane wall{k * bay, (k + 1) * bay, z0, z0 + b_.storey};
  const double drawn = random_.uniform(), balcony = random_.uniform();
  if (storey == 0 && k == door_) {
    const double w = 0.5 * kDoorWidth;
    add_niche(builder_, wall, {middle - w, middle + w, z0, 2.25}, 0.35, b_.wall, m::kWood);
    builder_.box({middle - w - 0.3, -0.02, 2.5}, {middle + w + 0.3, kProud, 2.6}, m::kConcrete);
    builder_.box({middle - w - 0.2, 0, -1.5}, {middle + w + 0.2, 0.6, 0.02}, m::kConcrete);
    builder_.box({middle + w - 0.3, -0.35, 1}, {middle + w - 0.2, -0.27, 1.2}, m::kMetal);
    return;
  }
  const double w = 0.5 * std::min(b_.window_width, 0.7 * bay), sill = storey == 0 ? std::max(b_.sill, 0.7) : b_.sill;
  const double top = std::min(sill + b_.window_height, b_.storey - 0.3);
  // Here and there a wall without a window, and a drawn shutter.
  if (drawn < 0.06) {
    builder_.wall({wall.x0, 0}, {wall.x1, 0}, wall.z0, wall.z1, b_.wall);
    return;
  }
  const std::uint8_t back = drawn < 0.22 ? m::kWhitePaint : m::kGlass;
  add_niche(builder_, wall, {middle - w, middle + w, z0 + sill, z0 + top}, b_.niche, b_.wall, back);
  builder_.box({middle - w - 0.06, -0.02, z0 + sill - 0.06}, {middle + w + 0.06, 0.09, z0 + sill}, m::kConcrete);
  builder_.box({middle - 0.03, -b_.niche, z0 + sill}, {middle + 0.03, -b_.niche + 0.04, z0 + top}, m::kWhitePaint);
  if (storey > 0 && balcony < b_.balconies) {
    const double edge = std::min(w + 0.5, 0.5 * bay - 0.1);
    builder_.box({middle - edge, -0.02, z0 - 0.02}, {middle + edge, kProud, z0 + 0.12}, m::kConcrete);
    builder_.wall({middle - edge, kProud - 0.05}, {middle + edge, kProud - 0.05}, z0 + 0.12, z0 + 1.05, m::kMetal);
    for (const double x : {middle - edge, middle + edge})
      builder_.wall({x, 0}, {x, kProud - 0.05}, z0 + 0.12, z0 + 1.05, m::kMetal);
  }
}

void add_roof(MeshBuilder& builder, RandomStream& random, const Building& b) {
  const double z = b.storeys * b.storey, w = 0.5 * b.width, d = 0.5 * b.depth;
  if (b.gabled) {
    constexpr double kEaves = 0.5;
    const double ridge = z + d * random.uniform(0.6, 0.9);
    const std::array<Vec2, 3> gable = {Vec2(-d - kEaves, z - 0.2), Vec2(d + kEaves, z - 0.2), Vec2(0, ridge)};
    const auto along = builder.place({Vec3::Zero(), kHalfPi});
    builder.extrude(gable, -w - 0.2, w + 0.2, m::kBrick);
    builder.box({0.3 * d, -0.4 * w, z}, {0.3 * d + 0.6, -0.4 * w + 0.9, ridge + 0.5}, m::kBrick);
    return;
  }
  builder.slab({-w, -d}, {w, d}, z, m::kAsphalt);
  for (const double s : {-1.0, 1.0}) {
    builder.box({-w - 0.05, std::min(s * d, s * (d - 0.3)), z - 0.05},
                {w + 0.05, std::max(s * d, s * (d - 0.3)), z + 0.5}, m::kConcrete);
    builder.box({std::min(s * w, s * (w - 0.3)), -d, z - 0.05}, {std::max(s * w, s * (w - 0.3)), d, z + 0.5},
                m::kConcrete);
  }
  for (int k = 0; k < 3; ++k) {
    // In braces: every compiler draws from left to right.
    const Vec2 at{random.uniform(0.4 - w, std::max(0.4 - w, w - 3)), random.uniform(-0.6 * d, 0.4 * d)};
    builder.box({at.x(), at.y(), z}, {at.x() + random.uniform(1, 2.5), at.y() + 1.4, z + random.uniform(0.8, 2.4)},
                m::kMetal);
  }
}

}  // namespace

Building draw_building(RandomStream& random, double width, double depth) {
  Building b;
  b.width = width;
  b.depth = depth;
  const double size = random.uniform(), style = random.uniform(), stone = random.uniform();
  b.storeys = 2 + static_cast<int>(4 * size);
  b.storey = random.uniform(2.9, 3.5);
  b.bay = random.uniform(2.4, 4);
  b.window_width = random.uniform(0.9, 0.62 * b.bay);
  b.window_height = random.uniform(1.2, 1.8);
  b.sill = random.uniform(0.6, 1.0);
  b.niche = random.uniform(0.1, 0.3);
  b.gabled = style < 0.4 && depth < 13;
  b.bands = style > 0.3 && style < 0.7;
  b.balconies = style > 0.6 ? random.uniform(0, 0.4) : 0;
  b.wall = stone < 0.35 ? m::kPlaster : stone < 0.7 ? m::kBrick : stone < 0.9 ? m::kConcrete : m::kWhitePaint;
  return b;
}

void add_building(MeshBuilder& builder, RandomStream& random, const Building& b) {
  const double w = 0.5 * b.width, d = 0.5 * b.depth;
  const auto side = [&](const Vec2& at, double yaw, double length, bool door) {
    const auto placed = builder.place({Vec3(at.x(), at.y(), 0), yaw});
    Facade(builder, random, b, length, door).add();
  };
  side({w, -d}, 2 * kHalfPi, b.width, true);
  side({w, d}, -kHalfPi, b.depth, false);
  side({-w, d}, 0, b.width, true);
  side({-w, -d}, kHalfPi, b.depth, false);
  add_roof(builder, random, b);
}

Footprint footprint(const Building& b, const Placement& placement) {
  const Vec2 half(0.5 * b.width + kProud, 0.5 * b.depth + kProud);
  return footprint(placement, -half, half);
}

}  // namespace aslio::simulator::outdoor
