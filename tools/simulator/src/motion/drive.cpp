#include "aslio/simulator/drive.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "aslio/core/angles.hpp"
#include "aslio/simulator/random.hpp"
#include "motion_state.hpp"
#include "purposes.hpp"
#include "speed_plan.hpp"

namespace aslio::simulator {
namespace {

/// Of a usual car: 0.5 deg of pitch and 1.2 deg of roll at 3 m/s^2.
constexpr double kPitchPerAcceleration = 0.5 * kRadPerDeg / 3;  ///< [rad per m/s^2]
constexpr double kRollPerAcceleration = 1.2 * kRadPerDeg / 3;

struct RoadWave {
  double length = 1, z = 0, angle = 0;  ///< [m], amplitudes [m], [deg]
};
/// A good road through springs and tyres: about 0.4 m/s^2 up and down (RMS) at 30 m/s, 0.05 at 10 m/s.
constexpr std::array<RoadWave, 4> kRoadWaves = {
    {{23.0, 4e-3, 0.05}, {9.1, 1e-3, 0.03}, {3.7, 1.5e-4, 0.01}, {1.93, 3e-5, 0.002}}};

}  // namespace

Drive::Drive(const RoadLine& road, const Ground& ground, const DriveParams& params, std::uint64_t seed)
    : road_(road),
      ground_(ground),
      height_(params.height),
      pitch_per_acceleration_(params.suspension * kPitchPerAcceleration),
      plan_(std::make_unique<SpeedPlan>(road, params)) {
  duration_ = std::min(plan_->duration(), params.duration.value_or(plan_->duration()));
  for (const RoadLine::Bend& bend : road.bends()) {
    const double speed = plan_->way(plan_->time_at(bend.begin + 0.5 * bend.length)).d;
    // Outwards: to the right in a bend to the left.
    const double lateral = speed * speed / bend.radius() * (bend.angle > 0 ? 1 : -1);
    leans_.push_back({bend.begin, bend.length, params.suspension * kRollPerAcceleration * lateral});
  }
  add_unevenness(params.roughness, seed);
}

Drive::~Drive() = default;

void Drive::add_unevenness(double roughness, std::uint64_t seed) {
  if (roughness <= 0) return;
  RandomStream random(seed, purpose::kRoad);
  for (const RoadWave& wave : kRoadWaves) {
    Unevenness u;
    u.k = 2 * std::numbers::pi / wave.length;
    u.z = roughness * wave.z;
    u.pitch = u.roll = roughness * wave.angle * kRadPerDeg;
    u.phase_z = random.uniform(0, 2 * std::numbers::pi);
    u.phase_pitch = random.uniform(0, 2 * std::numbers::pi);
    u.phase_roll = random.uniform(0, 2 * std::numbers::pi);
    unevenness_.push_back(u);
  }
}

double Drive::way(double t) const { return plan_->way(t).x; }
double Drive::speed(double t) const { return plan_->way(t).d; }

/// What springs and the road's surface add.
void Drive::sway(double t, const Jet& way, Jet& z, Jet& pitch, Jet& roll) const {
  const SpeedPiece& piece = plan_->piece(t);
  if (piece.from != piece.to) {
    // The nose rises while the car gathers speed: negative pitch.
    const double rise = -pitch_per_acceleration_ * piece.peak_acceleration();
    pitch = pitch + rise * bump(unit_time({t, 1, 0}, piece.t, piece.duration));
  }
  for (const Lean& lean : leans_) {
    if (way.x <= lean.begin) break;
    if (way.x < lean.begin + lean.length) roll = roll + lean.roll * bump(unit_time(way, lean.begin, lean.length));
  }
  for (const Unevenness& u : unevenness_) {
    const auto wave = [&](double amplitude, double phase) { return amplitude * sine_of(u.k * way + Jet{phase, 0, 0}); };
    z = z + wave(u.z, u.phase_z);
    pitch = pitch + wave(u.pitch, u.phase_pitch);
    roll = roll + wave(u.roll, u.phase_roll);
  }
}

MotionState Drive::at(double t) const {
  const Jet way = plan_->way(t);
  const RoadLine::Place place = road_.at(way.x);
  const Jet heading = composed(place.heading, place.curvature, place.curvature_slope, way);
  const Jet c = cosine_of(heading), s = sine_of(heading);
  const Jet x{place.at.x(), c.x * way.d, c.d * way.d + c.x * way.dd};
  const Jet y{place.at.y(), s.x * way.d, s.d * way.d + s.x * way.dd};

  Jet z{height_, 0, 0}, pitch, roll;
  for (const Ground::Wave& wave : ground_.waves) {
    const Jet phase = wave.kx * x + wave.ky * y + Jet{wave.phase, 0, 0};
    const Jet slope = wave.amplitude * cosine_of(phase);
    z = z + wave.amplitude * sine_of(phase);
    // Slopes are small: the angle is its tangent.
    pitch = pitch + -1.0 * (slope * (wave.kx * c + wave.ky * s));
    roll = roll + slope * (wave.ky * c + -wave.kx * s);
  }
  sway(t, way, z, pitch, roll);
  return motion_state(x, y, z, heading, pitch, roll);
}

}  // namespace aslio::simulator
