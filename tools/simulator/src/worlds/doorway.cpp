#include "aslio/simulator/worlds/doorway.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "aslio/config/binder.hpp"
#include "purposes.hpp"
#include "worlds/floor_plan.hpp"
#include "worlds/furniture.hpp"
#include "worlds/stairs.hpp"

namespace aslio::simulator {
namespace {

using namespace indoor;

constexpr double kFromCorner = 1.6;  // least distance of a door from a corner [m]
constexpr double kBeside = 1.1;      // least distance of walls along the route [m]
constexpr double kStep = 0.25;       // by which rooms grow [m]

/// A door on the route and what the walk does there.
struct Passage {
  double s = 0;  ///< along the route [m]
  Vec2 at = Vec2::Zero(), direction = Vec2::UnitX();
  double width = 0.95;
};

/// Sides in the order -x, -y, +x, +y.
struct Room {
  Rect area;
  std::array<bool, 4> fixed{};  ///< a side with a door of the route in it stays where it is
};

Rect with_side(Rect area, int side, double by) {
  (side < 2 ? area.low[side] : area.high[side - 2]) += side < 2 ? -by : by;
  return area;
}

/// The rooms while they are drawn up: a wall with a door every few metres across the route, a room between two doors.
class Doorways {
 public:
  Doorways(const DoorwayParams& params, const Route& route)
      : params_(params), seed_(static_cast<std::uint64_t>(params.seed)), route_(route) {
    static_cast<void>(runs_of(route, "doorway"));  // every edge must be parallel to an axis
    find_passages();
    find_rooms();
    grow_rooms();
    std::vector<Rect> areas;
    for (const Room& room : rooms_) {
      plan_.add({room.area, 0, params.height});
      areas.push_back(room.area);
    }
    for (const Passage& p : passages_) {
      Door door;
      door.at = p.at - 0.5 * kWall * p.direction;
      door.normal = -p.direction;
      door.width = p.width;
      door.swing = 2.7;
      door.hinge_left = RandomStream(seed_, purpose::kLayout, 300 + doors_.size()).uniform() < 0.5;
      doors_.push_back(door);
      add_door(plan_, door);
    }
    for (int k = 0; k < static_cast<int>(params.stairwells); ++k) add_stairwell();
    panes_ = add_windows(plan_, areas, params.height);
  }

  const std::vector<Passage>& passages() const { return passages_; }
  World build() const;

 private:
  void find_passages();
  void find_rooms();
  void grow_rooms();
  void add_stairwell();
  bool free_for(const Rect& area, std::size_t room) const;

  DoorwayParams params_;
  std::uint64_t seed_;
  const Route& route_;
  FloorPlan plan_;
  std::vector<Passage> passages_;
  std::vector<Room> rooms_;
  std::vector<Door> doors_;
  std::vector<Stairwell> stairwells_;
  std::vector<Rect> panes_;
};

/// Spread over each edge that is long enough, away from its ends.
void Doorways::find_passages() {
  RandomStream random(seed_, purpose::kLayout, 0);
  const std::vector<Vec2>& points = route_.points();
  double start = 0;
  for (std::size_t k = 0; k < points.size(); ++k) {
    const double length = (points[(k + 1) % points.size()] - points[k]).norm();
    const double free = length - 2 * kFromCorner;
    const int count = free < 0 ? 0 : std::max(1, static_cast<int>(std::lround(length / params_.room_length)));
    for (int j = 0; j < count; ++j) {
      // Each within the first two thirds of its share: neighbours are at least a third of a share apart.
      const double s = start + kFromCorner + free * (j + random.uniform(0.17, 0.83)) / count;
      const Route::Place place = route_.at(s);
      passages_.push_back({s, place.at, place.direction, random.uniform(params_.door_min, params_.door_max)});
    }
    start += length;
  }
}

/// The smallest rooms that hold the route from each door to the next.
void Doorways::find_rooms() {
  const std::vector<Vec2>& points = route_.points();
  const double round = route_.length();
  const auto around = [](const std::vector<Vec2>& some) {
    Rect area{some.front(), some.front()};
    for (const Vec2& p : some) area = {area.low.cwiseMin(p), area.high.cwiseMax(p)};
    return area;
  };
  if (passages_.size() < 2) {
    passages_.clear();
    rooms_.push_back({around(points).grown(kBeside), {}});
    return;
  }
  for (std::size_t k = 0; k < passages_.size(); ++k) {
    const Passage &from = passages_[k], &to = passages_[(k + 1) % passages_.size()];
    const double end = to.s > from.s ? to.s : to.s + round;
    std::vector<Vec2> inside{from.at, to.at};
    double s = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
      for (const double at : {s, s + round})
        if (at > from.s && at < end) inside.push_back(points[i]);
      s += (points[(i + 1) % points.size()] - points[i]).norm();
    }
    const Rect line = around(inside);
    Room room{line.grown(kBeside), {}};
    for (const auto& [place, inward] : {std::pair(from.at, from.direction), std::pair(to.at, Vec2(-to.direction))}) {
      const int axis = std::abs(inward.x()) > 0.5 ? 0 : 1;
      const bool low = inward[axis] > 0;
      const double edge = low ? line.low[axis] : line.high[axis];
      if (std::abs(place[axis] - edge) > 1e-9) continue;  // the route goes on beside this door, in the same room
      (low ? room.area.low : room.area.high)[axis] = place[axis] + 0.5 * kWall * inward[axis];
      room.fixed.at(static_cast<std::size_t>(low ? axis : axis + 2)) = true;
    }
    rooms_.push_back(room);
  }
}

bool Doorways::free_for(const Rect& area, std::size_t room) const {
  for (std::size_t k = 0; k < rooms_.size(); ++k)
    if (k != room && rooms_[k].area.overlaps(area)) return false;
  return true;
}

/// Each side in turn by a random length, as far as a wall remains between two rooms.
void Doorways::grow_rooms() {
  for (std::size_t k = 0; k < rooms_.size(); ++k) {
    RandomStream random(seed_, purpose::kLayout, 100 + k);
    Room& room = rooms_[k];
    for (int side = 0; side < 4; ++side) {
      const double most = random.uniform(0, 3);
      if (room.fixed.at(static_cast<std::size_t>(side))) continue;
      for (double by = kStep; by <= most; by += kStep) {
        const Rect larger = with_side(room.area, side, kStep);
        // A wall of at least kWall on the side that moves; those at the doors are as thick as the doors.
        if (!free_for(with_side(larger, side, kWall), k)) break;
        room.area = larger;
      }
    }
  }
}

/// Behind the first wall that has room for one, the largest rooms first.
void Doorways::add_stairwell() {
  std::vector<std::size_t> order(rooms_.size());
  for (std::size_t k = 0; k < order.size(); ++k) order[k] = k;
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return rooms_[a].area.size().prod() > rooms_[b].area.size().prod();
  });
  for (const std::size_t k : order) {
    const Rect& room = rooms_[k].area;
    for (int side = 0; side < 4; ++side) {
      const int axis = side % 2;
      if (rooms_[k].fixed.at(static_cast<std::size_t>(side)) || room.size()[1 - axis] < Stairwell::kWidth) continue;
      Vec2 at = room.centre(), normal = Vec2::Zero();  // into the stairwell
      at[axis] = side < 2 ? room.low[axis] : room.high[axis];
      normal[axis] = side < 2 ? -1 : 1;
      const Stairwell stairs(at, normal);
      if (plan_.meets(stairs.area().grown(kWall - 0.01))) continue;
      stairs.add_to(plan_, params_.height);
      stairwells_.push_back(stairs);
      return;
    }
  }
}

World Doorways::build() const {
  const PlanGrid grid(plan_);
  MeshBuilder builder;
  grid.build(builder, {});
  Site site(grid, clear_zones(route_, 0.36));
  for (const Door& door : doors_) build_door(builder, site, door);
  for (const Rect& zone : clear_zones(route_, 0.62)) site.reserve(zone);
  build_windows(builder, panes_, params_.height);
  for (const Stairwell& stairs : stairwells_) build_stairs(builder, site, stairs);
  for (std::size_t k = 0; k < rooms_.size(); ++k) {
    RandomStream random(seed_, purpose::kLayout, 200 + k);
    furnish(builder, site, random, rooms_[k].area);
    hang_lamps(builder, grid, rooms_[k].area, params_.height);
  }
  dress_walls(builder, site, seed_, params_.clutter);
  return {builder.take(), Ground{}};
}

}  // namespace

void DoorwayParams::describe(config::Binder& b, DoorwayParams& params) {
  b.integer("seed", params.seed, "1", {.min = 0.0}, "of the layout and the clutter");
  b.real("room_length", params.room_length, "m", {.min = 3.0, .max = 50.0},
         "between two doors on a straight part of the route, about");
  b.real("door_min", params.door_min, "m", {.min = 0.85, .max = 3.0}, "least width of the doorways; drawn for each");
  b.real("door_max", params.door_max, "m", {.min = 0.85, .max = 3.0}, "largest width of the doorways");
  b.real("height", params.height, "m", {.min = 2.4, .max = 3.1}, "of the rooms' ceilings");
  b.integer("stairwells", params.stairwells, "1", {.min = 0.0, .max = 10.0},
            "beside the rooms, as many of them as there is room for");
  b.real("clutter", params.clutter, "1", {.min = 0.0, .max = 3.0}, "things on the walls: 0 none, 1 usual");
  b.require(params.door_max >= params.door_min, "door_max", "must be at least door_min");
}

World build_doorway(const DoorwayParams& params, const Route& route, double) { return Doorways(params, route).build(); }

std::vector<Vec2> doorway_doors(const DoorwayParams& params, const Route& route) {
  const Doorways doorways(params, route);
  std::vector<Vec2> places;
  for (const Passage& p : doorways.passages()) places.push_back(p.at);
  return places;
}

}  // namespace aslio::simulator
