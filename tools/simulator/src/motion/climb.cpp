#include "aslio/simulator/climb.hpp"

#include <algorithm>

namespace aslio::simulator {
namespace {

constexpr double kStep = 0.02;   ///< at which the walk is looked at for its corners [s]
constexpr double kCorner = 1.5;  ///< a walk cuts its corners nearer than this [m]
constexpr double kAway = 1e-6;   ///< a distance that grows by more than this in a step has passed its least [m]

/// From one corner to the next.
struct Leg {
  double begin = 0;              ///< time [s]
  double base = 0;               ///< height at the begin [m]
  const Climb* climb = nullptr;  ///< none: level
  double at_begin = 0;           ///< height of the climb's ground there [m]
};

double height_at(const Climb& climb, const Vec2& p) { return climb.ground.height(p.x(), p.y()); }

const Climb* climb_of(const std::vector<Climb>& climbs, std::size_t edge) {
  const auto found = std::find_if(climbs.begin(), climbs.end(), [&](const Climb& c) { return c.edge == edge; });
  return found == climbs.end() ? nullptr : &*found;
}

class Climbing final : public Motion {
 public:
  Climbing(std::unique_ptr<Motion> walk, const Motion& plain, const Route& route, std::vector<Climb> climbs)
      : walk_(std::move(walk)), climbs_(std::move(climbs)) {
    const std::vector<Vec2>& points = route.points();
    enter(0, points.front(), 0, 0);
    std::size_t edge = 0;
    double before = 0;
    for (double t = 0; t < plain.duration(); t += kStep) {
      const Vec2& corner = points[(edge + 1) % points.size()];
      const double away = (plain.at(t).p.head<2>() - corner).norm();
      if (t > 0 && away < kCorner && away > before + kAway) {
        const Leg& leg = legs_.back();
        const double base = leg.base + (leg.climb ? height_at(*leg.climb, corner) - leg.at_begin : 0);
        edge = (edge + 1) % points.size();
        enter(edge, corner, t, base);
        before = (plain.at(t).p.head<2>() - points[(edge + 1) % points.size()]).norm();
      } else {
        before = away;
      }
    }
  }

  MotionState at(double t) const override {
    MotionState m = walk_->at(t);
    const auto next = std::upper_bound(legs_.begin() + 1, legs_.end(), t,
                                       [](double limit, const Leg& leg) { return limit < leg.begin; });
    const Leg& leg = next[-1];
    m.p.z() += leg.base;
    if (leg.climb == nullptr) return m;
    const GroundHeight g = leg.climb->ground.at(m.p.x(), m.p.y());
    const double vx = m.v.x(), vy = m.v.y();
    m.p.z() += g.z - leg.at_begin;
    m.v.z() += g.zx * vx + g.zy * vy;
    m.a.z() += g.zxx * vx * vx + 2 * g.zxy * vx * vy + g.zyy * vy * vy + g.zx * m.a.x() + g.zy * m.a.y();
    return m;
  }
  double duration() const override { return walk_->duration(); }

 private:
  void enter(std::size_t edge, const Vec2& from, double t, double base) {
    const Climb* climb = climb_of(climbs_, edge);
    legs_.push_back({t, base, climb, climb ? height_at(*climb, from) : 0});
  }

  std::unique_ptr<Motion> walk_;
  std::vector<Climb> climbs_;
  std::vector<Leg> legs_;  ///< in order of time
};

}  // namespace

double climbed(const Route& route, const std::vector<Climb>& climbs, double s) {
  const std::vector<Vec2>& points = route.points();
  double height = 0;
  for (std::size_t edge = 0; edge < points.size(); ++edge) {
    const Vec2 &a = points[edge], &b = points[(edge + 1) % points.size()];
    const double length = (b - a).norm(), along = std::clamp(s, 0.0, length);
    if (const Climb* climb = climb_of(climbs, edge))
      height += height_at(*climb, a + along / length * (b - a)) - height_at(*climb, a);
    if (s <= length) break;
    s -= length;
  }
  return height;
}

std::unique_ptr<Motion> make_climbing(std::unique_ptr<Motion> walk, const Motion& plain, const Route& route,
                                      std::vector<Climb> climbs) {
  return std::make_unique<Climbing>(std::move(walk), plain, route, std::move(climbs));
}

}  // namespace aslio::simulator
