#include "aslio/simulator/worlds/forest.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "aslio/config/binder.hpp"
#include "aslio/simulator/random.hpp"
#include "purposes.hpp"
#include "worlds/curved.hpp"
#include "worlds/plot.hpp"
#include "worlds/wood.hpp"

namespace aslio::simulator {
namespace {

using namespace outdoor;
namespace m = material;

constexpr double kTurn = 2 * std::numbers::pi;
constexpr double kBeyond = 24;      // of the wood about the route [m]
constexpr double kTerrain = 0.55;   // its grid [m]
constexpr double kTrodden = 0.008;  // roughness of the path [m]
constexpr double kKeep = 0.75;      // of all that grows from the route, besides the width of the path [m]
constexpr double kNear = 12;        // trunks nearer than this to the route keep the chord error [m]
constexpr int kFarSides = 24;
enum Part : std::uint64_t { kGround = 1, kRough, kTrees, kBushes, kFerns, kRocks, kLogs, kRoots };

class Forest {
 public:
  Forest(const ForestParams& params, const Route& route)
      : params_(params),
        route_(route),
        seed_(static_cast<std::uint64_t>(params.seed)),
        plot_(route),
        keep_(std::max(kKeep, 0.5 * params.path)) {
    RandomStream random = stream(kGround);
    for (const Vec2& wave : {Vec2(0.55, 83), Vec2(0.3, 41), Vec2(0.15, 19)}) {
      const double k = kTurn / wave.y(), heading = random.uniform(0, kTurn);
      ground_.waves.push_back(
          {0.5 * params.relief * wave.x(), k * std::cos(heading), k * std::sin(heading), random.uniform(0, kTurn)});
    }
  }

  World build() {
    add_terrain();
    add_trees();
    add_rocks();
    add_logs();
    add_bushes();
    add_ferns();
    add_roots_on_path();
    return {builder_.take(), ground_};
  }

 private:
  RandomStream stream(std::uint64_t part) const { return {seed_, purpose::kLayout, part}; }
  double height(const Vec2& p) const { return ground_.height(p.x(), p.y()); }
  Vec2 low() const { return route_.low().array() - kBeyond; }
  Vec2 high() const { return route_.high().array() + kBeyond; }
  int count(double per_square) const { return static_cast<int>((high() - low()).prod() * per_square); }
  Vec2 anywhere(RandomStream& random) const {
    // In braces: every compiler draws from left to right.
    return Vec2{random.uniform(low().x(), high().x()), random.uniform(low().y(), high().y())};
  }
  /// Room for a round thing there, off the path and not in another.
  bool claim(const Vec2& at, double radius) {
    if (route_.distance(at) < keep_ + radius) return false;
    const double half = radius * std::sqrt(0.5);
    return plot_.claim({at, Vec2(half, half), 0}, 0);
  }
  Placement on_ground(const Vec2& p, double yaw) const { return {Vec3(p.x(), p.y(), height(p)), yaw}; }
  void add_terrain();
  void add_trees();
  void add_roots(const Vec2& foot, const Tree& tree, RandomStream& random);
  void add_rocks();
  void add_logs();
  void add_bushes();
  void add_ferns();
  void add_roots_on_path();

  const ForestParams& params_;
  const Route& route_;
  std::uint64_t seed_;
  Plot plot_;
  double keep_;  ///< from the route to what grows [m]
  Ground ground_;
  MeshBuilder builder_;
};

/// Trodden on the path, rough a step beside it.
void Forest::add_terrain() {
  RandomStream random = stream(kRough);
  builder_.terrain(low(), high(), kTerrain, m::kGrass, [&](double x, double y) {
    const double beside = std::clamp((route_.distance({x, y}) - 0.5 * params_.path - 0.3) / 1.5, 0.0, 1.0);
    const double rough = std::min(kTrodden, params_.roughness) * (1 - beside) + params_.roughness * beside;
    return ground_.height(x, y) + rough * random.uniform(-1, 1);
  });
}

/// Half in the earth, away from the trunk.
void Forest::add_roots(const Vec2& foot, const Tree& tree, RandomStream& random) {
  const double turn = random.uniform(0, kTurn);
  for (int k = 0; k < 4; ++k) {
    const double angle = turn + kTurn * (k + random.uniform(-0.25, 0.25)) / 4, thick = 0.3 * tree.radius;
    const double reach = tree.foot() + random.uniform(0.4, 1.1), bend = random.uniform(-0.5, 0.5);
    const auto at = [&](double share, double up) {
      const double a = angle + bend * share, r = 0.8 * tree.radius + share * (reach - 0.8 * tree.radius);
      const Vec2 p = foot + r * Vec2(std::cos(a), std::sin(a));
      return Vec3(p.x(), p.y(), height(p) + up);
    };
    const std::array<curved::Ring, 4> rings{curved::Ring{at(0, 0.08), 1.3 * thick}, curved::Ring{at(0.3, 0.02), thick},
                                            curved::Ring{at(0.65, 0), 0.7 * thick},
                                            curved::Ring{at(1, -0.05), 0.4 * thick}};
    curved::add_bar(builder_, rings, 8, m::kWood);
  }
}

void Forest::add_trees() {
  RandomStream random = stream(kTrees);
  const int attempts = count(0.01 * params_.trees);
  for (int k = 0; k < attempts; ++k) {
    const Vec2 at = anywhere(random);
    RandomStream own(seed_, purpose::kLayout, 1000 + static_cast<std::uint64_t>(k));
    Tree tree = draw_tree(own, params_.lean * kTurn / 360);
    // A trunk that leans over the path is upright enough at the height of heads.
    const double over = 2.4 * tree.lean.norm();
    if (route_.distance(at) > kBeyond || !claim(at, tree.foot() + over)) continue;
    const auto here = builder_.place({Vec3(at.x(), at.y(), height(at)), 0});
    const int sides = route_.distance(at) < kNear ? curved::sides_of(tree.foot()) : kFarSides;
    add_tree(builder_, own, tree, sides);
    if (params_.clutter <= 0 || route_.distance(at) > 9) continue;
    const auto world = builder_.place({Vec3(-at.x(), -at.y(), -height(at)), 0});
    add_roots(at, tree, own);
  }
}

void Forest::add_rocks() {
  RandomStream random = stream(kRocks);
  const int attempts = count(0.006 * params_.clutter);
  for (int k = 0; k < attempts; ++k) {
    const Vec2 at = anywhere(random);
    const double r = random.uniform(0.2, 0.9), flat = random.uniform(0.45, 0.9), yaw = random.uniform(0, kTurn);
    if (route_.distance(at) > 18 || !claim(at, r)) continue;
    const auto here = builder_.place(on_ground(at, yaw));
    add_rock(builder_, {r, 0.8 * r, flat * r});
  }
}

void Forest::add_logs() {
  RandomStream random = stream(kLogs);
  const int attempts = count(0.004 * params_.clutter);
  for (int k = 0; k < attempts; ++k) {
    const Vec2 at = anywhere(random);
    const double length = random.uniform(2.5, 7), r = random.uniform(0.12, 0.3), yaw = random.uniform(0, kTurn);
    const Footprint area{at, Vec2(0.5 * length, r), yaw};
    if (route_.distance(at) > 18 || !plot_.claim(area, keep_)) continue;
    const Vec2 half = 0.5 * length * Vec2(std::cos(yaw), std::sin(yaw));
    const auto end = [&](const Vec2& p, double radius) {
      return curved::Ring{Vec3(p.x(), p.y(), height(p) + 0.7 * radius), radius};
    };
    const std::array<curved::Ring, 2> rings{end(at - half, r), end(at + half, 0.75 * r)};
    curved::add_bar(builder_, rings, curved::sides_of(r), m::kWood);
  }
}

void Forest::add_bushes() {
  RandomStream random = stream(kBushes);
  const int attempts = count(0.035 * params_.bushes);
  for (int k = 0; k < attempts; ++k) {
    const Vec2 at = anywhere(random);
    const double r = random.uniform(0.4, 1.1), tall = r * random.uniform(0.9, 1.9);
    if (route_.distance(at) > 16 || !claim(at, r)) continue;
    const auto here = builder_.place(on_ground(at, 0));
    add_leafy_bush(builder_, random, r, tall);
  }
}

void Forest::add_ferns() {
  RandomStream random = stream(kFerns);
  const int attempts = count(0.25 * params_.bushes);
  for (int k = 0; k < attempts; ++k) {
    const Vec2 at = anywhere(random);
    const double r = random.uniform(0.15, 0.45);
    if (route_.distance(at) > 10 || route_.distance(at) < keep_ + r) continue;
    const auto here = builder_.place(on_ground(at, 0));
    add_fern(builder_, random, r);
  }
}

/// Thin ones across, which stand out by a finger's breadth.
void Forest::add_roots_on_path() {
  if (params_.clutter <= 0) return;
  RandomStream random = stream(kRoots);
  for (double s = random.uniform(1, 4); s < route_.length(); s += random.uniform(1.5, 7) / params_.clutter) {
    const Route::Place place = route_.at(s);
    const Vec2 left(-place.direction.y(), place.direction.x());
    const double r = random.uniform(0.02, 0.04), half = random.uniform(0.3, 1.2), skew = random.uniform(-0.5, 0.5);
    const auto ring = [&](double y, double shift) {
      const Vec2 p = place.at + y * left + shift * place.direction;
      return curved::Ring{Vec3(p.x(), p.y(), height(p) - 0.4 * r), r};
    };
    const std::array<curved::Ring, 3> rings{ring(-half, -skew), ring(0, 0.1), ring(half, skew)};
    curved::add_bar(builder_, rings, 8, m::kWood);
  }
}

}  // namespace

void ForestParams::describe(config::Binder& b, ForestParams& params) {
  b.integer("seed", params.seed, "1", {.min = 0.0}, "of ground and plants");
  b.real("relief", params.relief, "m", {.min = 0.0, .max = 8.0}, "the ground rises and falls by up to this");
  b.real("roughness", params.roughness, "m", {.min = 0.0, .max = 0.15}, "of the ground beside the path, up or down");
  b.real("path", params.path, "m", {.min = 0.8, .max = 6.0}, "width of the path; nothing stands on it");
  b.real("trees", params.trees, "1", {.min = 0.0, .max = 15.0}, "for each 100 m^2, where there is room");
  b.real("lean", params.lean, "deg", {.min = 0.0, .max = 15.0}, "trunks lean by up to this");
  b.real("bushes", params.bushes, "1", {.min = 0.0, .max = 2.0}, "bushes and ferns: 0 none, 1 usual");
  b.real("clutter", params.clutter, "1", {.min = 0.0, .max = 2.0}, "roots, logs and rocks: 0 none, 1 usual");
}

World build_forest(const ForestParams& params, const Route& route, double) { return Forest(params, route).build(); }

}  // namespace aslio::simulator
