#include "worlds/hall.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "purposes.hpp"
#include "worlds/vehicles.hpp"

namespace aslio::simulator::outdoor {
namespace {

namespace m = material;
using indoor::Rect;

constexpr double kHalfPi = std::numbers::pi / 2;
constexpr double kPillar = 0.45;      ///< across [m]
constexpr double kBeamBelow = 0.42;   ///< ceiling to underside [m]
constexpr double kRib = 0.25;         ///< ceiling to underside [m]
constexpr double kCoffer = 2;         ///< from rib to rib [m]
constexpr double kBay = 2.5;          ///< width of a bay [m]
constexpr double kKeepPillar = 0.85;  ///< from the route [m]; a walk cuts corners
constexpr double kKeepVehicle = 1.0;
constexpr double kPaintZ = 0.004;  ///< height of lines on the floor [m]
constexpr std::uint8_t kFloor = 70;

/// Level cylinder between two points.
void add_pipe(MeshBuilder& builder, const Vec3& from, const Vec3& to, double radius, std::uint8_t reflectivity) {
  constexpr int kSides = 10;
  const Vec2 d = (to - from).head<2>();
  std::array<Vec2, kSides> rim;
  for (int k = 0; k < kSides; ++k) {
    const double a = 2 * std::numbers::pi * k / kSides;
    rim.at(static_cast<std::size_t>(k)) = radius * Vec2(std::cos(a), std::sin(a));
  }
  // The profile is pushed along y.
  const auto placed = builder.place({from, std::atan2(-d.x(), d.y())});
  builder.extrude(rim, 0, d.norm(), reflectivity);
}

class HallBuilder {
 public:
  HallBuilder(MeshBuilder& builder, const Hall& hall, const Route& route, std::uint64_t seed)
      : builder_(builder), hall_(hall), seed_(seed), plot_(route) {
    // Bays begin half an aisle from the first edges of the route: pillars stand in line with them.
    const Vec2 start = route.points().front();
    const auto first = [](double low, double anchor, double pitch) {
      return anchor + pitch * std::ceil((low + 1 - anchor) / pitch);
    };
    for (double x = first(hall.area.low.x(), start.x() + 0.5 * hall.grid_x, hall.grid_x); x < hall.area.high.x() - 1;
         x += hall.grid_x)
      pillar_x_.push_back(x);
    for (double y = first(hall.area.low.y(), start.y() + 0.5 * hall.grid_y, hall.grid_y); y < hall.area.high.y() - 1;
         y += hall.grid_y)
      pillar_y_.push_back(y);
    aisle_ = start.y();
  }
  void build() {
    shell();
    pillars();
    ceiling();
    stair_cores();
    vehicles();
    walls_dressed();
    floor_things();
  }

 private:
  RandomStream stream(std::uint64_t part) const { return {seed_, purpose::kLayout, part}; }
  void shell();
  void pillars();
  void ceiling();
  void vehicles();
  void bay_row(double y, double towards, std::uint64_t part);
  void walls_dressed();
  void dress_wall(double length, RandomStream& random);
  void stair_cores();
  void floor_things();
  bool gate_near(double y, double margin) const;

  MeshBuilder& builder_;
  const Hall& hall_;
  std::uint64_t seed_;
  Plot plot_;
  std::vector<double> pillar_x_, pillar_y_;
  double aisle_ = 0;
};

bool HallBuilder::gate_near(double y, double margin) const {
  return std::any_of(hall_.gates.begin(), hall_.gates.end(),
                     [&](const Hall::Gate& g) { return y > g.from - margin && y < g.to + margin; });
}

/// Floor, ceiling, walls with their gates.
void HallBuilder::shell() {
  const Vec2 &low = hall_.area.low, &high = hall_.area.high;
  builder_.slab(low, high, 0, kFloor);
  builder_.slab(low, high, hall_.height, m::kConcrete);
  builder_.wall(low, {high.x(), low.y()}, 0, hall_.height, m::kConcrete);
  builder_.wall({high.x(), low.y()}, high, 0, hall_.height, m::kConcrete);
  builder_.wall(high, {low.x(), high.y()}, 0, hall_.height, m::kConcrete);
  std::vector<Hall::Gate> gates = hall_.gates;
  std::sort(gates.begin(), gates.end(), [](const Hall::Gate& a, const Hall::Gate& b) { return a.from < b.from; });
  double y = low.y();
  for (const Hall::Gate& gate : gates) {
    builder_.wall({low.x(), y}, {low.x(), gate.from}, 0, hall_.height, m::kConcrete);
    builder_.wall({low.x(), gate.from}, {low.x(), gate.to}, gate.height, hall_.height, m::kConcrete);
    y = gate.to;
  }
  builder_.wall({low.x(), y}, {low.x(), high.y()}, 0, hall_.height, m::kConcrete);
}

void HallBuilder::pillars() {
  const double h = 0.5 * kPillar;
  for (const double y : pillar_y_) {
    for (const double x : pillar_x_) {
      // Where a route passes, the pillar stands a bit aside, or a beam carries it.
      for (const double shift : {0.0, 1.0, -1.0, 2.0, -2.0}) {
        const Vec2 at(x + shift, y);
        if (!plot_.claim({at, Vec2(h + 0.02, h + 0.02), 0}, kKeepPillar)) continue;
        builder_.box({at.x() - h, at.y() - h, 0}, {at.x() + h, at.y() + h, hall_.height}, m::kConcrete);
        // Black and white guards at the corners, up to a man's breast.
        for (int k = 0; k < 4; ++k) {
          const std::uint8_t band = k % 2 == 0 ? m::kBlackPaint : m::kWhitePaint;
          const double z = 0.1 + 0.25 * k;
          builder_.box({at.x() - h - 0.012, at.y() - h - 0.012, z}, {at.x() + h + 0.012, at.y() + h + 0.012, z + 0.25},
                       band);
        }
        break;
      }
    }
  }
}

void HallBuilder::ceiling() {
  const Vec2 &low = hall_.area.low, &high = hall_.area.high;
  const double under = hall_.height - kBeamBelow;
  for (const double x : pillar_x_)
    builder_.box({x - 0.2, low.y(), under}, {x + 0.2, high.y(), hall_.height}, m::kConcrete);
  for (const double y : pillar_y_)
    builder_.box({low.x(), y - 0.15, under + 0.12}, {high.x(), y + 0.15, hall_.height}, m::kConcrete);
  // Coffers between them.
  const double rib = hall_.height - kRib;
  for (double x = low.x() + kCoffer; x < high.x(); x += kCoffer)
    builder_.box({x - 0.06, low.y(), rib}, {x + 0.06, high.y(), hall_.height}, m::kConcrete);
  for (double y = low.y() + kCoffer; y < high.y(); y += kCoffer)
    builder_.box({low.x(), y - 0.06, rib}, {high.x(), y + 0.06, hall_.height}, m::kConcrete);
  if (hall_.clutter <= 0) return;
  RandomStream random = stream(1);
  for (double y = low.y() + 1.2; y < high.y() - 1; y += random.uniform(4, 9) / hall_.clutter) {
    const double radius = random.uniform(0.03, 0.09), z = under - radius - 0.01;
    const double from = random.uniform(low.x(), low.x() + 0.3 * hall_.area.size().x());
    const double to = random.uniform(high.x() - 0.3 * hall_.area.size().x(), high.x());
    add_pipe(builder_, {from, y, z}, {to, y, z}, radius, random.uniform() < 0.5 ? m::kMetal : m::kWhitePaint);
    for (double x = from + 1; x < to; x += 3)
      builder_.box({x, y - radius - 0.02, z}, {x + 0.03, y + radius + 0.02, hall_.height}, m::kMetal);
  }
  // An air duct, between two lines of beams it lies below both.
  const double duct = low.y() + random.uniform(0.3, 0.6) * hall_.area.size().y();
  builder_.box({low.x() + 2, duct, under - 0.22}, {high.x() - 3, duct + 0.7, under - 0.01}, m::kMetal);
  for (double y = aisle_ - 12 * std::floor((aisle_ - low.y()) / 12); y < high.y() - 0.5; y += 3) {
    if (y < low.y() + 0.5) continue;
    for (double x = low.x() + 2; x < high.x() - 2; x += 4.1)
      builder_.box({x, y - 0.06, rib - 0.08}, {x + 1.25, y + 0.06, rib + 0.02}, m::kWhitePaint);
  }
}

/// Bays in the two strips between aisles; each row opens to its aisle.
void HallBuilder::vehicles() {
  const double pitch = hall_.grid_y;
  const int first = static_cast<int>(std::floor((hall_.area.low.y() - aisle_) / pitch)) - 1;
  const int last = static_cast<int>(std::ceil((hall_.area.high.y() - aisle_) / pitch)) + 1;
  for (int k = first; k <= last; ++k) {
    const int kind = ((k % 3) + 3) % 3;
    if (kind == 0) continue;
    bay_row(aisle_ + k * pitch, kind == 1 ? -1 : 1, 100 + static_cast<std::uint64_t>(k - first));
  }
}

/// Bays along x about the line `y`, open on the side `towards` of it.
void HallBuilder::bay_row(double y, double towards, std::uint64_t part) {
  RandomStream random = stream(part);
  const double low_y = y - 2.6, high_y = y + 2.6;
  if (low_y < hall_.area.low.y() + 0.2 || high_y > hall_.area.high.y() - 0.2) return;
  // Three bays between two pillars.
  const double pitch = hall_.grid_x / std::max(1.0, std::floor((hall_.grid_x - kPillar) / kBay));
  const double from = pillar_x_.empty() ? hall_.area.low.x() + 1 : pillar_x_.front() - hall_.grid_x;
  for (double x = from + 0.5 * pitch; x < hall_.area.high.x() - 0.5 * pitch; x += pitch) {
    const double taken = random.uniform(), nose = random.uniform(), along = random.uniform(-0.25, 0.25);
    const double across = random.uniform(-0.15, 0.15), skew = random.uniform(-0.04, 0.04);
    const Vehicle vehicle = draw_vehicle(random);
    if (x < hall_.area.low.x() + 0.5 * pitch) continue;
    const Footprint bay{Vec2(x, y), Vec2(0.5 * pitch, 2.5), 0};
    if (distance(plot_.route(), bay) > 0.3) {
      for (const double side : {-0.5, 0.5})
        builder_.slab({x + side * pitch - 0.05, low_y}, {x + side * pitch + 0.05, high_y}, kPaintZ, m::kWhitePaint);
    }
    if (taken >= hall_.parked) continue;
    const Placement placement{Vec3(x + across, y + along, 0), towards * (nose < 0.6 ? -kHalfPi : kHalfPi) + skew};
    if (!plot_.claim(footprint(vehicle, placement), kKeepVehicle)) continue;
    const auto placed = builder_.place(placement);
    add_vehicle(builder_, vehicle);
  }
}

/// In a frame with x along the wall from 0 and y out of it.
void HallBuilder::dress_wall(double length, RandomStream& random) {
  for (double x = random.uniform(1, 4); x < length - 2; x += random.uniform(2.5, 7) / std::max(hall_.clutter, 0.1)) {
    const double kind = random.uniform();
    if (kind < 0.25) {  // door in a frame
      builder_.box({x, 0, 0}, {x + 1.1, 0.06, 2.15}, m::kMetal);
      builder_.box({x + 0.07, 0.06, 0}, {x + 1.03, 0.08, 2.08}, m::kWhitePaint);
      builder_.box({x + 0.15, 0.08, 1.0}, {x + 0.29, 0.13, 1.04}, m::kMetal);
    } else if (kind < 0.5) {  // pilaster
      builder_.box({x, 0, 0}, {x + 0.4, 0.22, hall_.height}, m::kConcrete);
    } else if (kind < 0.65) {  // cabinet
      builder_.box({x, 0, 0.5}, {x + 0.8, 0.25, 1.7}, m::kMetal);
    } else if (kind < 0.8) {  // downpipe
      builder_.frustum({x, 0.1, 0}, 0.06, 0.06, hall_.height, 10, m::kMetal);
    } else if (kind < 0.9) {  // extinguisher
      builder_.frustum({x, 0.12, 0.7}, 0.08, 0.08, 0.5, 10, m::kMetal);
      builder_.box({x - 0.15, 0, 1.6}, {x + 0.15, 0.012, 1.9}, m::kWhitePaint);
    } else {  // sign
      builder_.box({x, 0, 1.5}, {x + 1.2, 0.02, 2.1}, m::kWhitePaint);
    }
  }
  builder_.box({0, 0, hall_.height - 0.75}, {length, 0.2, hall_.height - 0.68}, m::kMetal);  // cable tray
}

void HallBuilder::walls_dressed() {
  if (hall_.clutter <= 0) return;
  const Vec2 &low = hall_.area.low, &high = hall_.area.high;
  const Vec2 size = hall_.area.size();
  const auto face = [&](std::uint64_t part, const Vec2& at, double yaw, double length) {
    RandomStream random = stream(part);
    const auto placed = builder_.place({Vec3(at.x(), at.y(), 0), yaw});
    dress_wall(length, random);
  };
  face(10, low, 0, size.x());
  face(11, {high.x(), low.y()}, kHalfPi, size.y());
  face(12, high, 2 * kHalfPi, size.x());
  // The wall with the gates, between them.
  double top = high.y();
  std::vector<Hall::Gate> gates = hall_.gates;
  std::sort(gates.begin(), gates.end(), [](const Hall::Gate& a, const Hall::Gate& b) { return a.from > b.from; });
  std::uint64_t part = 13;
  for (const Hall::Gate& gate : gates) {
    if (top - gate.to > 1) face(part++, {low.x(), top}, -kHalfPi, top - gate.to - 0.5);
    top = gate.from - 0.5;
  }
  if (top - low.y() > 1) face(part, {low.x(), top}, -kHalfPi, top - low.y());
}

/// Closed blocks as high as the storey.
void HallBuilder::stair_cores() {
  RandomStream random = stream(31);
  const Vec2 &low = hall_.area.low, &high = hall_.area.high;
  for (int attempt = 0, built = 0; attempt < 200 && built < 2; ++attempt) {
    // In braces: every compiler draws from left to right.
    const Vec2 half{random.uniform(1.5, 2.5), random.uniform(2, 3.2)};
    const Vec2 at{random.uniform(low.x() + 6, high.x() - 6), random.uniform(low.y() + 6, high.y() - 6)};
    // Among the bays, not across an aisle.
    const double strip = std::fmod(at.y() - aisle_ + 300 * hall_.grid_y, 3 * hall_.grid_y) / hall_.grid_y;
    if (strip < 1 || strip > 2 || !plot_.claim({at, half, 0}, 1.6)) continue;
    builder_.box({at.x() - half.x(), at.y() - half.y(), 0}, {at.x() + half.x(), at.y() + half.y(), hall_.height},
                 m::kPlaster);
    builder_.box({at.x() - 0.5, at.y() - half.y() - 0.04, 0}, {at.x() + 0.5, at.y() + half.y() + 0.04, 2.1}, m::kMetal);
    ++built;
  }
}

/// Bollards, crates and bins.
void HallBuilder::floor_things() {
  RandomStream random = stream(30);
  const Vec2 &low = hall_.area.low, &high = hall_.area.high;
  const int things = static_cast<int>(0.012 * hall_.clutter * hall_.area.size().prod());
  for (int k = 0; k < things; ++k) {
    const Vec2 at{random.uniform(low.x() + 1, high.x() - 1), random.uniform(low.y() + 1, high.y() - 1)};
    const double kind = random.uniform(), size = random.uniform(0.25, 0.5), height = random.uniform(0.3, 1.1);
    const double yaw = random.uniform(-kHalfPi, kHalfPi);
    if (at.x() < low.x() + 8 && gate_near(at.y(), 0.5)) continue;
    if (!plot_.claim({at, Vec2(size, size), yaw}, 1.0)) continue;
    const auto placed = builder_.place({Vec3(at.x(), at.y(), 0), yaw});
    if (kind < 0.4) {
      builder_.frustum({0, 0, 0}, 0.08, 0.08, 0.9, 10, m::kMetal);
      builder_.frustum({0, 0, 0.55}, 0.085, 0.085, 0.2, 10, m::kWhitePaint);
    } else if (kind < 0.7) {
      builder_.box({-size, -size, 0}, {size, size, height}, m::kWood);
    } else {
      builder_.frustum({0, 0, 0}, 0.6 * size, 0.7 * size, height, 12, m::kBlackPaint);
    }
  }
}

}  // namespace

void build_hall(MeshBuilder& builder, const Hall& hall, const Route& route, std::uint64_t seed) {
  HallBuilder(builder, hall, route, seed).build();
}

void build_ramp(MeshBuilder& builder, const Hall& hall, const Hall::Gate& gate, double length, double rise) {
  const double x0 = hall.area.low.x(), x1 = x0 - length, y0 = gate.from, y1 = gate.to, h = gate.height;
  builder.quad({x0, y0, 0}, {x0, y1, 0}, {x1, y1, rise}, {x1, y0, rise}, m::kConcrete);
  builder.quad({x0, y0, h}, {x0, y1, h}, {x1, y1, rise + h}, {x1, y0, rise + h}, m::kConcrete);
  for (const double y : {y0, y1}) builder.quad({x0, y, 0}, {x0, y, h}, {x1, y, rise + h}, {x1, y, rise}, m::kConcrete);
  // Slats of the roller door, one in two a bit farther out.
  const int slats = 16;
  for (int k = 0; k < slats; ++k) {
    const double z = rise + h * k / slats, x = x1 + (k % 2 == 0 ? 0.03 : 0.06);
    builder.box({x1, y0, z}, {x, y1, z + h / slats}, m::kMetal);
  }
  for (const double y : {y0 + 0.08, y1 - 0.08})  // kerbs
    builder.quad({x0, y, 0}, {x0, y, 0.15}, {x1, y, rise + 0.15}, {x1, y, rise}, m::kWhitePaint);
}

}  // namespace aslio::simulator::outdoor
