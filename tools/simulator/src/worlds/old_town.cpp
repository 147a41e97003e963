#include "aslio/simulator/worlds/old_town.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "aslio/config/binder.hpp"
#include "aslio/simulator/random.hpp"
#include "purposes.hpp"
#include "worlds/curved.hpp"
#include "worlds/facade.hpp"
#include "worlds/flight.hpp"
#include "worlds/plot.hpp"

namespace aslio::simulator {
namespace {

using namespace outdoor;
namespace m = material;

constexpr double kPi = std::numbers::pi;
constexpr double kBeyond = 22;                                 // of the terrain about the route [m]
constexpr double kTerrain = 0.5;                               // its grid [m]
constexpr double kCobble = 0.008;                              // stones stand out or lie low by up to this [m]
constexpr double kTile = 0.25;                                 // of the outdoor steps across the alley [m]
constexpr double kKeep = 0.75;                                 // nothing comes nearer to the route [m]
constexpr double kVault = 5, kVaultHalf = 1.5, kSpring = 2.6;  // passages: length, half width, where arcs begin [m]
enum Part : std::uint64_t { kGround = 1, kTowers = 2, kVaults = 3, kCobbles = 4, kEdges = 100 };

/// Two levels and a flight of steps between them, straight through the town.
struct Terrace {
  Flight flight;
  double heading = 0, begin = 0;
};

class OldTown {
 public:
  OldTown(const OldTownParams& params, const Route& route)
      : params_(params), route_(route), seed_(static_cast<std::uint64_t>(params.seed)), plot_(route) {
    draw_ground();
  }
  World build();

 private:
  RandomStream stream(std::uint64_t part) const { return {seed_, purpose::kLayout, part}; }
  double height(const Vec2& p) const { return ground_.height(p.x(), p.y()); }
  /// On the terrace: past the last riser.
  bool above(const Vec2& p) const { return along_terrace(p) >= terrace_.begin + terrace_.flight.length(); }
  double along_terrace(const Vec2& p) const {
    return std::cos(terrace_.heading) * p.x() + std::sin(terrace_.heading) * p.y();
  }
  double lowest(const Footprint& area) const;
  void draw_ground();
  void add_terrain();
  void add_steps_outside();
  void add_passages();
  bool add_passage(const Route::Place& place, RandomStream& random);
  void add_towers();
  void add_fronts(std::size_t edge, double side);
  bool add_front(const Vec2& from, const Vec2& along, double side, double x, double width, RandomStream& random);

  const OldTownParams& params_;
  const Route& route_;
  std::uint64_t seed_;
  Plot plot_;
  Ground ground_;  ///< with the steps
  Ground relief_;  ///< without
  Terrace terrace_;
  MeshBuilder builder_;
};

void OldTown::draw_ground() {
  RandomStream random = stream(kGround);
  for (const Vec2& wave : {Vec2(0.6, 90), Vec2(0.4, 47)}) {
    const double k = 2 * kPi / wave.y(), heading = random.uniform(0, 2 * kPi);
    relief_.waves.push_back(
        {0.5 * params_.relief * wave.x(), k * std::cos(heading), k * std::sin(heading), random.uniform(0, 2 * kPi)});
  }
  ground_ = relief_;
  // The flight leads up the longest edge, about its middle.
  const std::vector<Vec2>& points = route_.points();
  Vec2 from = points[0], to = points[1];
  for (std::size_t k = 0; k < points.size(); ++k) {
    const Vec2 &a = points[k], &b = points[(k + 1) % points.size()];
    if ((b - a).norm() > (to - from).norm() + 1e-9) {
      from = a;
      to = b;
    }
  }
  terrace_.flight.steps = static_cast<int>(params_.steps);
  terrace_.flight.tread = 0.36;
  terrace_.flight.rise = 0.15;
  terrace_.heading = std::atan2(to.y() - from.y(), to.x() - from.x());
  terrace_.begin = along_terrace(0.5 * (from + to)) - 0.5 * terrace_.flight.length();
  add_ramps(ground_, terrace_.flight, terrace_.heading, terrace_.begin);
}

double OldTown::lowest(const Footprint& area) const {
  double z = height(area.centre);
  for (const Vec2& corner : area.corners()) z = std::min(z, height(corner));
  return z;
}

/// Under the steps the ground stays low.
void OldTown::add_terrain() {
  RandomStream random = stream(kCobbles);
  const double rise = terrace_.flight.height();
  builder_.terrain(route_.low().array() - kBeyond, route_.high().array() + kBeyond, kTerrain, 75,
                   [&](double x, double y) {
                     return relief_.height(x, y) + (params_.steps > 0 && above({x, y}) ? rise : 0) +
                            random.uniform(-kCobble, kCobble);
                   });
}

/// Tiles over the alleys wherever they cross the edge of the terrace, and a strip of paving at its head.
void OldTown::add_steps_outside() {
  if (params_.steps <= 0) return;
  const Flight& flight = terrace_.flight;
  const Vec2 along(std::cos(terrace_.heading), std::sin(terrace_.heading)), across(-along.y(), along.x());
  const double reach = 0.5 * params_.alley + 1.5, extent = (route_.high() - route_.low()).norm() + reach;
  const Vec2 middle = 0.5 * (route_.low() + route_.high());
  const Vec2 origin = middle + (terrace_.begin - along.dot(middle)) * along;
  const auto at = [&](double x, double y, double up) {
    const Vec2 p = origin + x * along + y * across;
    return Vec3(p.x(), p.y(), relief_.height(p.x(), p.y()) + up);
  };
  for (double y = -extent; y < extent; y += kTile) {
    for (int k = 0; k < flight.steps; ++k) {
      const double x0 = k * flight.tread, up = k * flight.rise, top = up + flight.rise;
      const bool last = k + 1 == flight.steps;
      const double x1 = x0 + (last ? 3 * kTerrain : flight.tread);
      const Vec2 p = origin + 0.5 * (x0 + x1) * along + (y + 0.5 * kTile) * across;
      if (route_.distance(p) > reach) continue;
      builder_.quad(at(x0, y, up - 0.1), at(x0, y + kTile, up - 0.1), at(x0, y + kTile, top), at(x0, y, top), 95);
      // The paving at the head covers the terrain, which is rough.
      const double paved = top + (last ? kCobble + 0.001 : 0);
      builder_.quad(at(x0, y, paved), at(x1, y, paved), at(x1, y + kTile, paved), at(x0, y + kTile, paved), 95);
    }
  }
}

/// A house over the alley: two piers, a barrel vault between them and floors above.
bool OldTown::add_passage(const Route::Place& place, RandomStream& random) {
  const double half = 0.5 * kVault, outer = kVaultHalf + random.uniform(3, 6), top = random.uniform(7.5, 10);
  const double yaw = std::atan2(place.direction.y(), place.direction.x());
  const Vec2 left(-place.direction.y(), place.direction.x());
  const Footprint whole{place.at, {half, outer}, yaw};
  // The route goes straight through: nothing else of it may come near.
  for (const double side : {-1.0, 1.0}) {
    const Vec2 centre = place.at + side * 0.5 * (kVaultHalf + outer) * left;
    if (distance(route_, Footprint{centre, {half, 0.5 * (outer - kVaultHalf)}, yaw}) < kVaultHalf - 1e-3) return false;
  }
  if (!plot_.claim(whole, -1)) return false;
  const double foot = height(place.at), low = lowest(whole) - 1;
  const auto here = builder_.place({Vec3(place.at.x(), place.at.y(), foot), yaw});
  const auto tone = static_cast<std::uint8_t>(random.uniform(90, 180));
  std::vector<Vec2> profile = curved::arc({0, kSpring}, kVaultHalf, 0, kPi);
  const std::vector<Vec2> vault = profile;
  profile.insert(profile.begin(), {kVaultHalf, low - foot});
  profile.emplace_back(-kVaultHalf, low - foot);
  const std::array<curved::Station, 2> stations{curved::Station{{-half, 0, 0}}, curved::Station{{half, 0, 0}}};
  curved::sweep(builder_, profile, stations, tone);
  for (const double x : {-half, half}) {
    for (const double side : {-1.0, 1.0})
      builder_.wall({x, side * kVaultHalf}, {x, side * outer}, low - foot, top, tone);
    for (std::size_t k = 1; k < vault.size(); ++k) {
      const Vec2 &p = vault[k - 1], &q = vault[k];
      builder_.quad({x, p.x(), p.y()}, {x, q.x(), q.y()}, {x, q.x(), top}, {x, p.x(), top}, tone);
    }
    for (const double y : {-0.7, 0.7})
      builder_.box({x - 0.06, y - 0.5, kSpring + 2.2}, {x + 0.06, y + 0.5, kSpring + 3.6}, m::kWood);
    const std::vector<Vec2> rim = curved::arc({0, kSpring}, kVaultHalf + 0.02, 0, kPi);
    for (std::size_t k = 1; k < rim.size(); k += 6)
      builder_.box({x - 0.08, rim[k].x() - 0.05, rim[k].y()}, {x + 0.08, rim[k].x() + 0.05, rim[k].y() + 0.25}, 120);
  }
  for (const double side : {-1.0, 1.0})
    builder_.wall({-half, side * outer}, {half, side * outer}, low - foot, top, tone);
  builder_.slab({-half, -outer}, {half, outer}, top, m::kBrick);
  return true;
}

void OldTown::add_passages() {
  RandomStream random = stream(kVaults);
  const int wanted = static_cast<int>(params_.passages);
  for (int k = 0; k < wanted; ++k) {
    for (int attempt = 0; attempt < 30; ++attempt) {
      const Route::Place place = route_.at(route_.length() * (k + random.uniform()) / wanted);
      const double riser = along_terrace(place.at) - terrace_.begin;
      const bool on_steps = params_.steps > 0 && riser > -kVault && riser < terrace_.flight.length() + kVault;
      if (!on_steps && add_passage(place, random)) break;
    }
  }
}

/// Round ones outside the corners.
void OldTown::add_towers() {
  const std::vector<Vec2>& points = route_.points();
  for (std::size_t k = 0; k < points.size(); ++k) {
    RandomStream random(seed_, purpose::kLayout, kTowers + 1000 * (k + 1));
    const double radius = random.uniform(1.6, 3.2), top = random.uniform(8, 15), gap = random.uniform(0, 0.8);
    const bool cone = random.uniform() < 0.6;
    const Vec2& corner = points[k];
    const Vec2 in = (corner - points[(k + points.size() - 1) % points.size()]).normalized();
    const Vec2 out = (points[(k + 1) % points.size()] - corner).normalized();
    if ((in - out).norm() < 0.5) continue;
    const Vec2 centre = corner + (0.5 * params_.alley + gap + radius) * (in - out).normalized();
    const Footprint area{centre, Vec2(0.75 * radius, 0.75 * radius), std::atan2(in.y(), in.x())};
    if (route_.distance(centre) < radius + kKeep || !plot_.claim(area, radius * 0.25)) continue;
    const double z = height(centre) - 2;
    const auto here = builder_.place({Vec3(centre.x(), centre.y(), z), 0});
    curved::add_column(builder_, {0, 0, 0}, 1.06 * radius, radius, 3.2, 110);
    curved::add_column(builder_, {0, 0, 3.2}, radius, 0.97 * radius, top, 140);
    curved::add_column(builder_, {0, 0, 2.9 + top}, 1.08 * radius, 1.08 * radius, 0.5, m::kConcrete);
    if (cone) curved::add_column(builder_, {0, 0, 3.4 + top}, 1.15 * radius, 0.05, 1.6 * radius, m::kBrick);
  }
}

bool OldTown::add_front(const Vec2& from, const Vec2& along, double side, double x, double width,
                        RandomStream& random) {
  FrontShape shape;
  shape.width = width;
  shape.depth = random.uniform(6, 9);
  shape.floors = 1 + static_cast<int>(random.uniform(0, 2.7));
  shape.floor_height = random.uniform(2.6, 3.1);
  const double bow = random.uniform(0.06, 0.16) * width, kind = random.uniform();
  shape.arcade = random.uniform() < params_.arcades;
  if (kind < params_.curved) shape.bow = kind < 0.7 * params_.curved ? bow : -0.7 * bow;
  const double skew = random.uniform(-1, 1) * params_.skew * kPi / 180, back = random.uniform(0, 0.5);
  // On the left of the alley the front's x runs against it, so that y leads into the house.
  const Vec2 normal = side * Vec2(-along.y(), along.x());
  const double line = 0.5 * params_.alley + back + front_reach(shape) + 0.5 * width * std::abs(std::sin(skew));
  const Vec2 middle = from + (x + 0.5 * width) * along + line * normal;
  const double yaw = std::atan2(normal.y(), normal.x()) - 0.5 * kPi + skew;
  const Placement flat{Vec3(middle.x(), middle.y(), 0), yaw};
  const Footprint area = footprint(flat, {-0.5 * width + 0.02, -front_reach(shape)}, {0.5 * width - 0.02, shape.depth});
  if (!plot_.claim(area, 0.5 * params_.alley - 0.1)) return false;
  const Footprint front = footprint(flat, {-0.5 * width, 0}, {0.5 * width, 0.1});
  const double low = lowest(front);
  shape.below = height(front.centre) - low + 2.5;
  const auto here = builder_.place({Vec3(middle.x(), middle.y(), height(front.centre)), yaw});
  add_old_house(builder_, random, shape);
  return true;
}

/// Wall to wall; where a house does not fit, a narrower one or a gap.
void OldTown::add_fronts(std::size_t edge, double side) {
  const std::vector<Vec2>& points = route_.points();
  const Vec2 from = points[edge], line = points[(edge + 1) % points.size()] - from;
  const double length = line.norm();
  RandomStream random = stream(kEdges + 2 * edge + (side > 0 ? 1 : 0));
  for (double x = -4; x < length + 2;) {
    const double width = random.uniform(4.5, 9);
    double used = 0.7;
    for (const double share : {1.0, 0.75, 0.55}) {
      if (!add_front(from, line / length, side, x, share * width, random)) continue;
      used = share * width + (random.uniform() < 0.12 ? random.uniform(0.8, 2) : 0.05);
      break;
    }
    x += used;
  }
}

World OldTown::build() {
  add_terrain();
  add_steps_outside();
  add_passages();
  add_towers();
  for (std::size_t k = 0; k < route_.points().size(); ++k)
    for (const double side : {1.0, -1.0}) add_fronts(k, side);
  return {builder_.take(), ground_};
}

}  // namespace

void OldTownParams::describe(config::Binder& b, OldTownParams& params) {
  b.integer("seed", params.seed, "1", {.min = 0.0}, "of the layout");
  b.real("alley", params.alley, "m", {.min = 2.6, .max = 10.0},
         "least width between the fronts; the route is its middle");
  b.real("relief", params.relief, "m", {.min = 0.0, .max = 4.0}, "the ground rises and falls by up to this");
  b.integer("steps", params.steps, "1", {.min = 0.0, .max = 30.0},
            "outdoors, from the lower terrace to the upper one; 0: there is one terrace");
  b.real("curved", params.curved, "1", {.min = 0.0, .max = 1.0}, "share of the houses with a curved front");
  b.real("arcades", params.arcades, "1", {.min = 0.0, .max = 1.0}, "share of the houses that stand on columns");
  b.integer("passages", params.passages, "1", {.min = 0.0, .max = 20.0}, "vaults over the alley, where there is room");
  b.real("skew", params.skew, "deg", {.min = 0.0, .max = 15.0}, "fronts are turned against the alley by up to this");
}

World build_old_town(const OldTownParams& params, const Route& route, double) { return OldTown(params, route).build(); }

}  // namespace aslio::simulator
