#include "aslio/simulator/worlds/office.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "aslio/config/binder.hpp"
#include "purposes.hpp"
#include "worlds/floor_plan.hpp"
#include "worlds/furniture.hpp"

namespace aslio::simulator {
namespace {

using namespace indoor;

constexpr double kRouteDoor = 1.0;  ///< width of the doors on the route [m]

/// From one street of the walk to its rooms.
struct Corridor {
  Run run;
  double half = 1.1;
  double begin = 0, end = 0;  ///< beyond the corners
};

struct Room {
  Rect area;
  std::uint64_t part = 0;  ///< of its random stream
};

/// The floor plan while it is drawn up.
class Office {
 public:
  Office(const OfficeParams& params, const Route& route, double scale)
      : params_(params),
        seed_(static_cast<std::uint64_t>(params.seed)),
        route_(route),
        runs_(runs_of(route, "office")) {
    for (const OfficeRoom& room : params.rooms)
      given_.push_back(grown(Rect{scale * Vec2(room.low_x, room.low_y), scale * Vec2(room.high_x, room.high_y)}));
    for (const Rect& room : given_) plan_.add({room, 0, params.height});
    for (std::size_t k = 0; k < runs_.size(); ++k) add_corridor(k);
    for (std::size_t k = 0; k < corridors_.size(); ++k) {
      add_rooms(k, -1);
      add_rooms(k, 1);
    }
    std::vector<Rect> lit = given_;
    for (const Room& room : rooms_) lit.push_back(room.area);
    windows_ = add_windows(plan_, lit, params.height);
  }

  const std::vector<Door>& route_doors() const { return route_doors_; }
  World build() const;

 private:
  Rect grown(Rect room) const;
  void add_corridor(std::size_t index);
  void add_rooms(std::size_t index, double side);
  bool add_room(const Corridor& corridor, double side, double begin, double end, RandomStream& random);

  OfficeParams params_;
  std::uint64_t seed_;
  const Route& route_;
  std::vector<Run> runs_;
  FloorPlan plan_;
  std::vector<Rect> given_;
  std::vector<Corridor> corridors_;
  std::vector<Door> doors_, route_doors_;
  std::vector<Room> rooms_;
  std::vector<Rect> windows_;
};

/// A room that leaves 1 m beside the part of the route in it.
Rect Office::grown(Rect room) const {
  for (const Run& run : runs_) {
    const int across = 1 - run.axis;
    if (run.at <= room.low[across] || run.at >= room.high[across]) continue;
    if (run.hi <= room.low[run.axis] || run.lo >= room.high[run.axis]) continue;
    room.low[across] = std::min(room.low[across], run.at - 1);
    room.high[across] = std::max(room.high[across], run.at + 1);
  }
  for (const Vec2& p : route_.points()) {
    if (!room.contains(p)) continue;
    room.low = room.low.cwiseMin(Vec2(p.array() - 1));
    room.high = room.high.cwiseMax(Vec2(p.array() + 1));
  }
  return room;
}

/// The run and a bit beyond its ends, so that a crossing opens views; rooms interrupt it, with doors.
void Office::add_corridor(std::size_t index) {
  const Run& run = runs_[index];
  RandomStream random(seed_, purpose::kLayout, index);
  Corridor c{run, 0.5 * params_.corridor_width + random.uniform(-0.075, 0.075)};
  c.begin = run.lo - c.half - random.uniform(1, 4);
  c.end = run.hi + c.half + random.uniform(1, 4);
  double from = c.begin;
  std::vector<Rect> through;
  for (const Rect& room : given_) {
    const int across = 1 - run.axis;
    if (run.at > room.low[across] && run.at < room.high[across]) through.push_back(room);
  }
  std::sort(through.begin(), through.end(),
            [&](const Rect& a, const Rect& b) { return a.low[run.axis] < b.low[run.axis]; });
  const auto piece = [&](double begin, double end) {
    if (begin < end) plan_.add({run.rect(begin, end, -c.half, c.half), 0, params_.height});
  };
  const auto door = [&](double face, double direction) {
    Door d;
    d.at = run.point(face);
    d.normal = run.axis == 0 ? Vec2(direction, 0) : Vec2(0, direction);
    d.width = kRouteDoor;
    d.swing = 2.7;
    d.hinge_left = random.uniform() < 0.5;
    route_doors_.push_back(d);
    add_door(plan_, d);
  };
  for (const Rect& room : through) {
    const double low = room.low[run.axis], high = room.high[run.axis];
    // What led from a corner in a room away from it would be a corridor that nobody walks.
    if (run.hi <= low) {
      c.end = std::min(c.end, low - kWall);
    } else if (run.lo >= high) {
      c.begin = from = std::max(c.begin, high + kWall);
    } else {
      if (run.lo < low) piece(from, low - kWall);
      if (run.lo < low) door(low - kWall, -1);
      if (run.hi > high) door(high + kWall, 1);
      from = high + kWall;
      if (run.lo >= low) c.begin = from;
      if (run.hi <= high) c.end = low - kWall;
    }
  }
  piece(from, c.end);
  corridors_.push_back(c);
}

/// Doors and rooms on one side of a corridor.
void Office::add_rooms(std::size_t index, double side) {
  const Corridor& c = corridors_[index];
  RandomStream random(seed_, purpose::kLayout, 1000 + 2 * index + (side > 0 ? 1 : 0));
  for (double s = c.begin + random.uniform(0, 1); s < c.end - 1.5;) {
    const double width = random.uniform(2.8, 5.5);
    const bool placed = add_room(c, side, s, s + width, random);
    s += placed ? width + kWall + random.uniform(0, 0.8) : 0.7;
  }
}

bool Office::add_room(const Corridor& corridor, double side, double begin, double end, RandomStream& random) {
  const Run& run = corridor.run;
  const double face = side * corridor.half, depth = random.uniform(3, 5.5),
               door_at = random.uniform(begin + 0.7, end - 0.7);
  const double kind = random.uniform(), leaf = random.uniform(), swing = random.uniform(1.3, 1.9);
  const auto beyond = [&](double s0, double s1, double d0, double d1) {
    return run.rect(s0, s1, std::min(face + side * d0, face + side * d1), std::max(face + side * d0, face + side * d1));
  };
  Door door;
  door.at = run.point(door_at, face);
  door.normal = run.axis == 0 ? Vec2(0, -side) : Vec2(-side, 0);
  door.open = kind < params_.room_density * params_.open_doors;
  door.swing = swing;
  door.hinge_left = leaf < 0.5;
  // The corridor itself must be there, up to the door: the start of a run may lie within another one.
  if (!plan_.meets(beyond(door_at - 0.5, door_at + 0.5, -0.1, 0))) return false;
  if (!door.open) {
    if (door_at > corridor.end - 0.6 || plan_.meets(beyond(door_at - 0.6, door_at + 0.6, 0.001, 0.2))) return false;
    if (kind >= params_.room_density) return true;  // plain wall
  } else {
    const Rect room = beyond(begin, end, kWall, kWall + depth);
    if (door_at > corridor.end - 0.6 || plan_.meets(room.grown(0.14)) ||
        plan_.meets(beyond(door_at - 0.6, door_at + 0.6, 0.001, kWall)))
      return false;
    plan_.add({room, 0, params_.height});
    rooms_.push_back({room, 5000 + rooms_.size()});
  }
  doors_.push_back(door);
  add_door(plan_, door);
  return true;
}

World Office::build() const {
  const PlanGrid grid(plan_);
  MeshBuilder builder;
  grid.build(builder, {});
  Site site(grid, clear_zones(route_, 0.36));
  for (const Door& door : route_doors_) build_door(builder, site, door);
  for (const Rect& zone : clear_zones(route_, 0.62)) site.reserve(zone);
  for (const Door& door : doors_) {
    if (!door.open) site.reserve(door.area().grown(0.1));
    build_door(builder, site, door);
    if (door.open) site.reserve(door.area().grown(0.6));
  }
  build_windows(builder, windows_, params_.height);
  for (std::size_t k = 0; k < given_.size(); ++k) {
    RandomStream random(seed_, purpose::kLayout, 4000 + k);
    if (params_.rooms[k].furnished) furnish(builder, site, random, given_[k]);
    hang_lamps(builder, grid, given_[k], params_.height);
  }
  for (const Room& room : rooms_) {
    RandomStream random(seed_, purpose::kLayout, room.part);
    furnish(builder, site, random, room.area);
    hang_lamps(builder, grid, room.area, params_.height);
  }
  dress_walls(builder, site, seed_, params_.clutter);
  for (std::size_t k = 0; k < corridors_.size(); ++k) {
    RandomStream random(seed_, purpose::kLayout, 3000 + k);
    Run run = corridors_[k].run;
    run.lo = corridors_[k].begin;
    run.hi = corridors_[k].end;
    dress_ceiling(builder, grid, random, run, corridors_[k].half, params_.height);
  }
  return {builder.take(), Ground{}};
}

}  // namespace

void OfficeRoom::describe(config::Binder& b, OfficeRoom& room) {
  const config::Range range{.min = -2000.0, .max = 2000.0};
  b.real("low_x", room.low_x, "m", range, "corner of the room");
  b.real("low_y", room.low_y, "m", range, "corner of the room");
  b.real("high_x", room.high_x, "m", range, "opposite corner");
  b.real("high_y", room.high_y, "m", range, "opposite corner");
  b.flag("furnished", room.furnished, "desks, chairs, cupboards, shelves, plants");
  b.require(room.high_x > room.low_x, "high_x", "must exceed low_x");
  b.require(room.high_y > room.low_y, "high_y", "must exceed low_y");
}

void OfficeParams::describe(config::Binder& b, OfficeParams& params) {
  b.integer("seed", params.seed, "1", {.min = 0.0}, "of the layout and the clutter");
  b.real("corridor_width", params.corridor_width, "m", {.min = 1.6, .max = 6.0},
         "of the corridors along the route; each differs by up to 0.15 m");
  b.real("height", params.height, "m", {.min = 2.4, .max = 6.0}, "of the ceiling");
  b.real("room_density", params.room_density, "1", {.min = 0.0, .max = 1.0},
         "share of the places beside the corridors that have a door");
  b.real("open_doors", params.open_doors, "1", {.min = 0.0, .max = 1.0}, "share of the doors that are open");
  b.real("clutter", params.clutter, "1", {.min = 0.0, .max = 3.0}, "things on the walls: 0 none, 1 usual");
  b.groups("rooms", params.rooms, "rooms by their corners; the route enters and leaves them by doors");
}

World build_office(const OfficeParams& params, const Route& route, double scale) {
  return Office(params, route, scale).build();
}

std::vector<Vec2> office_doors(const OfficeParams& params, const Route& route, double scale) {
  const Office office(params, route, scale);
  std::vector<Vec2> places;
  for (const Door& door : office.route_doors()) places.push_back(door.area().centre());
  return places;
}

}  // namespace aslio::simulator
