#include "aslio/simulator/worlds/campus.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>

#include "aslio/config/binder.hpp"
#include "purposes.hpp"
#include "worlds/building.hpp"
#include "worlds/greenery.hpp"
#include "worlds/street_furniture.hpp"
#include "worlds/vehicles.hpp"

namespace aslio::simulator {
namespace {

using namespace outdoor;
namespace m = material;

constexpr double kPi = std::numbers::pi;
constexpr double kBeyond = 60;     ///< from the route to the end of the terrain [m]
constexpr double kTerrain = 1;     ///< step of the terrain [m]
constexpr double kKerb = 0.12;     ///< height of the pavements above the street [m]
constexpr double kPavement = 2;    ///< width of the pavements [m]
constexpr double kPiece = 2;       ///< of pavements [m]
constexpr double kPaintZ = 0.004;  ///< height of lines above the street [m]
constexpr double kKeep = 1;        ///< from the route to parked cars [m]; a walk cuts corners

/// One edge of the route: x along it from its first point, y to its left.
struct Street {
  Vec2 from = Vec2::Zero(), along = Vec2::UnitX();
  double length = 0, yaw = 0;
  std::uint64_t part = 0;  ///< of its random streams

  Vec2 at(double x, double y) const { return from + x * along + y * Vec2(-along.y(), along.x()); }
};

class Campus {
 public:
  Campus(const CampusParams& params, const Route& route, double scale)
      : params_(params),
        route_(route),
        seed_(static_cast<std::uint64_t>(params.seed)),
        plot_(route),
        half_(0.5 * params.street) {
    const std::vector<Vec2>& points = route.points();
    for (std::size_t k = 0; k < points.size(); ++k) {
      const Vec2 line = points[(k + 1) % points.size()] - points[k];
      streets_.push_back({points[k], line.normalized(), line.norm(), std::atan2(line.y(), line.x()), 100 * (k + 1)});
    }
    draw_ground();
    keep_bare(scale);
  }
  World build();

 private:
  enum Part : std::uint64_t {
    kGround = 1,
    kPark = 2,
    kHouses = 10,
    kCars = 20,
    kPosts = 30,
    kThings = 40,
    kFronts = 50,
    kTrees = 60
  };
  RandomStream stream(std::uint64_t part) const { return {seed_, purpose::kLayout, part}; }
  /// In turn for each street and each of its sides (1: left).
  void along_streets(Part part, const std::function<void(const Street&, double, RandomStream&)>& place);
  double height(const Vec2& p) const { return ground_.height(p.x(), p.y()); }
  /// On the ground, x along the street; on the left side turned so that y always points to the street.
  Placement beside(const Street& street, double x, double y, double turn = 0) const;
  /// Builds in the placement when the plot is free there, off the streets.
  bool put(const Placement& placement, const Vec2& low, const Vec2& high, const std::function<void()>& add);
  void draw_ground();
  void keep_bare(double scale);
  void add_terrain();
  void add_street(const Street& street);
  void add_pavement(const Street& street, double x, double side);
  void add_houses(const Street& street, double side, RandomStream& random);
  bool add_house(const Street& street, double side, double x, double width, RandomStream& random);
  void add_cars(const Street& street, double side, RandomStream& random);
  void add_posts(const Street& street, double side, RandomStream& random);
  void add_things(const Street& street, double side, RandomStream& random);
  void add_fronts(const Street& street, double side, RandomStream& random);
  void add_trees(const Street& street, double side, RandomStream& random);
  void add_park();

  const CampusParams& params_;
  const Route& route_;
  std::uint64_t seed_;
  Plot plot_;
  double half_;  ///< of the street [m]
  Ground ground_;
  std::vector<Street> streets_;
  MeshBuilder builder_;
  std::vector<std::uint8_t> terrain_;  ///< reflectivities of the first triangles
};

/// Three long waves, so that no slope is steeper than about a tenth of the relief.
void Campus::draw_ground() {
  RandomStream random = stream(kGround);
  const std::array<Vec2, 3> waves = {Vec2(0.5, 110), Vec2(0.3, 70), Vec2(0.2, 43)};
  for (const Vec2& wave : waves) {
    const double k = 2 * kPi / wave.y(), heading = random.uniform(0, 2 * kPi);
    ground_.waves.push_back(
        {0.5 * params_.relief * wave.x(), k * std::cos(heading), k * std::sin(heading), random.uniform(0, 2 * kPi)});
  }
}

void Campus::keep_bare(double scale) {
  const double length = scale * params_.bare_length, begin = params_.bare_begin * route_.length();
  constexpr double kStep = 1;  // [m]
  for (double s = 0; s < length; s += kStep) {
    const double step = std::min(kStep, length - s);
    const Route::Place place = route_.at(begin + s + 0.5 * step);
    plot_.reserve(
        {place.at, Vec2(0.5 * step, params_.bare_width), std::atan2(place.direction.y(), place.direction.x())});
  }
}

void Campus::along_streets(Part part, const std::function<void(const Street&, double, RandomStream&)>& place) {
  for (const Street& street : streets_) {
    for (const double side : {1.0, -1.0}) {
      RandomStream random = stream(street.part + part + (side > 0 ? 1 : 0));
      place(street, side, random);
    }
  }
}

Placement Campus::beside(const Street& street, double x, double y, double turn) const {
  const Vec2 p = street.at(x, y);
  return {Vec3(p.x(), p.y(), height(p)), street.yaw + (y > 0 ? kPi : 0) + turn};
}

bool Campus::put(const Placement& placement, const Vec2& low, const Vec2& high, const std::function<void()>& add) {
  if (!plot_.claim(footprint(placement, low, high), half_)) return false;
  const auto placed = builder_.place(placement);
  add();
  return true;
}

/// Asphalt between the kerbs and a bit under the pavements, grass elsewhere.
void Campus::add_terrain() {
  builder_.terrain(route_.low().array() - kBeyond, route_.high().array() + kBeyond, kTerrain, m::kGrass,
                   [&](double x, double y) { return ground_.height(x, y); });
  for (const Mesh::Triangle& t : builder_.mesh().triangles) {
    const std::vector<Eigen::Vector3f>& v = builder_.mesh().vertices;
    const Vec2 centre = ((v[t.a] + v[t.b] + v[t.c]) / 3).head<2>().cast<double>();
    terrain_.push_back(route_.distance(centre) < half_ + kTerrain ? m::kAsphalt : m::kGrass);
  }
}

/// A step of kKerb up from the street, unless another street is there.
void Campus::add_pavement(const Street& street, double x, double side) {
  const double inner = side * half_, outer = side * (half_ + kPavement);
  const std::array<Vec2, 4> corners = {street.at(x, inner), street.at(x + kPiece, inner), street.at(x + kPiece, outer),
                                       street.at(x, outer)};
  for (const Vec2& p : corners)
    if (route_.distance(p) < half_ - 1e-6) return;
  const auto at = [&](std::size_t k, double up) {
    const Vec2& p = corners.at(k % 4);
    return Vec3(p.x(), p.y(), height(p) + up);
  };
  const auto stone = [&](std::size_t k, std::uint8_t reflectivity) {
    builder_.quad(at(k, -0.1), at(k + 1, -0.1), at(k + 1, kKerb), at(k, kKerb), reflectivity);
  };
  builder_.quad(at(0, kKerb), at(1, kKerb), at(2, kKerb), at(3, kKerb), 85);
  stone(0, 150);
  for (std::size_t k = 1; k < 4; ++k) stone(k, m::kConcrete);
}

void Campus::add_street(const Street& street) {
  const double beyond = kPiece * std::ceil((half_ + kPavement) / kPiece);
  for (double x = -beyond; x < street.length + beyond; x += kPiece)
    for (const double side : {1.0, -1.0}) add_pavement(street, x, side);
  const auto dash = [&](double x0, double x1, double y) {
    const auto at = [&](double x, double across) {
      const Vec2 p = street.at(x, across);
      return Vec3(p.x(), p.y(), height(p) + kPaintZ);
    };
    builder_.quad(at(x0, y - 0.06), at(x1, y - 0.06), at(x1, y + 0.06), at(x0, y + 0.06), m::kWhitePaint);
  };
  for (double x = half_ + 1; x + 1.5 < street.length - half_; x += 4) dash(x, x + 1.5, 0);
}

void Campus::add_houses(const Street& street, double side, RandomStream& random) {
  for (double x = -25 + random.uniform(0, 8); x < street.length + 15;) {
    const double width = random.uniform(12, 30);
    if (random.uniform() >= params_.buildings) {
      x += random.uniform(8, 16);
    } else if (add_house(street, side, x, width, random) || add_house(street, side, x, 0.55 * width, random)) {
      x += width + random.uniform(3, 11);
    } else {
      x += 3;
    }
  }
}

bool Campus::add_house(const Street& street, double side, double x, double width, RandomStream& random) {
  const double setback = random.uniform(params_.setback_min, params_.setback_max), depth = random.uniform(8, 15);
  const Building building = draw_building(random, width, depth);
  const double front = half_ + kPavement + setback + 1.1;
  Placement placement = beside(street, x + 0.5 * width, side * (front + 0.5 * depth));
  const Footprint area = footprint(building, placement);
  if (distance(route_, area) < half_ + kPavement + 0.5 * setback || !plot_.claim(area, half_)) return false;
  double lowest = placement.origin.z();
  for (const Vec2& corner : area.corners()) lowest = std::min(lowest, height(corner));
  placement.origin.z() = lowest + 0.15;
  const auto placed = builder_.place(placement);
  add_building(builder_, random, building);
  return true;
}

void Campus::add_cars(const Street& street, double side, RandomStream& random) {
  for (double x = half_ + kPavement + 2; x < street.length - half_ - kPavement - 2; x += random.uniform(5.4, 6.2)) {
    const double taken = random.uniform(), about = random.uniform(), skew = random.uniform(-0.03, 0.03);
    const Vehicle vehicle = draw_vehicle(random);
    if (taken >= params_.parked) continue;
    const double y = half_ - 0.5 * vehicle.width - random.uniform(0.22, 0.4);
    const Placement placement = beside(street, x, side * y, skew + (about < 0.2 ? kPi : 0));
    if (!plot_.claim(footprint(vehicle, placement), kKeep)) continue;
    const auto placed = builder_.place(placement);
    add_vehicle(builder_, vehicle);
  }
}

/// Lamps opposite each other in turn, signs and bollards at the kerb.
void Campus::add_posts(const Street& street, double side, RandomStream& random) {
  if (params_.furniture <= 0) return;
  const double y = side * (half_ + 0.45);
  for (double x = half_ + (side > 0 ? 3 : 14); x < street.length; x += 22) {
    put(beside(street, x, y), {-0.2, -0.2}, {0.2, 0.2}, [&] { add_lamp_post(builder_, 5.5); });
  }
  for (double x = half_ + random.uniform(2, 8); x < street.length; x += random.uniform(9, 26) / params_.furniture) {
    const double kind = random.uniform(), width = random.uniform(0.4, 0.7), turn = random.uniform() < 0.5 ? 1 : -1;
    if (kind < 0.5) {
      put(beside(street, x, y, 0.5 * kPi * turn), {-0.4, -0.1}, {0.4, 0.1}, [&] { add_sign(builder_, width); });
    } else {
      for (int k = 0; k < 4; ++k)
        put(beside(street, x + 1.4 * k, y), {-0.1, -0.1}, {0.1, 0.1}, [&] { add_bollard(builder_); });
    }
  }
}

/// On the far half of the pavements.
void Campus::add_things(const Street& street, double side, RandomStream& random) {
  if (params_.furniture <= 0) return;
  const double y = side * (half_ + kPavement - 0.35), back = side * (half_ + kPavement + 0.9);
  for (double x = random.uniform(2, 9); x < street.length; x += random.uniform(5, 15) / params_.furniture) {
    const double kind = random.uniform();
    if (kind < 0.3) {
      put(beside(street, x, y), {-0.9, -0.3}, {0.9, 0.3}, [&] { add_bench(builder_); });
      put(beside(street, x + 1.6, y), {-0.3, -0.3}, {0.3, 0.3}, [&] { add_bin(builder_); });
    } else if (kind < 0.5) {
      put(beside(street, x, y), {-0.3, -0.3}, {0.3, 0.3}, [&] { add_bin(builder_); });
    } else if (kind < 0.72) {
      put(beside(street, x, y), {-0.6, -0.25}, {0.6, 0.25}, [&] { add_cabinet(builder_, random); });
    } else if (kind < 0.9) {
      put(beside(street, x, back, 0.5 * kPi), {-1, -1.5}, {1, 1.5}, [&] { add_bicycle_rack(builder_, random); });
    } else {
      put(beside(street, x, back), {-2, -0.8}, {2, 0.85}, [&] { add_shelter(builder_); });
    }
  }
}

/// Hedges, fences and low walls before the houses.
void Campus::add_fronts(const Street& street, double side, RandomStream& random) {
  if (params_.furniture <= 0) return;
  const double y = side * (half_ + kPavement + 0.5);
  for (double x = half_ + kPavement; x < street.length - half_ - kPavement;) {
    const double length = random.uniform(3, 9), kind = random.uniform(), tall = random.uniform();
    if (kind < 0.6 * std::min(params_.furniture, 1.6)) {
      // Pieces, so that they follow the ground.
      for (double from = 0; from < length - 1; from += 3) {
        const double piece = std::min(3.0, length - from);
        // On the left the frame is turned: it begins at the far end.
        const double begin = side > 0 ? x + from + piece : x + from;
        put(beside(street, begin, y), {0, -0.45}, {piece, 0.45}, [&] {
          if (kind < 0.3)
            add_hedge(builder_, random, piece, 0.8, 0.8 + 0.9 * tall);
          else if (kind < 0.45)
            add_fence(builder_, piece, 0.9 + 0.5 * tall);
          else
            add_low_wall(builder_, piece, 0.5 + 0.5 * tall);
        });
      }
    }
    x += length + random.uniform(0.5, 5);
  }
}

void Campus::add_trees(const Street& street, double side, RandomStream& random) {
  if (params_.trees <= 0) return;
  for (double x = random.uniform(-10, 4); x < street.length + 10; x += random.uniform(5, 11) / params_.trees) {
    const double tall = random.uniform(5, 10), y = side * (half_ + kPavement + random.uniform(-1.2, 1.6));
    put(beside(street, x, y), {-0.5, -0.5}, {0.5, 0.5}, [&] { add_tree(builder_, random, tall); });
  }
}

/// Trees, bushes, sheds and cabinets on the open ground, inside the round and about it.
void Campus::add_park() {
  RandomStream random = stream(kPark);
  const Vec2 low = route_.low().array() - 28, high = route_.high().array() + 28;
  const int attempts = static_cast<int>((high - low).prod() / 45);
  for (int k = 0; k < attempts; ++k) {
    // In braces: every compiler draws from left to right.
    const Vec2 at{random.uniform(low.x(), high.x()), random.uniform(low.y(), high.y())};
    const double kind = random.uniform(), size = random.uniform(), yaw = random.uniform(0, kPi),
                 keep = random.uniform();
    const Placement placement{Vec3(at.x(), at.y(), height(at)), yaw};
    if (route_.distance(at) < half_ + kPavement + 1.5) continue;
    if (kind < 0.55) {
      if (keep < params_.trees)
        put(placement, {-0.8, -0.8}, {0.8, 0.8}, [&] { add_tree(builder_, random, 5 + 7 * size); });
    } else if (kind < 0.9) {
      const double r = 0.5 + 0.7 * size;
      if (keep < params_.trees) put(placement, {-r, -r}, {r, r}, [&] { add_bush(builder_, random, r, 1.3 * r); });
    } else if (kind < 0.94) {
      const double w = 1.2 + 1.5 * size;
      put(placement, {-w - 0.3, -1.6}, {w + 0.3, 1.6}, [&] {
        builder_.box({-w, -1.3, -0.8}, {w, 1.3, 2.3}, m::kWood);
        builder_.box({-w - 0.25, -1.55, 2.3}, {w + 0.25, 1.55, 2.42}, m::kAsphalt);
        builder_.box({-0.5, 1.3, 0}, {0.5, 1.34, 2}, m::kMetal);
      });
    } else if (keep < params_.furniture) {
      put(placement, {-0.9, -0.3}, {0.9, 0.3}, [&] { add_bench(builder_); });
    }
  }
}

World Campus::build() {
  add_terrain();
  for (const Street& street : streets_) add_street(street);
  using Add = void (Campus::*)(const Street&, double, RandomStream&);
  const auto each = [&](Part part, Add add) {
    along_streets(part,
                  [&](const Street& street, double side, RandomStream& random) { (this->*add)(street, side, random); });
  };
  each(kHouses, &Campus::add_houses);
  each(kCars, &Campus::add_cars);
  each(kPosts, &Campus::add_posts);
  each(kThings, &Campus::add_things);
  each(kFronts, &Campus::add_fronts);
  each(kTrees, &Campus::add_trees);
  add_park();
  Mesh mesh = builder_.take();
  std::copy(terrain_.begin(), terrain_.end(), mesh.reflectivity.begin());
  return {std::move(mesh), ground_};
}

}  // namespace

void CampusParams::describe(config::Binder& b, CampusParams& params) {
  b.integer("seed", params.seed, "1", {.min = 0.0}, "of the layout and the clutter");
  b.real("relief", params.relief, "m", {.min = 0.0, .max = 3.0}, "the ground rises and falls by up to this");
  b.real("street", params.street, "m", {.min = 6.0, .max = 20.0}, "width between the kerbs; the route is its middle");
  b.real("setback_min", params.setback_min, "m", {.min = 0.0, .max = 50.0},
         "from the pavements to the buildings, least");
  b.real("setback_max", params.setback_max, "m", {.min = 0.0, .max = 50.0},
         "from the pavements to the buildings, most");
  b.real("buildings", params.buildings, "1", {.min = 0.0, .max = 1.0},
         "share of the fronts along the streets with a building");
  b.real("trees", params.trees, "1", {.min = 0.0, .max = 2.0}, "trees and bushes: 0 none, 1 usual");
  b.real("parked", params.parked, "1", {.min = 0.0, .max = 1.0}, "share of the places at the kerbs with a vehicle");
  b.real("furniture", params.furniture, "1", {.min = 0.0, .max = 2.0},
         "lamps, benches, signs, hedges, fences: 0 none, 1 usual");
  b.real("bare_begin", params.bare_begin, "1", {.min = 0.0, .max = 1.0},
         "where the stretch without features begins, share of the round");
  b.real("bare_length", params.bare_length, "m", {.min = 0.0, .max = 500.0},
         "of the stretch without features, scales with the route; 0: there is none");
  b.real("bare_width", params.bare_width, "m", {.min = 5.0, .max = 100.0},
         "nothing stands within this on either side of that stretch");
  b.require(params.setback_min <= params.setback_max, "setback_min", "must not be above setback_max");
}

World build_campus(const CampusParams& params, const Route& route, double scale) {
  return Campus(params, route, scale).build();
}

}  // namespace aslio::simulator
