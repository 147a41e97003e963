#include "aslio/simulator/worlds/street.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <optional>

#include "aslio/config/binder.hpp"
#include "purposes.hpp"
#include "worlds/building.hpp"
#include "worlds/greenery.hpp"
#include "worlds/street_furniture.hpp"
#include "worlds/vehicles.hpp"

namespace aslio::simulator {
namespace {

using namespace outdoor;
namespace mat = material;

constexpr double kHalfTurn = std::numbers::pi;
constexpr double kRunOut = 120;         ///< of the road beyond its ends [m]
constexpr double kBesideRoad = 70;      ///< from the road to the end of the terrain [m]
constexpr double kGroundStep = 2;       ///< of the terrain [m]
constexpr double kSlabLength = 2;       ///< pieces of asphalt and pavement [m]
constexpr double kAsphaltZ = 0.006;     ///< height of the asphalt above the ground [m]
constexpr double kLineZ = 0.01;         ///< of painted lines [m]
constexpr double kKerbZ = 0.13;         ///< of the pavements [m]
constexpr double kSideWidth = 6;        ///< of side streets [m]
constexpr double kSideLength = 55;      ///< [m]
constexpr double kSharpBend = 1 / 40.;  ///< nothing that needs a straight stands where the road bends more [1/m]

/// The middle of the whole road, out and back, as plots want it.
Route middle_of(const RoadLine& road, double lateral) {
  constexpr double kStep = 3;
  std::vector<Vec2> points{road.at(-kRunOut).beside(lateral)};
  const auto add = [&](double s) {
    const Vec2 p = road.at(s).beside(lateral);
    if ((p - points.back()).norm() > 1.5) points.push_back(p);
  };
  for (const RoadLine::Bend& bend : road.bends()) {
    const auto count = std::max(2, static_cast<int>(bend.length / kStep));
    for (int k = 0; k <= count; ++k) add(bend.begin + bend.length * k / count);
  }
  add(road.length() + kRunOut);
  for (std::size_t k = points.size() - 1; k-- > 1;) points.push_back(Vec2(points[k]));
  return Route(std::move(points));
}

class Street {
 public:
  Street(const StreetParams& params, const RoadLine& road)
      : params_(params),
        road_(road),
        right_(params.right_edge()),
        left_(params.left_edge()),
        middle_(middle_of(road, 0.5 * (right_ + left_))),
        plot_(middle_) {
    draw_waves();
    from_ = -kRunOut;
    to_ = road.length() + kRunOut;
  }
  World build();

 private:
  enum Part : std::uint64_t {
    kWaves = 1,
    kSides = 2,
    kHouses = 10,
    kCars = 20,
    kRails = 30,
    kTrees = 40,
    kSigns = 50,
    kFields = 60
  };
  RandomStream stream(std::uint64_t part, bool left = false) const {
    return {seed(), purpose::kLayout, part + (left ? 1 : 0)};
  }
  std::uint64_t seed() const { return static_cast<std::uint64_t>(params_.seed); }
  double height(const Vec2& p) const { return ground_.height(p.x(), p.y()); }
  /// `out` metres beyond an edge of the asphalt.
  double beyond(bool left, double out) const { return left ? left_ + out : right_ - out; }
  double half() const { return 0.5 * (left_ - right_); }
  double kerb_zone() const { return params_.pavement; }
  Vec3 surface(double s, double y, double up) const {
    const Vec2 p = road_.at(s).beside(y);
    return {p.x(), p.y(), height(p) + up};
  }
  /// x along the road on its right side, against it on its left, so that y points to the road.
  Placement facing(double s, double y, bool left, double turn = 0) const {
    const RoadLine::Place place = road_.at(s);
    const Vec2 p = place.beside(y);
    return {Vec3(p.x(), p.y(), height(p)), place.heading + (left ? kHalfTurn : 0) + turn};
  }
  bool put(const Placement& placement, const Vec2& low, const Vec2& high, double out, const std::function<void()>& add);
  bool at_side_street(double s, double margin) const;
  void draw_waves();
  void plan_side_streets();
  void add_ground();
  void add_strip(double s, double from, double to, double up, std::uint8_t reflectivity, double length = kSlabLength);
  void add_asphalt();
  void add_lines();
  void add_pavement(bool left);
  void add_side_street(double s, bool left);
  void add_houses(bool left);
  bool add_house(const Building& building, double s, bool left, double setback, RandomStream& look);
  void add_corner_houses();
  void add_parked(bool left);
  void add_rail(double y, double share, bool left);
  void add_rail_piece(double s, double length, double y);
  void add_lamps(bool left);
  void add_delineators(bool left);
  void add_signs(bool left);
  void add_trees(bool left);
  void add_fields(bool left);
  void add_bridges();

  const StreetParams& params_;
  const RoadLine& road_;
  double right_, left_;  ///< edges of the asphalt [m]
  Route middle_;
  Plot plot_;
  double from_ = 0, to_ = 0;  ///< along the road [m]
  Ground ground_;
  std::vector<double> side_streets_;
  MeshBuilder builder_;
};

bool Street::put(const Placement& placement, const Vec2& low, const Vec2& high, double out,
                 const std::function<void()>& add) {
  if (!plot_.claim(footprint(placement, low, high), half() + out)) return false;
  const auto placed = builder_.place(placement);
  add();
  return true;
}

void Street::draw_waves() {
  RandomStream random = stream(kWaves);
  const std::array<Vec2, 3> waves = {Vec2(0.5, 170), Vec2(0.3, 97), Vec2(0.2, 61)};
  for (const Vec2& wave : waves) {
    const double k = 2 * kHalfTurn / wave.y(), heading = random.uniform(0, 2 * kHalfTurn);
    ground_.waves.push_back({0.5 * params_.relief * wave.x(), k * std::cos(heading), k * std::sin(heading),
                             random.uniform(0, 2 * kHalfTurn)});
  }
}

bool Street::at_side_street(double s, double margin) const {
  return std::any_of(side_streets_.begin(), side_streets_.end(),
                     [&](double at) { return std::abs(s - at) < 0.5 * kSideWidth + margin; });
}

/// At equal distances but for a few metres, on straights.
void Street::plan_side_streets() {
  if (params_.side_streets <= 0) return;
  RandomStream random = stream(kSides);
  for (double s = from_ + params_.side_streets; s < to_ - 30; s += params_.side_streets) {
    const double at = s + random.uniform(-4, 4);
    bool straight = true;
    for (const double d : {-12.0, 0.0, 12.0}) straight = straight && std::abs(road_.at(at + d).curvature) < kSharpBend;
    if (straight) side_streets_.push_back(at);
  }
}

void Street::add_ground() {
  Vec2 low = middle_.low(), high = middle_.high();
  low.array() -= kBesideRoad;
  high.array() += kBesideRoad;
  builder_.terrain(low, high, kGroundStep, mat::kGrass, [&](double x, double y) { return ground_.height(x, y); });
}

void Street::add_strip(double s, double from, double to, double up, std::uint8_t reflectivity, double length) {
  constexpr double kAcross = 3;
  const auto parts = static_cast<int>(std::ceil((to - from) / kAcross));
  for (int k = 0; k < parts; ++k) {
    const double y0 = from + (to - from) * k / parts, y1 = from + (to - from) * (k + 1) / parts;
    builder_.quad(surface(s, y0, up), surface(s + length, y0, up), surface(s + length, y1, up), surface(s, y1, up),
                  reflectivity);
  }
}

void Street::add_asphalt() {
  const double lanes = static_cast<double>(params_.lanes);
  const double inner = (lanes - 0.5) * params_.lane;
  for (double s = from_; s < to_; s += kSlabLength) {
    if (params_.median > 0) {
      add_strip(s, right_, inner, kAsphaltZ, mat::kAsphalt);
      add_strip(s, inner + params_.median, left_, kAsphaltZ, mat::kAsphalt);
    } else {
      add_strip(s, right_, left_, kAsphaltZ, mat::kAsphalt);
    }
  }
}

/// Dashes between lanes, lines at the edges of the outer lanes.
void Street::add_lines() {
  const auto lanes = static_cast<int>(params_.lanes);
  const auto line = [&](double s, double y, double length) {
    builder_.quad(surface(s, y - 0.06, kLineZ), surface(s + length, y - 0.06, kLineZ),
                  surface(s + length, y + 0.06, kLineZ), surface(s, y + 0.06, kLineZ), mat::kWhitePaint);
  };
  std::vector<double> dashed;
  for (int k = 0; k + 1 < 2 * lanes; ++k) {
    const double y = (k + 0.5) * params_.lane + (k >= lanes ? params_.median : 0);
    if (params_.median <= 0 || k != lanes - 1) dashed.push_back(y);
  }
  for (double s = from_; s < to_ - 6; s += 6)
    for (const double y : dashed) line(s, y, 2);
  for (double s = from_; s < to_; s += kSlabLength)
    for (const double y : {right_ + params_.shoulder, left_ - params_.shoulder}) line(s, y, kSlabLength);
}

void Street::add_pavement(bool left) {
  if (kerb_zone() <= 0) return;
  for (double s = from_; s < to_; s += kSlabLength) {
    if (at_side_street(s + 0.5 * kSlabLength, 0.5 * kSlabLength)) continue;
    const double inner = beyond(left, 0), outer = beyond(left, kerb_zone());
    const auto at = [&](double along, double y, double up) { return surface(s + along, y, up); };
    builder_.quad(at(0, inner, kKerbZ), at(kSlabLength, inner, kKerbZ), at(kSlabLength, outer, kKerbZ),
                  at(0, outer, kKerbZ), 85);
    for (const double y : {inner, outer})
      builder_.quad(at(0, y, -0.1), at(kSlabLength, y, -0.1), at(kSlabLength, y, kKerbZ), at(0, y, kKerbZ), 150);
    for (const double along : {0.0, kSlabLength})
      builder_.quad(at(along, inner, -0.1), at(along, outer, -0.1), at(along, outer, kKerbZ), at(along, inner, kKerbZ),
                    mat::kConcrete);
  }
}

/// Straight away from the road; no other house stands on it.
void Street::add_side_street(double s, bool left) {
  const Placement placement = facing(s, beyond(left, 0), left);
  // In the placement's frame the street goes towards -y.
  const Vec2 low(-0.5 * kSideWidth - 1, -kSideLength), high(0.5 * kSideWidth + 1, -0.5);
  if (!plot_.claim(footprint(placement, low, high), half())) return;
  const RoadLine::Place place = road_.at(s);
  const Vec2 along(std::cos(place.heading), std::sin(place.heading)),
      out = Vec2(-along.y(), along.x()) * (left ? 1 : -1);
  const auto at = [&](double x, double y) {
    const Vec2 p = placement.origin.head<2>() + x * along + y * out;
    return Vec3(p.x(), p.y(), height(p) + kAsphaltZ);
  };
  for (double y = 0; y < kSideLength; y += kSlabLength)
    for (const double x : {-0.5 * kSideWidth, 0.0})
      builder_.quad(at(x, y), at(x + 0.5 * kSideWidth, y), at(x + 0.5 * kSideWidth, y + kSlabLength),
                    at(x, y + kSlabLength), mat::kAsphalt);
}

bool Street::add_house(const Building& building, double s, bool left, double setback, RandomStream& look) {
  const double y = beyond(left, kerb_zone() + setback + 1.1 + 0.5 * building.depth);
  Placement placement = facing(s, y, left);
  const Footprint area = footprint(building, placement);
  if (!plot_.claim(area, half() + kerb_zone() + 0.4 * setback)) return false;
  double lowest = placement.origin.z();
  for (const Vec2& corner : area.corners()) lowest = std::min(lowest, height(corner));
  placement.origin.z() = lowest + 0.15;
  const auto placed = builder_.place(placement);
  add_building(builder_, look, building);
  return true;
}

/// Rows of houses; copies have the same windows, doors and distances.
void Street::add_houses(bool left) {
  if (params_.houses <= 0) return;
  RandomStream random = stream(kHouses, left);
  std::optional<Building> model;
  RandomStream model_look = random;
  double setback = 0, gap = 3;
  for (double s = from_ + random.uniform(0, 8); s < to_ - 20;) {
    const bool copy = random.uniform() < params_.alike && model.has_value();
    const double width = random.uniform(12, 26), depth = random.uniform(8, 13), keep = random.uniform();
    const double back = random.uniform(params_.setback_min, params_.setback_max), free = random.uniform(0.6, 7);
    const Building drawn = draw_building(random, width, depth);
    if (!copy) {
      model = drawn;
      model_look = random;
      setback = back;
      gap = free;
    }
    if (keep >= params_.houses) {
      s += model->width + gap;
      continue;
    }
    RandomStream look = model_look;
    s += add_house(*model, s + 0.5 * model->width, left, setback, look) ? model->width + gap : 3;
  }
}

/// Both sides of the side streets.
void Street::add_corner_houses() {
  if (params_.houses <= 0) return;
  RandomStream random = stream(kSides + 100);
  for (const double s : side_streets_)
    for (const bool left : {false, true})
      for (const double side : {-1.0, 1.0}) {
        const double depth = random.uniform(8, 12), width = random.uniform(12, 18);
        const Building building = draw_building(random, width, depth);
        const double x = s + side * (0.5 * kSideWidth + 2.5 + 0.5 * width);
        add_house(building, x, left, 22 + random.uniform(0, 4), random);
      }
}

void Street::add_parked(bool left) {
  if (params_.shoulder < 2) return;
  RandomStream random = stream(kCars, left);
  for (double s = from_; s < to_; s += random.uniform(5.6, 6.4)) {
    const double taken = random.uniform(), skew = random.uniform(-0.03, 0.03), off = random.uniform(-0.08, 0.08);
    const Vehicle vehicle = draw_vehicle(random);
    if (taken >= params_.parked || at_side_street(s, 5) || std::abs(road_.at(s).curvature) > kSharpBend) continue;
    const Placement placement = facing(s, beyond(left, off - 0.5 * params_.shoulder + 0.05), left, skew);
    const auto placed = builder_.place(placement);
    add_vehicle(builder_, vehicle);
  }
}

/// Two plates and the cap between them, on a post.
void Street::add_rail_piece(double s, double length, double y) {
  constexpr double kHalfThick = 0.04, kLow = 0.44, kHigh = 0.75;
  const auto at = [&](double along, double across, double up) { return surface(s + along, y + across, up); };
  for (const double side : {-kHalfThick, kHalfThick})
    builder_.quad(at(0, side, kLow), at(length, side, kLow), at(length, side, kHigh), at(0, side, kHigh), mat::kMetal);
  builder_.quad(at(0, -kHalfThick, kHigh), at(length, -kHalfThick, kHigh), at(length, kHalfThick, kHigh),
                at(0, kHalfThick, kHigh), mat::kMetal);
  const auto placed = builder_.place(facing(s, y, false));
  builder_.box({-0.05, -0.03, -0.3}, {0.05, 0.03, 0.72}, mat::kMetal);
}

void Street::add_rail(double y, double share, bool left) {
  constexpr double kStretch = 48, kPiece = 4;
  RandomStream random = stream(kRails + (y > right_ && y < left_ ? 2 : 0), left);
  for (double s = from_; s < to_; s += kStretch) {
    if (random.uniform() >= share) continue;
    for (double along = 0; along < kStretch; along += kPiece) {
      const double at = s + along;
      if (at_side_street(at + 0.5 * kPiece, 0.5 * kPiece)) continue;
      const double length = std::abs(road_.at(at + 0.5 * kPiece).curvature) > kSharpBend ? 0.5 * kPiece : kPiece;
      for (double part = 0; part < kPiece; part += length) add_rail_piece(at + part, length, y);
    }
  }
}

void Street::add_lamps(bool left) {
  if (params_.lamps <= 0) return;
  const double tall = kerb_zone() > 0 ? 6.5 : 10;
  for (double s = from_ + (left ? 0.5 : 0) * params_.lamps; s < to_; s += params_.lamps)
    put(facing(s, beyond(left, kerb_zone() > 0 ? 0.45 : 1.1), left), {-0.2, -0.2}, {0.2, 0.2}, 0,
        [&] { add_lamp_post(builder_, tall); });
}

/// White posts where there is no kerb.
void Street::add_delineators(bool left) {
  if (kerb_zone() > 0) return;
  for (double s = from_; s < to_; s += 50) {
    const auto placed = builder_.place(facing(s, beyond(left, 0.75), left));
    builder_.box({-0.06, -0.05, -0.2}, {0.06, 0.05, 1.05}, mat::kWhitePaint);
  }
}

void Street::add_signs(bool left) {
  RandomStream random = stream(kSigns, left);
  const bool large = kerb_zone() <= 0;
  for (double s = from_ + random.uniform(0, 60); s < to_; s += random.uniform(40, 110) * (large ? 2 : 1)) {
    const double width = large ? random.uniform(1.5, 3) : random.uniform(0.45, 0.75);
    put(facing(s, beyond(left, large ? 2.6 : 0.4), left, 0.5 * kHalfTurn * (left ? 1 : -1)), {-0.5 * width, -0.1},
        {0.5 * width, 0.1}, 0, [&] { add_sign(builder_, width); });
  }
}

/// In a row at the far edge of the pavement; behind the rails at random.
void Street::add_trees(bool left) {
  if (params_.trees <= 0) return;
  RandomStream random = stream(kTrees, left);
  const double step = (kerb_zone() > 0 ? 13 : 17) / params_.trees;
  for (double s = from_ + random.uniform(0, step); s < to_; s += step * random.uniform(0.9, 1.1)) {
    const double tall = random.uniform(5, 9.5), out = random.uniform(3, 25), kind = random.uniform();
    const double y = beyond(left, kerb_zone() > 0 ? kerb_zone() - 0.4 : out);
    if (kerb_zone() > 0 || kind < 0.6) {
      put(facing(s, y, left), {-0.5, -0.5}, {0.5, 0.5}, 0, [&] { add_tree(builder_, random, tall); });
    } else {
      const double r = 0.16 * tall;
      put(facing(s, y, left), {-r, -r}, {r, r}, 0.3, [&] { add_bush(builder_, random, r, 1.4 * r); });
    }
  }
}

/// Bushes and low mounds of earth far from the road, where no house hides them.
void Street::add_fields(bool left) {
  if (params_.trees <= 0) return;
  RandomStream random = stream(kFields, left);
  for (double s = from_; s < to_; s += 22 / params_.trees) {
    const double out = kerb_zone() + random.uniform(8, 60), r = random.uniform(0.6, 1.6), along = random.uniform(0, 20);
    const double flat = random.uniform(0.4, 1.1);
    put(facing(s + along, beyond(left, out), left), {-r, -r}, {r, r}, 6, [&] {
      if (flat > 0.7)
        add_bush(builder_, random, r, 1.4 * r * flat);
      else
        builder_.ellipsoid({0, 0, 0}, {2 * r, r, flat}, 4, mat::kGrass);
    });
  }
}

/// A deck of concrete on piers beside the road.
void Street::add_bridges() {
  if (params_.bridges <= 0) return;
  for (double s = from_ + 0.6 * params_.bridges; s < to_; s += params_.bridges) {
    const auto placed = builder_.place(facing(s, 0.5 * (left_ + right_), false));
    const double span = half() + 3;
    builder_.box({-4, -span - 25, 5.4}, {4, span + 25, 6.3}, mat::kConcrete);
    for (const double x : {-4.0, 3.8}) builder_.box({x, -span - 25, 6.3}, {x + 0.2, span + 25, 7.3}, mat::kMetal);
    for (const double side : {-1.0, 1.0})
      for (const double x : {-3.0, 2.0}) {
        const double y = side * (half() + 1.6);
        builder_.box({x, y - 0.5, -2}, {x + 1, y + 0.5, 5.4}, mat::kConcrete);
      }
  }
}

World Street::build() {
  plan_side_streets();
  add_ground();
  add_asphalt();
  add_lines();
  for (const bool left : {false, true}) {
    for (const double s : side_streets_) add_side_street(s, left);
    add_pavement(left);
    add_houses(left);
  }
  add_corner_houses();
  const double inner = (static_cast<double>(params_.lanes) - 0.5) * params_.lane;
  for (const bool left : {false, true}) {
    add_parked(left);
    if (params_.guard_rails > 0) add_rail(beyond(left, 0.35), params_.guard_rails, left);
    if (params_.median > 0) add_rail(left ? inner + params_.median - 0.3 : inner + 0.3, 1, left);
    add_lamps(left);
    add_delineators(left);
    add_signs(left);
    add_trees(left);
    add_fields(left);
  }
  add_bridges();
  return {builder_.take(), ground_};
}

}  // namespace

void StreetParams::describe(config::Binder& b, StreetParams& params) {
  const config::Range share{.min = 0.0, .max = 1.0};
  const config::Range spacing{.min = 0.0, .max = 1000.0};
  b.integer("seed", params.seed, "1", {.min = 0.0}, "of the layout");
  b.real("relief", params.relief, "m", {.min = 0.0, .max = 2.0}, "the ground rises and falls by up to this");
  b.integer("lanes", params.lanes, "1", {.min = 1.0, .max = 4.0},
            "in each direction; the car drives in the rightmost one");
  b.real("lane", params.lane, "m", {.min = 2.5, .max = 5.0}, "width of a lane");
  b.real("median", params.median, "m", {.min = 0.0, .max = 20.0},
         "between the directions, with a guard rail on both of its edges; 0: none");
  b.real("shoulder", params.shoulder, "m", {.min = 0.2, .max = 5.0},
         "beside the outer lanes; vehicles park there when it has 2 m or more");
  b.real("pavement", params.pavement, "m", {.min = 0.0, .max = 6.0}, "width of the pavements; 0: none, no kerbs");
  b.real("guard_rails", params.guard_rails, "1", share, "share of the outer edges with a guard rail");
  b.real("houses", params.houses, "1", share, "share of the fronts with a house");
  b.real("alike", params.alike, "1", share, "share of the houses that are copies of the one before");
  b.real("setback_min", params.setback_min, "m", {.min = 0.0, .max = 50.0}, "from the pavements to the houses, least");
  b.real("setback_max", params.setback_max, "m", {.min = 0.0, .max = 50.0}, "from the pavements to the houses, most");
  b.real("side_streets", params.side_streets, "m", spacing, "distance of one side street from the next; 0: none");
  b.real("lamps", params.lamps, "m", spacing, "distance of one lamp post from the next on each side; 0: none");
  b.real("trees", params.trees, "1", {.min = 0.0, .max = 2.0}, "trees and bushes: 0 none, 1 usual");
  b.real("parked", params.parked, "1", share, "share of the places on the shoulders with a vehicle");
  b.real("bridges", params.bridges, "m", spacing, "distance of one bridge over the road from the next; 0: none");
  b.require(params.setback_min <= params.setback_max, "setback_min", "must not be above setback_max");
  const auto far_enough = [](double distance) { return distance == 0 || distance >= 5; };
  b.require(far_enough(params.lamps), "lamps", "must be 0 or at least 5 m");
  b.require(params.side_streets == 0 || params.side_streets >= 30, "side_streets", "must be 0 or at least 30 m");
  b.require(params.bridges == 0 || params.bridges >= 30, "bridges", "must be 0 or at least 30 m");
}

World build_street(const StreetParams& params, const RoadLine& road) { return Street(params, road).build(); }

}  // namespace aslio::simulator
