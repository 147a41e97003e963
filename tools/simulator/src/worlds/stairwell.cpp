#include "aslio/simulator/worlds/stairwell.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "aslio/config/binder.hpp"
#include "aslio/core/errors.hpp"
#include "aslio/simulator/random.hpp"
#include "purposes.hpp"
#include "worlds/curved.hpp"
#include "worlds/flight.hpp"

namespace aslio::simulator {
namespace {

namespace m = material;

constexpr double kMain = 2.2, kHalf = 1.9;         // depth of the landings: with doors, and between the storeys [m]
constexpr double kTurnMain = 1.1, kTurnHalf = 1;   // from the flights to where the walk turns on them [m]
constexpr double kSlab = 0.2, kWallThick = 0.2;    // [m]
constexpr double kDoor = 1.1, kDoorHeight = 2.25;  // [m]
constexpr double kRiser = 0.17;                    // about [m]
constexpr double kHall = 1.1, kHallHeight = 2.6;   // half the width of the corridors, and their height [m]
constexpr double kBehind = 1.5;                    // from the start to the end of its corridor [m]
constexpr double kRoof = 2.9;                      // above the highest landing [m]
constexpr double kTolerance = 0.01;                // [m]

/// For messages: to 1 mm, without a sign before 0.
double rounded(double x) { return std::round(1000 * x) / 1000 + 0.0; }

/// x along the flights from their first risers, y to the left from the middle of the well, z from the lowest floor.
struct Shape {
  explicit Shape(const StairwellParams& p)
      : storeys(static_cast<int>(p.storeys)), storey(p.storey_height), lane(0.5 * (p.gap + p.width)) {
    flight.steps = std::max(2, static_cast<int>(std::lround(0.5 * storey / kRiser)));
    flight.rise = 0.5 * storey / flight.steps;
    flight.tread = p.tread;
    flight.right = -0.5 * p.width;
    flight.left = 0.5 * p.width;
    half_width = p.width + 0.5 * p.gap;
    out = kMain + kWallThick + p.corridor;
  }
  int storeys;
  double storey;
  double lane;        ///< distance of the middle of a flight from that of the well [m]
  double half_width;  ///< of the well [m]
  double out;         ///< from the flights back to the start [m]
  Flight flight;
  double back() const { return flight.length() + kHalf; }
};

std::vector<Vec2> local_route(const Shape& s) {
  const double far = s.flight.length() + kTurnHalf;
  std::vector<Vec2> up{{far, -s.lane}, {far, s.lane}};
  for (int k = 1; k < s.storeys; ++k) {
    for (const Vec2& p : {Vec2(-kTurnMain, s.lane), Vec2(-kTurnMain, -s.lane), Vec2(far, -s.lane), Vec2(far, s.lane)})
      up.push_back(p);
  }
  std::vector<Vec2> round{{-s.out, -s.lane}};
  round.insert(round.end(), up.begin(), up.end());
  round.emplace_back(-s.out, s.lane);
  round.insert(round.end(), up.rbegin(), up.rend());
  return round;
}

/// From the frame of the stairs to that of the route.
Placement placement_of(const Shape& s, const Route& route) {
  const Vec2 start = route.points().front(), along = route.at(0).direction;
  const Vec2 origin = start + s.out * along + s.lane * Vec2(-along.y(), along.x());
  return {Vec3(origin.x(), origin.y(), 0), std::atan2(along.y(), along.x())};
}

Vec2 placed(const Placement& frame, const Vec2& p) {
  const double c = std::cos(frame.yaw), s = std::sin(frame.yaw);
  return frame.origin.head<2>() + Vec2(c * p.x() - s * p.y(), s * p.x() + c * p.y());
}

void require_route(const Shape& shape, const Route& route, double scale) {
  if (scale != 1)
    throw ConfigError(
        fmt::format("world: a stairwell has the size of a person's step and cannot be scaled by {:g}: use scale 1 and "
                    "set world.storeys",
                    scale));
  const Placement frame = placement_of(shape, route);
  std::vector<Vec2> wanted = local_route(shape);
  std::string list;
  for (Vec2& p : wanted) {
    p = placed(frame, p);
    list += fmt::format("{}{{x: {:.3f}, y: {:.3f}}}", list.empty() ? "" : ", ", rounded(p.x()), rounded(p.y()));
  }
  const std::vector<Vec2>& points = route.points();
  for (std::size_t k = 0; k < std::max(points.size(), wanted.size()); ++k) {
    if (k < points.size() && k < wanted.size() && (points[k] - wanted[k]).norm() < kTolerance) continue;
    const std::string what = k >= points.size()   ? fmt::format("point {} is missing", k + 1)
                             : k >= wanted.size() ? fmt::format("point {} is one too many", k + 1)
                                                  : fmt::format("point {} at ({:.3f}, {:.3f}) [m] is off the stairs",
                                                                k + 1, points[k].x(), points[k].y());
    throw ConfigError(fmt::format(
        "route: {}. With these keys of world, its first point and its first direction, give route: [{}]", what, list));
  }
}

class Builder {
 public:
  Builder(const StairwellParams& params, const Shape& shape)
      : params_(params), shape_(shape), seed_(static_cast<std::uint64_t>(params.seed)) {}

  Mesh build(const Placement& frame) {
    const auto here = builder_.place(frame);
    add_shaft();
    for (int k = 0; k < shape_.storeys; ++k) add_storey(k);
    for (int k = 0; k <= shape_.storeys; ++k) {
      add_door_wall(k);
      add_corridor(k);
      if (params_.clutter > 0) add_things(k);
    }
    return builder_.take();
  }
  /// y of the middle of the door; the walk passes the first and the last.
  double door(int storey) const {
    if (storey == 0) return -shape_.lane;
    if (storey == shape_.storeys) return shape_.lane;
    RandomStream random(seed_, purpose::kLayout, static_cast<std::uint64_t>(storey));
    return random.uniform(-1, 1) * (shape_.half_width - 0.5 * kDoor - 0.2);
  }

 private:
  double top() const { return shape_.storeys * shape_.storey + kRoof; }
  void add_shaft();
  void add_storey(int storey);
  void add_flight(double z, bool back);
  void add_door_wall(int storey);
  void add_corridor(int storey);
  void add_things(int storey);

  const StairwellParams& params_;
  const Shape& shape_;
  std::uint64_t seed_;
  MeshBuilder builder_;
};

/// Floor, roof and the three walls without doors, with window frames in the one behind the half landings.
void Builder::add_shaft() {
  const double w = shape_.half_width, back = shape_.back();
  builder_.slab({-kMain, -w}, {back, w}, 0, m::kConcrete);
  builder_.slab({-kMain, -w}, {back, w}, top(), m::kPlaster);
  for (const double y : {-w, w}) builder_.wall({-kMain, y}, {back, y}, 0, top(), m::kPlaster);
  builder_.wall({back, -w}, {back, w}, 0, top(), m::kPlaster);
  for (int k = 0; k < shape_.storeys; ++k) {
    const double sill = (k + 0.5) * shape_.storey + 1.0, head = sill + 1.3;
    builder_.box({back - 0.12, -0.8, sill - 0.04}, {back, 0.8, sill}, m::kConcrete);
    builder_.box({back - 0.03, -0.65, sill}, {back - 0.02, 0.65, head}, m::kGlass);
    for (const double y : {-0.7, -0.03, 0.64})
      builder_.box({back - 0.06, y, sill}, {back, y + 0.06, head}, m::kWhitePaint);
    builder_.box({back - 0.06, -0.7, head}, {back, 0.7, head + 0.06}, m::kWhitePaint);
  }
}

/// Up from `z`; the second flight of a storey leads back.
void Builder::add_flight(double z, bool back) {
  const auto here = back ? builder_.place({Vec3(shape_.flight.length(), shape_.lane, z), std::numbers::pi})
                         : builder_.place({Vec3(0, -shape_.lane, z), 0});
  add_steps(builder_, shape_.flight, m::kConcrete);
  // The inner side is on the left of either flight.
  add_handrail(builder_, shape_.flight, shape_.flight.left - 0.03, true);
  add_handrail(builder_, shape_.flight, shape_.flight.right + 0.07, false);
}

void Builder::add_storey(int storey) {
  const double w = shape_.half_width, end = shape_.flight.length();
  const double floor = storey * shape_.storey, half = floor + 0.5 * shape_.storey, next = floor + shape_.storey;
  add_flight(floor, false);
  add_flight(half, true);
  builder_.box({end, -w, half - kSlab}, {shape_.back(), w, half}, m::kConcrete);
  builder_.box({-kMain, -w, next - kSlab}, {0, w, next}, m::kConcrete);
  // The rails of two flights meet round the gap.
  const double y = shape_.lane - shape_.flight.left + 0.03;
  for (const double z : {half, next}) {
    const double x = z == half ? end + 0.02 : -0.02, up = z + 0.9 + (z == half ? -0.5 : 0.5) * shape_.flight.rise;
    curved::add_bar(builder_, {x, -y, up}, {x, y, up}, 0.022, m::kWood);
  }
  if (storey + 1 < shape_.storeys) return;
  // Nothing leads on from the highest landing: a guard before the drop.
  for (const double up : {0.3, 0.6, 0.95})
    curved::add_bar(builder_, {-0.05, -w, next + up}, {-0.05, -y, next + up}, 0.022, m::kMetal);
  for (int k = 0; k <= 10; ++k) {
    const double across = -w + 0.05 + k * (w - y - 0.05) / 10;
    curved::add_bar(builder_, {-0.05, across, next}, {-0.05, across, next + 0.95}, 0.014, m::kMetal);
  }
}

void Builder::add_door_wall(int storey) {
  const double w = shape_.half_width, floor = storey * shape_.storey, y = door(storey);
  const double ceiling = storey == shape_.storeys ? top() : floor + shape_.storey;
  const double low = y - 0.5 * kDoor, high = y + 0.5 * kDoor, x0 = -kMain - kWallThick, x1 = -kMain;
  builder_.box({x0, -w, floor}, {x1, low, ceiling}, m::kPlaster);
  builder_.box({x0, high, floor}, {x1, w, ceiling}, m::kPlaster);
  builder_.box({x0, low, floor + kDoorHeight}, {x1, high, ceiling}, m::kPlaster);
  builder_.slab({x0, low}, {x1, high}, floor, m::kConcrete);
  for (const double edge : {low, high})
    builder_.box({x1, edge - 0.06, floor}, {x1 + 0.02, edge + 0.06, floor + kDoorHeight}, m::kMetal);
  // The leaf stands open in the corridor.
  builder_.box({x0 - 1.0, low - 0.12, floor + 0.01}, {x0, low - 0.08, floor + kDoorHeight}, m::kWood);
}

void Builder::add_corridor(int storey) {
  const double y = door(storey), floor = storey * shape_.storey;
  const double x0 = -shape_.out - kBehind, x1 = -kMain - kWallThick;
  builder_.slab({x0, y - kHall}, {x1, y + kHall}, floor, m::kConcrete);
  builder_.slab({x0, y - kHall}, {x1, y + kHall}, floor + kHallHeight, m::kPlaster);
  for (const double side : {-kHall, kHall})
    builder_.wall({x0, y + side}, {x1, y + side}, floor, floor + kHallHeight, m::kPlaster);
  builder_.wall({x0, y - kHall}, {x0, y + kHall}, floor, floor + kHallHeight, m::kPlaster);
  // Beside and above the door the wall of the well closes the corridor, but it may end before the corridor does.
  builder_.wall({x1, y - kHall}, {x1, y - 0.5 * kDoor}, floor, floor + kHallHeight, m::kPlaster);
  builder_.wall({x1, y + 0.5 * kDoor}, {x1, y + kHall}, floor, floor + kHallHeight, m::kPlaster);
  RandomStream random(seed_, purpose::kLayout, 100 + static_cast<std::uint64_t>(storey));
  for (const double side : {-1.0, 1.0}) {
    for (double x = x1 - random.uniform(1.2, 2.4); x > x0 + 1; x -= random.uniform(2, 3.5)) {
      const double depth = random.uniform(0.02, 0.06), wall = y + side * kHall, inner = wall - side * depth;
      const auto on_wall = [&](double from, double to, double up, double head, std::uint8_t reflectivity) {
        builder_.box({x + from, std::min(inner, wall), floor + up}, {x + to, std::max(inner, wall), floor + head},
                     reflectivity);
      };
      on_wall(-0.5, -0.42, 0, 2.1, m::kMetal);
      on_wall(0.42, 0.5, 0, 2.1, m::kMetal);
      on_wall(-0.5, 0.5, 2.1, 2.2, m::kMetal);
      if (random.uniform() < 0.5) on_wall(0.7, 1.2, 1.2, 1.8, m::kWood);
    }
  }
  for (double x = x0 + 1; x < x1 - 0.8; x += 2.5)
    builder_.box({x, y - 0.15, floor + kHallHeight - 0.08}, {x + 1.2, y + 0.15, floor + kHallHeight}, m::kWhitePaint);
}

/// On the landing: pipes, a cabinet, a sign with bars that stand for the number of the storey.
void Builder::add_things(int storey) {
  RandomStream random(seed_, purpose::kLayout, 200 + static_cast<std::uint64_t>(storey));
  const double w = shape_.half_width, floor = storey * shape_.storey, back = shape_.back();
  const double height = storey == shape_.storeys ? kRoof : shape_.storey - kSlab;
  const double side = random.uniform() < 0.5 ? -1 : 1, x = random.uniform(-kMain + 0.3, -0.9);
  const double cabinet = side * (w - 0.14);
  builder_.box({x, std::min(cabinet, side * w), floor + 0.9}, {x + 0.5, std::max(cabinet, side * w), floor + 1.6},
               m::kMetal);
  const double pipe = random.uniform(0.03, 0.06);
  curved::add_column(builder_, {-kMain + 0.08, -side * (w - 0.08), floor}, pipe, pipe, height, m::kMetal, 16);
  for (int k = 0; k <= storey; ++k) {
    const double y = -side * (w - 0.015), from = random.uniform(0.06, 0.09) + 0.16 * k;
    builder_.box({-1.2 + from, std::min(y, -side * w), floor + 1.5}, {-1.1 + from, std::max(y, -side * w), floor + 1.9},
                 m::kBlackPaint);
  }
  if (storey == shape_.storeys) return;
  const double half = floor + 0.5 * shape_.storey, length = random.uniform(0.6, 1.2) * std::min(1.0, params_.clutter);
  builder_.box({back - 0.1, -0.5 * length, half + 0.12}, {back - 0.02, 0.5 * length, half + 0.75}, m::kWhitePaint);
  for (double y = -0.5 * length + 0.05; y < 0.5 * length - 0.04; y += 0.08)
    builder_.box({back - 0.13, y, half + 0.15}, {back - 0.1, y + 0.04, half + 0.72}, m::kWhitePaint);
}

std::vector<Climb> climbs_of(const Shape& shape, const Placement& frame) {
  const auto flights = static_cast<std::size_t>(2 * shape.storeys);
  const double c = std::cos(frame.yaw), s = std::sin(frame.yaw);
  const double origin = c * frame.origin.x() + s * frame.origin.y();
  const auto climb = [&](std::size_t edge, bool forth, double up) {
    Climb result{edge, {}};
    // Backwards the last riser comes first.
    const double heading = frame.yaw + (forth ? 0 : std::numbers::pi);
    add_ramps(result.ground, shape.flight, heading, forth ? origin : -origin - shape.flight.length(), up);
    return result;
  };
  std::vector<Climb> climbs;
  for (std::size_t k = 0; k < flights; ++k) climbs.push_back(climb(2 * k, k % 2 == 0, 1));
  for (std::size_t k = 0; k < flights; ++k) climbs.push_back(climb(2 * flights - 1 + 2 * k, k % 2 == 0, -1));
  return climbs;
}

}  // namespace

void StairwellParams::describe(config::Binder& b, StairwellParams& params) {
  b.integer("seed", params.seed, "1", {.min = 0.0}, "of the clutter, and of the doors on the way");
  b.integer("storeys", params.storeys, "1", {.min = 1.0, .max = 30.0}, "that the walk climbs; the route must fit");
  b.real("storey_height", params.storey_height, "m", {.min = 2.8, .max = 6.0}, "from floor to floor");
  b.real("width", params.width, "m", {.min = 1.5, .max = 4.0}, "of a flight of steps");
  b.real("gap", params.gap, "m", {.min = 0.05, .max = 5.0}, "between the flight up and the flight back");
  b.real("tread", params.tread, "m", {.min = 0.22, .max = 0.32}, "depth of a step");
  b.real("corridor", params.corridor, "m", {.min = 2.0, .max = 50.0},
         "from the stairs to where the walk begins, and to where it turns round at the top");
  b.real("clutter", params.clutter, "1", {.min = 0.0, .max = 1.0}, "things on the walls: 0 none, 1 usual");
}

std::vector<Vec2> stairwell_route(const StairwellParams& params) {
  const Shape shape(params);
  std::vector<Vec2> points = local_route(shape);
  for (Vec2& p : points) p += Vec2(shape.out, shape.lane);
  return points;
}

World build_stairwell(const StairwellParams& params, const Route& route, double scale) {
  const Shape shape(params);
  require_route(shape, route, scale);
  const Placement frame = placement_of(shape, route);
  return {Builder(params, shape).build(frame), {}, climbs_of(shape, frame)};
}

std::vector<Vec3> stairwell_doors(const StairwellParams& params, const Route& route) {
  const Shape shape(params);
  const Placement frame = placement_of(shape, route);
  std::vector<Vec3> doors;
  for (const double y : {-shape.lane, shape.lane}) {
    const Vec2 p = placed(frame, {-kMain - 0.5 * kWallThick, y});
    doors.emplace_back(p.x(), p.y(), y < 0 ? 0 : shape.storeys * shape.storey);
  }
  return doors;
}

}  // namespace aslio::simulator
