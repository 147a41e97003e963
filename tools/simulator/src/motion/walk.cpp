#include "aslio/simulator/walk.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>

#include "motion_state.hpp"

namespace aslio::simulator {
namespace {

/// A turn counts as over this much after its end [s], so that rounding of its end cannot cut it off.
constexpr double kOverMargin = 1e-9;

/// Position in the plan at slowed time.
void set_place(const std::vector<Waypoint>& waypoints, bool under_way, const Jet& t, Jet& x, Jet& y) {
  const auto later = [](double limit, const Waypoint& w) { return limit < w.t; };
  const auto to = std::upper_bound(waypoints.begin(), waypoints.end(), t.x, later);
  if (to == waypoints.end()) {
    x.x = to[-1].x;
    y.x = to[-1].y;
  } else if (to == waypoints.begin() || t.x == waypoints.front().t) {
    const Waypoint& first = waypoints.front();
    const double moving = under_way ? 1 : 0;
    x = {first.x + moving * first.vx * (t.x - first.t), moving * first.vx * t.d, 0};
    y = {first.y + moving * first.vy * (t.x - first.t), moving * first.vy * t.d, 0};
  } else {
    const Waypoint &a = to[-1], &b = *to;
    const double duration = b.t - a.t;
    const Jet u = unit_time(t, a.t, duration);
    x = hermite(u, a.x, b.x, a.vx * duration, b.vx * duration);
    y = hermite(u, a.y, b.y, a.vy * duration, b.vy * duration);
  }
}

/// Height of the ground under a moving point.
Jet under(const Ground& ground, const Jet& x, const Jet& y) {
  const GroundHeight g = ground.at(x.x, y.x);
  return {g.z, g.zx * x.d + g.zy * y.d,
          g.zxx * x.d * x.d + 2 * g.zxy * x.d * y.d + g.zyy * y.d * y.d + g.zx * x.dd + g.zy * y.dd};
}

constexpr int kMaxHarmonics = 60;

/// Amplitudes of the height whose second derivative is a Gaussian of `peak` at each step, less its mean: upwards, when
/// the foot meets the ground. Harmonics that the Gaussian damps below 1e-3 are left out.
std::vector<double> jolt_of(double peak, double width, double frequency) {
  std::vector<double> amplitudes;
  const double w = 2 * std::numbers::pi * frequency;
  double sum = 0;
  for (int n = 1; n <= kMaxHarmonics; ++n) {
    const double damping = std::exp(-0.5 * n * n * w * w * width * width);
    if (damping < 1e-3) break;
    amplitudes.push_back(damping);
    sum += damping;
  }
  for (std::size_t k = 0; k < amplitudes.size(); ++k) {
    const double nw = static_cast<double>(k + 1) * w;
    amplitudes[k] *= -peak / (sum * nw * nw);
  }
  return amplitudes;
}

/// cos(w t + phase) less its value at time 0: a walk that is under way begins where it ends.
Jet cosine_from_start(double w, double t, double phase) {
  const Jet cosine = sine(w, t, phase + 0.5 * std::numbers::pi);
  return cosine + Jet{-std::cos(phase), 0, 0};
}

}  // namespace

struct Walk::Gaited {
  Jet height, side, roll, pitch, yaw;
};

Walk::Gaited Walk::body(double t) const {
  const double w = 2 * std::numbers::pi * gait_.frequency, phase = gait_.phase;
  Gaited s;
  for (std::size_t k = 0; k < jolt_.size(); ++k) {
    const double n = static_cast<double>(k + 1);
    // The foot meets the ground where the sines of the gait are lowest.
    s.height = s.height + jolt_[k] * cosine_from_start(n * w, t, n * (phase + 0.5 * std::numbers::pi));
  }
  if (gait_.sway > 0) s.side = gait_.sway * sine(0.5 * w, t, 0.5 * phase);
  for (const Tremor& tremor : gait_.tremor) {
    const double v = 2 * std::numbers::pi * tremor.frequency;
    s.roll = s.roll + tremor.amplitude.x() * cosine_from_start(v, t, tremor.phase.x());
    s.pitch = s.pitch + tremor.amplitude.y() * cosine_from_start(v, t, tremor.phase.y());
    s.yaw = s.yaw + tremor.amplitude.z() * cosine_from_start(v, t, tremor.phase.z());
  }
  return s;
}

Walk::Walk(std::vector<Waypoint> waypoints, std::vector<Turn> turns, const Gait& gait, WalkSetting setting)
    : waypoints_(std::move(waypoints)), turns_(std::move(turns)), gait_(gait), setting_(std::move(setting)) {
  std::stable_sort(turns_.begin(), turns_.end(), [](const Turn& a, const Turn& b) { return a.begin < b.begin; });
  std::copy_if(turns_.begin(), turns_.end(), std::back_inserter(glances_), [](const Turn& t) { return t.glance; });
  angle_before_.push_back(setting_.heading);
  has_body_ = gait_.heel > 0 || gait_.sway > 0 || !gait_.tremor.empty();
  if (gait_.heel > 0) jolt_ = jolt_of(gait_.heel, gait_.heel_time, gait_.frequency);
  for (const Turn& turn : turns_) {
    const double over = turn.begin + turn.duration + kOverMargin;
    all_over_.push_back(all_over_.empty() ? over : std::max(all_over_.back(), over));
    angle_before_.push_back(angle_before_.back() + turn.angle);
  }
}

Walk::Walk(std::vector<Waypoint> waypoints, std::vector<Turn> turns, const Gait& gait, double time_scale)
    : Walk(std::move(waypoints), std::move(turns), gait, WalkSetting{}) {
  time_scale_ = time_scale;
}

double Walk::duration() const { return waypoints_.back().t * time_scale_ + setting_.rest; }

MotionState Walk::at(double t) const {
  const double begin = waypoints_.front().t, end = waypoints_.back().t;
  const Jet slow{t / time_scale_, 1 / time_scale_, 0};
  Jet x, y;
  set_place(waypoints_, setting_.under_way, slow, x, y);

  const auto over = std::upper_bound(all_over_.begin(), all_over_.end(), slow.x) - all_over_.begin();
  Jet yaw{angle_before_[static_cast<std::size_t>(over)], 0, 0};
  Jet z, pitch, roll;
  for (auto turn = turns_.begin() + over; turn != turns_.end() && turn->begin < slow.x; ++turn) {
    const Jet u = unit_time(slow, turn->begin, turn->duration);
    yaw = yaw + turn->angle * smooth_step(u);
    if (turn->roll == 0 && turn->pitch == 0) continue;
    const Jet lean = bump(u);
    roll = roll + turn->roll * lean;
    pitch = pitch + turn->pitch * lean;
  }

  const Jet rise = setting_.under_way ? Jet{1, 0, 0} : smooth_step(unit_time(slow, begin, gait_.fade));
  const Jet fade = rise * smooth_step(-1.0 * unit_time(slow, end, gait_.fade));
  if (fade.x > 0) {
    const double w = 2 * std::numbers::pi * gait_.frequency, phase = gait_.phase;
    z = gait_.height * (fade * (sine(w, t, phase) + 0.3 * sine(2 * w, t, 2 * phase)));
    pitch = pitch + gait_.pitch * (fade * sine(w, t, phase));
    roll = roll + gait_.roll * (fade * sine(0.5 * w, t, 0.5 * phase));
    if (has_body_) {
      const Gaited s = body(t);
      const Jet side = fade * s.side;
      Jet heading = yaw;
      for (const Turn& glance : glances_)
        heading = heading + -glance.angle * smooth_step(unit_time(slow, glance.begin, glance.duration));
      x = x + -1.0 * (side * sine_of(heading));
      y = y + side * cosine_of(heading);
      z = z + fade * s.height;
      pitch = pitch + fade * s.pitch;
      roll = roll + fade * s.roll;
      yaw = yaw + fade * s.yaw;
    }
  }
  z = z + Jet{setting_.height, 0, 0} + under(setting_.ground, x, y);
  return motion_state(x, y, z, yaw, pitch, roll);
}

}  // namespace aslio::simulator
