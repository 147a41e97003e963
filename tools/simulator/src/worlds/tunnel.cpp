#include "aslio/simulator/worlds/tunnel.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "aslio/config/binder.hpp"
#include "aslio/core/errors.hpp"
#include "aslio/simulator/random.hpp"
#include "purposes.hpp"
#include "worlds/curved.hpp"

namespace aslio::simulator {
namespace {

namespace m = material;

constexpr double kPi = std::numbers::pi;
constexpr double kRoad = 1.8;      // the middle of a circular section is this far above the road [m]
constexpr double kSpring = 1.7;    // of a horseshoe: its vault begins this far above the road [m]
constexpr double kFoot = 0.5;      // walls reach this far below the road [m]
constexpr double kFromWall = 0.9;  // least distance of the route from the foot of a wall [m]
constexpr double kFromEnd = 1.5;   // and from the gates [m]
constexpr double kNicheLong = 2.4, kNicheHigh = 2.4, kNicheDeep = 1.2;  // [m]
constexpr double kStraight = 2;                                         // of the pieces of the straight parts [m]

/// Line of the tunnel in the plan.
class Axis {
 public:
  Axis(const TunnelParams& p, double scale)
      : heading_(p.heading * kPi / 180),
        bend_(p.bend * kPi / 180),
        radius_(scale * p.bend_radius),
        before_(scale * p.before),
        arc_(std::abs(bend_) * radius_),
        after_(scale * p.after) {}

  double length() const { return before_ + arc_ + after_; }
  double bend_begin() const { return before_; }
  double bend_end() const { return before_ + arc_; }
  double bend_radius() const { return radius_; }
  double yaw(double s) const {
    const double share = arc_ > 0 ? std::clamp((s - before_) / arc_, 0.0, 1.0) : s < before_ ? 0 : 1;
    return heading_ + bend_ * share;
  }
  Vec2 direction(double s) const { return {std::cos(yaw(s)), std::sin(yaw(s))}; }
  Vec2 at(double s) const {
    const Vec2 first = direction(0);
    if (s <= before_) return s * first;
    const double side = bend_ < 0 ? -1 : 1, on_arc = std::min(s - before_, arc_);
    const Vec2 left(-first.y(), first.x());
    const double a = arc_ > 0 ? on_arc / radius_ : 0;
    const Vec2 p = before_ * first + radius_ * (std::sin(a) * first + side * (1 - std::cos(a)) * left);
    return s <= before_ + arc_ ? p : Vec2(p + (s - before_ - arc_) * direction(s));
  }
  Vec2 at(double s, double y) const {
    const Vec2 d = direction(s);
    return at(s) + y * Vec2(-d.y(), d.x());
  }
  /// (s, y) of a point: where its distance to the axis is least.
  Vec2 local(const Vec2& p) const {
    constexpr double kStep = 0.5;
    double best = 0;
    for (double s = 0; s <= length(); s += kStep)
      if ((at(s) - p).squaredNorm() < (at(best) - p).squaredNorm()) best = s;
    // Newton's steps along the direction: the axis is smooth.
    for (int k = 0; k < 20; ++k) best = std::clamp(best + 0.8 * direction(best).dot(p - at(best)), 0.0, length());
    const Vec2 d = direction(best);
    return {best, Vec2(-d.y(), d.x()).dot(p - at(best))};
  }

 private:
  double heading_, bend_, radius_, before_, arc_, after_;
};

/// The cross-section: y to the left of the axis, z above the road.
struct Section {
  explicit Section(const TunnelParams& p) : radius(p.radius) {
    if (p.section == TunnelSection::circular) {
      centre = kRoad;
      const double low = std::asin((-kFoot - centre) / radius);
      arc = curved::arc({0, centre}, radius, low, kPi - low);
    } else {
      // Side walls of twice the radius lean in to the road.
      centre = kSpring;
      const double low = std::asin((-kFoot - centre) / (2 * radius));
      arc = curved::arc({-radius, centre}, 2 * radius, low, 0);
      const std::vector<Vec2> top = curved::arc({0, centre}, radius, 0, kPi);
      std::vector<Vec2> left = arc;
      arc.insert(arc.end(), top.begin() + 1, top.end());
      std::reverse(left.begin(), left.end());
      for (std::size_t k = 1; k < left.size(); ++k) arc.emplace_back(-left[k].x(), left[k].y());
    }
  }
  /// Half the width at a height.
  double half_width(double z) const {
    double least = radius;
    for (std::size_t k = 1; k < arc.size() && arc[k].x() > 0; ++k) {
      const Vec2 &a = arc[k - 1], &b = arc[k];
      if (a.y() <= z && z <= b.y()) least = a.x() + (b.x() - a.x()) * (z - a.y()) / (b.y() - a.y());
    }
    return least;
  }
  double radius, centre = 0;
  std::vector<Vec2> arc;  ///< from the left foot over the crown to the right one
};

struct Niche {
  double from = 0, to = 0, side = 1;
};

class Tunnel {
 public:
  Tunnel(const TunnelParams& params, const Axis& axis)
      : params_(params), axis_(axis), section_(params), seed_(static_cast<std::uint64_t>(params.seed)) {
    RandomStream random(seed_, purpose::kLayout, 1);
    const double k = 2 * kPi / 120, heading = axis.yaw(0) + random.uniform(-0.5, 0.5);
    ground_.waves.push_back(
        {0.5 * params.relief, k * std::cos(heading), k * std::sin(heading), random.uniform(0, 2 * kPi)});
    double side = 1;
    for (double s = params.niches; params.niches > 0 && s + kNicheLong + 2 < axis.length(); s += params.niches) {
      niches_.push_back({s, s + kNicheLong, side});
      side = -side;
    }
    lay_stations();
  }

  void require_inside(const Route& route) const;
  World build();

 private:
  curved::Station station(double s) const {
    const Vec2 p = axis_.at(s);
    return {Vec3(p.x(), p.y(), ground_.height(p.x(), p.y())), axis_.direction(s)};
  }
  Vec3 at(double s, double y, double z) const {
    const Vec2 p = axis_.at(s, y);
    return {p.x(), p.y(), station(s).at.z() + z};
  }
  const Niche* niche_at(double s, double side) const {
    for (const Niche& n : niches_)
      if (n.side == side && s > n.from && s < n.to) return &n;
    return nullptr;
  }
  void lay_stations();
  void add_road();
  void add_vault();
  void add_niche(const Niche& niche);
  void add_gate(double s, double sense);
  void add_cables();
  void add_lamps();
  void add_fans();
  void add_things();

  const TunnelParams& params_;
  const Axis& axis_;
  Section section_;
  std::uint64_t seed_;
  Ground ground_;
  std::vector<Niche> niches_;
  std::vector<double> stations_;  ///< along the axis [m]
  MeshBuilder builder_;
};

/// Close enough in the bend, and at both ends of every niche.
void Tunnel::lay_stations() {
  std::vector<double> marks{0, axis_.bend_begin(), axis_.bend_end(), axis_.length()};
  for (const Niche& n : niches_) {
    marks.push_back(n.from);
    marks.push_back(n.to);
  }
  std::sort(marks.begin(), marks.end());
  const double outer = axis_.bend_radius() + section_.radius;
  const double in_bend = std::min(kStraight, axis_.bend_radius() * 2 * std::acos(1 - curved::kChordError / outer));
  stations_.push_back(0);
  for (std::size_t k = 1; k < marks.size(); ++k) {
    const double from = marks[k - 1], length = marks[k] - from, middle = from + 0.5 * length;
    if (length < 1e-6) continue;
    const double step = middle > axis_.bend_begin() && middle < axis_.bend_end() ? in_bend : kStraight;
    const int pieces = std::max(1, static_cast<int>(std::ceil(length / step - 1e-9)));
    for (int j = 1; j <= pieces; ++j) stations_.push_back(from + length * j / pieces);
  }
}

void Tunnel::require_inside(const Route& route) const {
  const double half = section_.half_width(0) - kFromWall;
  for (double s = 0; s < route.length(); s += 0.25) {
    const Vec2 p = route.at(s).at, local = axis_.local(p);
    if (std::abs(local.y()) <= half && local.x() >= kFromEnd && local.x() <= axis_.length() - kFromEnd) continue;
    throw ConfigError(
        fmt::format("route: at {:.1f} m of the round, ({:.2f}, {:.2f}) [m], it is {:.2f} m beside the axis of the "
                    "tunnel, {:.1f} m from its begin; keep within {:.2f} m of the axis and {:.1f} m from both ends, or "
                    "change world.radius, before, bend, bend_radius or after",
                    s, p.x(), p.y(), std::abs(local.y()), local.x(), half, kFromEnd));
  }
}

void Tunnel::add_road() {
  const double half = section_.half_width(0) + 0.3;
  constexpr int kAcross = 10;
  const auto place = [&](double s, double y, double up) {
    const Vec2 p = axis_.at(s, y);
    return Vec3(p.x(), p.y(), ground_.height(p.x(), p.y()) + up);
  };
  for (std::size_t k = 1; k < stations_.size(); ++k) {
    const double a = stations_[k - 1], b = stations_[k];
    for (int j = 0; j < kAcross; ++j) {
      const double y0 = -half + 2 * half * j / kAcross, y1 = -half + 2 * half * (j + 1) / kAcross;
      builder_.quad(place(a, y0, 0), place(b, y0, 0), place(b, y1, 0), place(a, y1, 0), m::kAsphalt);
    }
    const double edge = section_.half_width(0) - 0.35;
    for (const double y : {-edge, edge, -0.06})
      builder_.quad(place(a, y, 0.004), place(b, y, 0.004), place(b, y + 0.12, 0.004), place(a, y + 0.12, 0.004),
                    m::kWhitePaint);
  }
}

void Tunnel::add_vault() {
  const std::vector<Vec2>& arc = section_.arc;
  // Below the head of the niches on either side, and the rest.
  const auto head = [](const Vec2& p) { return p.y() > kNicheHigh; };
  const auto first = std::find_if(arc.begin(), arc.end(), head);
  const auto last = std::find_if(first, arc.end(), [&](const Vec2& p) { return !head(p); });
  const std::vector<Vec2> left(arc.begin(), first + 1), top(first, last), right(last - 1, arc.end());
  for (std::size_t k = 1; k < stations_.size(); ++k) {
    const std::array<curved::Station, 2> pair{station(stations_[k - 1]), station(stations_[k])};
    const double middle = 0.5 * (stations_[k - 1] + stations_[k]);
    curved::sweep(builder_, top, pair, m::kConcrete);
    if (niche_at(middle, -1) == nullptr) curved::sweep(builder_, right, pair, m::kConcrete);
    if (niche_at(middle, 1) == nullptr) curved::sweep(builder_, left, pair, m::kConcrete);
  }
}

void Tunnel::add_niche(const Niche& niche) {
  std::vector<Vec2> wall;  // of the left side, upwards
  for (const Vec2& p : section_.arc) {
    if (p.x() < 0) break;
    wall.push_back(p);
    if (p.y() > kNicheHigh) break;
  }
  const double back = section_.radius + kNicheDeep, side = niche.side;
  for (const double s : {niche.from, niche.to})
    for (std::size_t k = 1; k < wall.size(); ++k) {
      const Vec2 &p = wall[k - 1], &q = wall[k];
      builder_.quad(at(s, side * p.x(), p.y()), at(s, side * back, p.y()), at(s, side * back, q.y()),
                    at(s, side * q.x(), q.y()), m::kConcrete);
    }
  const double a = niche.from, b = niche.to, top = wall.back().y();
  builder_.quad(at(a, side * back, -kFoot), at(b, side * back, -kFoot), at(b, side * back, top),
                at(a, side * back, top), m::kPlaster);
  for (const double z : {0.15, top}) {
    const double y = side * (section_.half_width(std::max(z, 0.0)) - 0.02);
    builder_.quad(at(a, y, z), at(b, y, z), at(b, side * back, z), at(a, side * back, z), m::kConcrete);
  }
  const double low = 0.7, high = 1.7;
  const auto here = builder_.place({at(0.5 * (a + b), side * back, 0), axis_.yaw(0.5 * (a + b))});
  builder_.box({-0.55, std::min(0.0, -side * 0.06), 0.15}, {0.4, std::max(0.0, -side * 0.06), 2.15}, m::kMetal);
  builder_.box({0.6, std::min(0.0, -side * 0.25), low}, {1.0, std::max(0.0, -side * 0.25), high}, m::kWhitePaint);
}

/// Two leaves of slats in a frame, and the wall above them.
void Tunnel::add_gate(double s, double sense) {
  const curved::Station end = station(s);
  const double half = section_.radius + 0.1, top = section_.centre + section_.radius + 0.1;
  const auto here = builder_.place({end.at, std::atan2(end.along.y(), end.along.x())});
  builder_.quad({0, -half, -kFoot}, {0, half, -kFoot}, {0, half, top}, {0, -half, top}, m::kConcrete);
  constexpr int kSlats = 14;
  for (int k = 0; k < kSlats; ++k) {
    const double z = 4.2 * k / kSlats, out = k % 2 == 0 ? 0.05 : 0.08;
    builder_.box({std::min(0.0, sense * out), -3.2, z}, {std::max(0.0, sense * out), 3.2, z + 4.2 / kSlats}, m::kMetal);
  }
  for (const double y : {-3.4, -0.1, 3.2})
    builder_.box({std::min(0.0, sense * 0.25), y, 0}, {std::max(0.0, sense * 0.25), y + 0.2, 4.3}, m::kMetal);
}

/// Pipes along both walls, above the niches.
void Tunnel::add_cables() {
  constexpr double kUp = 2.75, kRadius = 0.05;
  const std::vector<Vec2> ring = curved::arc({0, 0}, kRadius, 0, 2 * kPi);
  for (const double side : {-1.0, 1.0}) {
    for (const double up : {kUp, kUp + 0.25}) {
      const double y = side * (section_.half_width(up) - 0.14);
      std::vector<Vec2> profile;
      for (const Vec2& p : ring) profile.emplace_back(p.x() + y, p.y() + up);
      std::vector<curved::Station> stations;
      for (const double s : stations_) stations.push_back(station(s));
      curved::sweep(builder_, profile, stations, up > kUp ? m::kBlackPaint : m::kMetal);
    }
  }
}

void Tunnel::add_lamps() {
  if (params_.lamps <= 0) return;
  const double crown = section_.centre + section_.radius;
  for (double s = 0.5 * params_.lamps; s < axis_.length() - 1; s += params_.lamps) {
    const auto here = builder_.place({at(s, 0, crown), axis_.yaw(s)});
    builder_.box({-0.6, -0.12, -0.3}, {0.6, 0.12, -0.18}, m::kWhitePaint);
    for (const double x : {-0.5, 0.48}) builder_.box({x, -0.02, -0.2}, {x + 0.02, 0.02, 0.05}, m::kMetal);
  }
}

void Tunnel::add_fans() {
  if (params_.fans <= 0) return;
  const double up = section_.centre + 0.72 * section_.radius;
  for (double s = 0.5 * params_.fans; s < axis_.length() - 3; s += params_.fans) {
    for (const double y : {-1.1, 1.1}) {
      const Vec2 d = axis_.direction(s);
      const Vec3 centre = at(s, y, up), along(d.x(), d.y(), 0);
      curved::add_bar(builder_, centre - 1.3 * along, centre + 1.3 * along, 0.42, m::kMetal);
      curved::add_bar(builder_, centre, centre + Vec3(0, 0, 0.25 * section_.radius), 0.04, m::kMetal);
    }
  }
}

/// Boxes and signs on the walls, at distances that do not repeat.
void Tunnel::add_things() {
  for (const double side : {-1.0, 1.0}) {
    RandomStream random(seed_, purpose::kLayout, side > 0 ? 10 : 11);
    for (double s = random.uniform(3, 12); s < axis_.length() - 2; s += random.uniform(8, 22)) {
      const double wide = random.uniform(0.2, 0.5), high = random.uniform(0.3, 0.6), deep = random.uniform(0.1, 0.2);
      if (niche_at(s, side) || niche_at(s - 0.6, side) || niche_at(s + 0.6, side)) continue;
      const double wall = section_.half_width(1.4);
      const auto here = builder_.place({at(s, side * wall, 0), axis_.yaw(s)});
      builder_.box({-0.5 * wide, std::min(side * 0.1, -side * deep), 1.4},
                   {0.5 * wide, std::max(side * 0.1, -side * deep), 1.4 + high}, m::kMetal);
    }
  }
}

World Tunnel::build() {
  add_road();
  add_vault();
  for (const Niche& niche : niches_) add_niche(niche);
  add_gate(0, 1);
  add_gate(axis_.length(), -1);
  add_cables();
  add_lamps();
  add_fans();
  add_things();
  return {builder_.take(), ground_};
}

}  // namespace

void TunnelParams::describe(config::Binder& b, TunnelParams& params) {
  b.integer("seed", params.seed, "1", {.min = 0.0}, "of the relief and of what hangs on the walls");
  b.choice("section", params.section, {{"circular", TunnelSection::circular}, {"horseshoe", TunnelSection::horseshoe}},
           "shape of the vault");
  b.real("radius", params.radius, "m", {.min = 4.0, .max = 12.0}, "of the vault");
  b.real("heading", params.heading, "deg", {.min = -180.0, .max = 180.0}, "of the axis at its begin, the origin");
  b.real("before", params.before, "m", {.min = 5.0, .max = 2000.0},
         "of the axis before the bend; scales with the route");
  b.real("bend", params.bend, "deg", {.min = -120.0, .max = 120.0}, "change of direction, positive to the left");
  b.real("bend_radius", params.bend_radius, "m", {.min = 20.0, .max = 2000.0}, "of the axis in the bend; scales");
  b.real("after", params.after, "m", {.min = 5.0, .max = 2000.0}, "of the axis after the bend; scales");
  b.real("relief", params.relief, "m", {.min = 0.0, .max = 4.0}, "the road rises and falls by up to this");
  b.real("niches", params.niches, "m", {.min = 0.0, .max = 500.0}, "between niches, on either side in turn; 0: none");
  b.real("lamps", params.lamps, "m", {.min = 0.0, .max = 500.0}, "between lamps under the crown; 0: none");
  b.real("fans", params.fans, "m", {.min = 0.0, .max = 500.0}, "between pairs of fans under the vault; 0: none");
  for (const auto& [key, value] :
       {std::pair("niches", params.niches), std::pair("lamps", params.lamps), std::pair("fans", params.fans)})
    b.require(value == 0 || value >= 4, key, "must be 0 or at least 4 m");
}

World build_tunnel(const TunnelParams& params, const Route& route, double scale) {
  const Axis axis(params, scale);
  Tunnel tunnel(params, axis);
  tunnel.require_inside(route);
  return tunnel.build();
}

double tunnel_offset(const TunnelParams& params, double scale, const Vec2& p) {
  return Axis(params, scale).local(p).y();
}

}  // namespace aslio::simulator
