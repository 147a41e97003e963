#include "aslio/simulator/walk.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace aslio::simulator {
namespace {

/// A function of time with its first two derivatives.
struct Jet {
  double x = 0, d = 0, dd = 0;
};
Jet operator+(const Jet& a, const Jet& b) { return {a.x + b.x, a.d + b.d, a.dd + b.dd}; }
Jet operator*(const Jet& a, const Jet& b) {
  return {a.x * b.x, a.d * b.x + a.x * b.d, a.dd * b.x + 2 * a.d * b.d + a.x * b.dd};
}
Jet operator*(double k, const Jet& a) { return {k * a.x, k * a.d, k * a.dd}; }
/// sin(w t)
Jet sine(double w, double t) {
  const double s = std::sin(w * t);
  return {s, w * std::cos(w * t), -w * w * s};
}

/// u^4 (c0 + c1 u + c2 u^2 + c3 u^3)
Jet septic(const std::array<double, 4>& c, const Jet& u) {
  Jet sum{c[3], 0, 0};
  for (const double k : {c[2], c[1], c[0]}) sum = sum * u + Jet{k, 0, 0};
  const Jet u2 = u * u;
  return u2 * u2 * sum;
}
/// From 0 to 1, with three vanishing derivatives at both ends.
Jet smooth_step(const Jet& u) {
  if (u.x <= 0) return {};
  if (u.x >= 1) return {1, 0, 0};
  return septic({35, -84, 70, -20}, u);
}
/// 0 at both ends, with slope 1 at the second one; the other derivatives up to the third vanish.
Jet slope_at_end(const Jet& u) { return septic({-15, 39, -34, 10}, u); }

/// Unit interval [begin, begin + duration] at slowed time.
Jet unit_time(const Jet& t, double begin, double duration) {
  return {(t.x - begin) / duration, t.d / duration, t.dd / duration};
}

/// Septic Hermite segment of one coordinate over u in [0, 1].
Jet hermite(const Jet& u, double from, double to, double slope_from, double slope_to) {
  return Jet{from, 0, 0} + slope_from * u + (to - from - slope_from) * smooth_step(u) +
         (slope_to - slope_from) * slope_at_end(u);
}

/// R = Rz(yaw) Ry(pitch) Rx(roll) and the angular rate in the body frame from the rates of the angles.
void set_attitude(const Jet& yaw, const Jet& pitch, const Jet& roll, MotionState& state) {
  const double cy = std::cos(yaw.x), sy = std::sin(yaw.x), cp = std::cos(pitch.x), sp = std::sin(pitch.x);
  const double cr = std::cos(roll.x), sr = std::sin(roll.x);
  state.R << cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr,  //
      sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr,         //
      -sp, cp * sr, cp * cr;
  state.w << roll.d - yaw.d * sp, pitch.d * cr + yaw.d * cp * sr, yaw.d * cp * cr - pitch.d * sr;
}

}  // namespace

Walk::Walk(std::vector<Waypoint> waypoints, std::vector<Turn> turns, const Gait& gait, double time_scale)
    : waypoints_(std::move(waypoints)), turns_(std::move(turns)), gait_(gait), time_scale_(time_scale) {}

double Walk::duration() const { return waypoints_.back().t * time_scale_; }

MotionState Walk::at(double t) const {
  const double begin = waypoints_.front().t, end = waypoints_.back().t;
  Jet slow{t / time_scale_, 1 / time_scale_, 0};
  Jet x, y, yaw;
  if (slow.x <= begin || slow.x >= end) {
    const Waypoint& w = slow.x <= begin ? waypoints_.front() : waypoints_.back();
    x.x = w.x;
    y.x = w.y;
  } else {
    const auto later = [](double limit, const Waypoint& w) { return limit < w.t; };
    const auto to = std::upper_bound(waypoints_.begin(), waypoints_.end(), slow.x, later);
    const Waypoint &a = *(to - 1), &b = *to;
    const double duration = b.t - a.t;
    const Jet u = unit_time(slow, a.t, duration);
    x = hermite(u, a.x, b.x, a.vx * duration, b.vx * duration);
    y = hermite(u, a.y, b.y, a.vy * duration, b.vy * duration);
  }
  for (const Turn& turn : turns_) yaw = yaw + turn.angle * smooth_step(unit_time(slow, turn.begin, turn.duration));

  const Jet fade =
      smooth_step(unit_time(slow, begin, gait_.fade)) * smooth_step(-1.0 * unit_time(slow, end, gait_.fade));
  const double w = 2 * std::numbers::pi * gait_.frequency;
  Jet z, pitch, roll;
  if (fade.x > 0) {
    z = gait_.height * (fade * (sine(w, t) + 0.3 * sine(2 * w, t)));
    pitch = gait_.pitch * (fade * sine(w, t));
    roll = gait_.roll * (fade * sine(0.5 * w, t));
  }
  MotionState state;
  state.p << x.x, y.x, z.x;
  state.v << x.d, y.d, z.d;
  state.a << x.dd, y.dd, z.dd;
  set_attitude(yaw, pitch, roll, state);
  return state;
}

}  // namespace aslio::simulator
