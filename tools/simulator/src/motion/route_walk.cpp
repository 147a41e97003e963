#include "aslio/simulator/route_walk.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "aslio/core/angles.hpp"
#include "aslio/core/errors.hpp"
#include "aslio/simulator/random.hpp"
#include "aslio/simulator/walk.hpp"
#include "pace.hpp"
#include "purposes.hpp"

namespace aslio::simulator {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kStraight = 1e-9;  ///< no corner below this angle [rad]

/// Amplitudes. Running: at 2.7 Hz peaks of 2 to 2.5 g leave 2.5 cm (7 cm would be 5 g).
Gait gait_of(GaitKind kind) {
  switch (kind) {
    case GaitKind::walking:
      return {.frequency = 1.9, .height = 0.015, .roll = 1 * kRadPerDeg, .pitch = 1 * kRadPerDeg};
    case GaitKind::oscillating:
      return {.frequency = 1.9, .height = 0.03, .roll = 2 * kRadPerDeg, .pitch = 2 * kRadPerDeg};
    case GaitKind::running:
      return {.frequency = 2.7, .height = 0.025, .roll = 7 * kRadPerDeg, .pitch = 7 * kRadPerDeg};
    case GaitKind::smooth:
      break;
  }
  return {.frequency = 1, .height = 0, .roll = 0, .pitch = 0};
}

/// What the body adds to a gait. Jolts: 0.3 to 0.5 g at the head of who walks, 4 to 6 g in all at a sensor held by who
/// runs. Sway of 2 to 4 cm. Physiological tremor is of 8 to 12 Hz.
struct Body {
  double heel = 0, sway = 0;  ///< [m/s^2], [m]
};
Body body_of(GaitKind kind) {
  switch (kind) {
    case GaitKind::walking:
      return {.heel = 4, .sway = 0.02};
    case GaitKind::oscillating:
      return {.heel = 6, .sway = 0.04};
    case GaitKind::running:
      return {.heel = 25, .sway = 0.02};
    case GaitKind::smooth:
      break;
  }
  return {};
}

constexpr int kTremors = 3;
constexpr double kTremorLow = 8, kTremorHigh = 12;                        // [Hz]
constexpr double kTremorAngle = 0.1 * kRadPerDeg;                         // of all oscillations together, per axis
constexpr double kLeanLow = 5 * kRadPerDeg, kLeanHigh = 15 * kRadPerDeg;  // roll of a turn

/// Each draw has a fixed place in the stream, whatever the magnitudes are.
void add_body(const GaitRealism& realism, GaitKind kind, RandomStream& random, Gait& gait) {
  const Body body = body_of(kind);
  gait.heel = realism.heel * body.heel;
  gait.sway = realism.sway * body.sway;
  const auto phase = [&] { return 2 * kPi * random.uniform(); };
  for (int k = 0; k < kTremors; ++k) {
    Tremor tremor;
    tremor.frequency = random.uniform(kTremorLow, kTremorHigh);
    tremor.amplitude.setConstant(realism.tremor * kTremorAngle / std::sqrt(kTremors));
    for (double& p : tremor.phase) p = phase();
    if (realism.tremor > 0) gait.tremor.push_back(tremor);
  }
}

/// One edge as walked in one of the rounds.
struct Leg {
  std::size_t edge = 0;  ///< of the route, from 0
  Vec2 from = Vec2::Zero(), direction = Vec2::UnitX();
  double length = 0;
  double begin = 0, end = 0;  ///< of its straight part [m]
};

/// What happens at the end of a leg.
struct Corner {
  double angle = 0;      ///< to the next edge [rad], in (-pi, pi]
  double radius = 0;     ///< 0: walked straight on
  double turn_time = 0;  ///< [s]
};

/// Angle by which `from` has to be turned to the left to look along `to`. A U-turn goes to the side given.
double angle_between(const Vec2& from, const Vec2& to, bool left) {
  const double sine = from.x() * to.y() - from.y() * to.x(), cosine = from.dot(to);
  const double angle = std::atan2(sine, cosine);
  return kPi - std::abs(angle) < kStraight ? (left ? kPi : -kPi) : angle;
}

class RoutePlan {
 public:
  RoutePlan(const Route& route, const WalkParams& params, std::uint64_t seed, const GaitRealism& realism)
      : route_(route), params_(params), realism_(realism), pace_(params.speed) {
    plan_corners(seed);
    limit_speeds();
    lay_line();
    check_turns();
    add_glances();
    lean(seed);
  }

  std::unique_ptr<Motion> walk(const Ground& ground, std::uint64_t seed) const {
    Gait gait = gait_of(params_.gait);
    RandomStream random(seed, purpose::kGaitPhase);
    // Roll repeats every two steps. In full walk at time 0 the gait has to pass through zero: the start is the end.
    const double steps = random.uniform(0, 2);
    gait.phase = 2 * kPi * (params_.dynamic_start ? std::floor(steps) : steps);
    RandomStream sway(seed, purpose::kSway);
    add_body(realism_, params_.gait, sway, gait);
    const Vec2& ahead = legs_.front().direction;
    return std::make_unique<Walk>(waypoints_, turns_, gait,
                                  WalkSetting{.ground = ground,
                                              .height = params_.height,
                                              .heading = std::atan2(ahead.y(), ahead.x()),
                                              .rest = params_.standstill,
                                              .under_way = params_.dynamic_start});
  }

 private:
  void plan_corners(std::uint64_t seed);
  void limit_speeds();
  void lay_line();
  void walk_straight(std::size_t k);
  void walk_corner(std::size_t k);
  void check_turns() const;
  void add_glances();
  void lean(std::uint64_t seed);

  void add(double t, const Leg& leg, double along, double speed) {
    const Vec2 p = leg.from + along * leg.direction, v = speed * leg.direction;
    waypoints_.push_back({t, p.x(), p.y(), v.x(), v.y()});
  }
  [[noreturn]] void too_tight(std::size_t leg, const std::string& why) const;
  double time_at(double way) const;

  const Route& route_;
  const WalkParams& params_;
  GaitRealism realism_;
  Pace pace_;
  std::vector<Leg> legs_;
  std::vector<Corner> corners_;  ///< [k] at the end of leg k; the last one is turned while slowing down
  std::vector<double> speeds_;   ///< [k] at the begin of leg k, one more at the end
  std::vector<Waypoint> waypoints_;
  std::vector<double> ways_;  ///< along the route at each waypoint [m]
  std::vector<Turn> turns_;
  std::vector<std::size_t> legs_of_turns_;  ///< the leg each turn ends
};

void RoutePlan::too_tight(std::size_t leg, const std::string& why) const {
  const std::size_t edge = legs_[leg].edge;
  const std::vector<Vec2>& points = route_.points();
  const Vec2 &a = points[edge], &b = points[(edge + 1) % points.size()];
  throw ConfigError(fmt::format("walk: edge {} of the route from ({:g}, {:g}) to ({:g}, {:g}) is {:.3g} m long: {}",
                                edge + 1, a.x(), a.y(), b.x(), b.y(), legs_[leg].length, why));
}

void RoutePlan::plan_corners(std::uint64_t seed) {
  const std::vector<Vec2>& points = route_.points();
  const std::size_t count = points.size() * static_cast<std::size_t>(params_.laps);
  for (std::size_t k = 0; k < count; ++k) {
    const std::size_t edge = k % points.size();
    const Vec2 line = points[(edge + 1) % points.size()] - points[edge];
    legs_.push_back({edge, points[edge], line.normalized(), line.norm(), 0, line.norm()});
  }
  RandomStream random(seed, purpose::kTurnTimes);
  for (std::size_t k = 0; k < count; ++k) {
    Leg& leg = legs_[k];
    Leg& next = legs_[(k + 1) % count];
    const double turn_time = random.uniform(params_.turn_min, params_.turn_max);
    Corner corner;
    corner.angle = angle_between(leg.direction, next.direction, random.uniform() < 0.5);
    corner.turn_time = turn_time * std::max(1.0, std::abs(corner.angle) / (kPi / 2));
    if (std::abs(corner.angle) > kStraight && k + 1 < count) {
      corner.radius = std::min(params_.corner_radius, std::min(leg.length, next.length) / 3);
      leg.end -= corner.radius;
      next.begin += corner.radius;
    }
    corners_.push_back(corner);
  }
}

/// Speeds at the corners, low enough that the straight parts suffice to reach and to lose them.
void RoutePlan::limit_speeds() {
  speeds_.push_back(params_.dynamic_start ? params_.speed : 0);
  for (std::size_t k = 0; k + 1 < legs_.size(); ++k) {
    const Corner& c = corners_[k];
    double speed = params_.speed;
    // The same peak acceleration as in a corner of 90 deg with the full radius.
    if (c.radius > 0)
      speed = std::min(speed, params_.corner_speed * std::sqrt(std::sin(kPi / 4) / std::sin(std::abs(c.angle) / 2) *
                                                               c.radius / params_.corner_radius));
    speeds_.push_back(pace_.reachable(speeds_[k], legs_[k].end - legs_[k].begin, speed));
  }
  speeds_.push_back(0);
  for (std::size_t k = legs_.size(); k-- > 0;) {
    const double allowed = pace_.reachable(speeds_[k + 1], legs_[k].end - legs_[k].begin, speeds_[k]);
    if (k == 0 && params_.dynamic_start && allowed < speeds_[0])
      too_tight(0, fmt::format("after a dynamic start it is too short to slow down from {:g} to {:.2g} m/s; make it "
                               "longer, or speed or corner_radius smaller",
                               speeds_[0], speeds_[1]));
    speeds_[k] = allowed;
  }
}

/// From the speed at its begin up to the speed of the walk, as far as there is room, and down to the speed at its end.
void RoutePlan::walk_straight(std::size_t k) {
  constexpr double kNegligible = 1e-3;  // [m]
  const Leg& leg = legs_[k];
  const double from = speeds_[k], to = speeds_[k + 1], length = leg.end - leg.begin, before = ways_.back();
  const double top = pace_.peak(from, to, length);
  const double up = pace_.distance(from, top), down = pace_.distance(top, to), between = length - up - down;
  double t = waypoints_.back().t;
  const auto advance = [&](double duration, double way, double speed) {
    t += duration;
    add(t, leg, leg.begin + way, speed);
    ways_.push_back(before + way);
  };
  if (up > kNegligible && length - up > kNegligible) advance(pace_.time(from, top), up, top);
  if (between > kNegligible && down > kNegligible) advance(between / top, length - down, top);
  const double rest = length - (ways_.back() - before);
  const double speed = waypoints_.size() > 1 && ways_.back() > before ? top : from;
  advance(2 * rest / (speed + to), length, to);
}

/// Between two edges the velocity passes evenly from one to the other.
void RoutePlan::walk_corner(std::size_t k) {
  const Corner& corner = corners_[k];
  const bool last = k + 1 == legs_.size();
  const double before = waypoints_.back().t, duration = corner.radius > 0 ? 2 * corner.radius / speeds_[k + 1] : 0;
  if (corner.radius > 0) {
    add(before + duration, legs_[k + 1], legs_[k + 1].begin, speeds_[k + 1]);
    ways_.push_back(ways_.back() + 2 * corner.radius);
  }
  if (std::abs(corner.angle) <= kStraight) return;
  const double begin = last ? before - corner.turn_time : before + 0.5 * (duration - corner.turn_time);
  turns_.push_back({begin, corner.turn_time, corner.angle});
  legs_of_turns_.push_back(k);
}

void RoutePlan::lay_line() {
  add(params_.dynamic_start ? 0 : params_.standstill, legs_.front(), 0, speeds_.front());
  ways_.push_back(0);
  for (std::size_t k = 0; k < legs_.size(); ++k) {
    walk_straight(k);
    walk_corner(k);
  }
  // Exactly the start, not the sum of the last edge.
  waypoints_.back().x = waypoints_.front().x;
  waypoints_.back().y = waypoints_.front().y;
}

void RoutePlan::check_turns() const {
  double over = waypoints_.front().t;
  for (std::size_t k = 0; k < turns_.size(); ++k) {
    if (turns_[k].begin < over)
      too_tight(legs_of_turns_[k],
                "it is over before the head has turned; make it longer, or speed, corner_speed or turn_max smaller");
    over = turns_[k].begin + turns_[k].duration;
  }
}

double RoutePlan::time_at(double way) const {
  const auto to = std::upper_bound(ways_.begin(), ways_.end(), way);
  if (to == ways_.end()) return waypoints_.back().t;
  const auto k = static_cast<std::size_t>(to - ways_.begin());
  const double u = (way - ways_[k - 1]) / (ways_[k] - ways_[k - 1]);
  return waypoints_[k - 1].t + u * (waypoints_[k].t - waypoints_[k - 1].t);
}

void RoutePlan::add_glances() {
  const double end = waypoints_.back().t + params_.standstill;
  for (std::size_t k = 0; k < params_.glances.size(); ++k) {
    const Glance& glance = params_.glances[k];
    for (std::int64_t lap = 0; lap < params_.laps; ++lap) {
      const double begin = time_at((static_cast<double>(lap) + glance.at) * route_.length());
      const double back = begin + glance.turn + glance.hold;
      if (back + glance.turn > end)
        throw ConfigError(
            fmt::format("walk.glances[{}]: at {:g} of the round it lasts {:.2f} s longer than the walk; "
                        "make `at` smaller or standstill longer",
                        k, glance.at, back + glance.turn - end));
      turns_.push_back({.begin = begin, .duration = glance.turn, .angle = glance.angle * kRadPerDeg, .glance = true});
      turns_.push_back({.begin = back, .duration = glance.turn, .angle = -glance.angle * kRadPerDeg, .glance = true});
    }
  }
}

/// A turn is one about all axes: the head leans into it and nods.
void RoutePlan::lean(std::uint64_t seed) {
  RandomStream random(seed, purpose::kLean);
  for (Turn& turn : turns_) {
    const double share = std::min(1.0, std::abs(turn.angle) / (kPi / 2)), size = realism_.turns * share;
    turn.roll = (turn.angle > 0 ? -size : size) * random.uniform(kLeanLow, kLeanHigh);
    turn.pitch = size * random.uniform(-kLeanHigh, kLeanHigh);
  }
}

}  // namespace

std::unique_ptr<Motion> make_route_walk(const Route& route, const Ground& ground, const WalkParams& params,
                                        std::uint64_t seed, const GaitRealism& realism) {
  return RoutePlan(route, params, seed, realism).walk(ground, seed);
}

}  // namespace aslio::simulator
