#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "aslio/simulator/people.hpp"

namespace aslio::simulator {
namespace {

constexpr double kClothReflectivity = 0.35;
constexpr double kStride = 0.8;                           ///< two steps, share of the height
constexpr double kLegSwing = 0.4;                         ///< amplitude [rad]
constexpr double kArmSwing = 0.35;                        ///< [rad]
constexpr double kHipHeight = 0.5;                        ///< shares of the height
constexpr double kShoulderHeight = 0.8;                   //
constexpr double kArmLength = 0.36;                       //
constexpr double kLegRadius = 0.07, kLegSide = 0.09;      ///< [m]
constexpr double kArmRadius = 0.045, kArmSide = 0.21;     ///< [m]
constexpr double kTorsoRadius = 0.16, kHeadRadius = 0.1;  ///< [m]
constexpr double kBeamMargin = 0.0053;                    ///< 0.3 deg [rad]

/// Down from `top`, swung forward by `angle`.
Capsule limb(const Vec3& top, const Vec3& forward, double length, double angle, double radius) {
  return {top, top + length * (std::sin(angle) * forward - std::cos(angle) * Vec3::UnitZ()), radius};
}

/// The sphere reaches to the top of the head; the farther foot is always inside: it hangs from the hip at its centre.
Vec3 centre_of(const Vec3& ground, double height) { return ground + Vec3(0, 0, kHipHeight * height); }
double sphere_of(double height) { return kHipHeight * height + 0.02; }

bool may_meet(const Vec3& to_centre, double radius, const Vec3& direction) {
  const double along = to_centre.dot(direction), square = to_centre.squaredNorm();
  return square - along * along <= radius * radius && (along >= 0 || square <= radius * radius);
}

/// Distance at which a ray enters a sphere round `-from` of its origin; negative or NaN: it does not.
double enter_sphere(const Vec3& from, const Vec3& direction, double radius) {
  const double along = from.dot(direction);
  return -along - std::sqrt(along * along - from.squaredNorm() + radius * radius);
}

struct Entry {
  double range = -1;  ///< [m]; negative or NaN: the ray does not enter
  Vec3 normal = Vec3::UnitZ();
};

/// A ray that enters a capsule does so through the cylinder's wall between the ends, else through the ball at the end
/// on whose side it enters the endless cylinder.
Entry enter(const Capsule& capsule, const Vec3& origin, const Vec3& direction) {
  const Vec3 axis = capsule.b - capsule.a, from = origin - capsule.a;
  const double length2 = axis.squaredNorm(), slope = axis.dot(direction), foot = axis.dot(from);
  // Squared distance from the axis times length2: quadratic in the range.
  const double square = length2 - slope * slope;
  const double half = length2 * from.dot(direction) - foot * slope;
  const double constant = length2 * (from.squaredNorm() - capsule.radius * capsule.radius) - foot * foot;
  const double discriminant = half * half - square * constant;
  if (discriminant < 0) return {};
  bool first_end = slope > 0;  // along the axis
  if (square > 1e-12 * length2) {
    const double range = (-half - std::sqrt(discriminant)) / square;
    const double along = foot + range * slope;
    if (along > 0 && along < length2)
      return {range, (from + range * direction - along / length2 * axis) / capsule.radius};
    first_end = along <= 0;
  }
  const Vec3 from_end = first_end ? from : Vec3(origin - capsule.b);
  const double range = enter_sphere(from_end, direction, capsule.radius);
  return {range, (from_end + range * direction) / capsule.radius};
}

}  // namespace

Body People::body(const Walker& walker, const ClosedLine::Place& place, double t) {
  const double h = walker.height;
  const Vec3 forward(place.direction.x(), place.direction.y(), 0), left(-forward.y(), forward.x(), 0);
  const Vec3 up = Vec3::UnitZ();
  const double phase = walker.step_phase + 2 * std::numbers::pi * std::abs(walker.speed) * t / (kStride * h);
  const double swing = std::sin(phase);
  Body body;
  body.centre = centre_of(place.at, h);
  body.radius = sphere_of(h);
  const Vec3 hip = body.centre, shoulder = place.at + kShoulderHeight * h * up;
  body.parts[0] = {place.at + 0.55 * h * up, place.at + 0.77 * h * up, kTorsoRadius};
  body.parts[1] = {place.at + (h - kHeadRadius - 0.06) * up, place.at + (h - kHeadRadius) * up, kHeadRadius};
  const double leg = kHipHeight * h - kLegRadius, arm = kArmLength * h;
  body.parts[2] = limb(hip + kLegSide * left, forward, leg, kLegSwing * swing, kLegRadius);
  body.parts[3] = limb(hip - kLegSide * left, forward, leg, -kLegSwing * swing, kLegRadius);
  body.parts[4] = limb(shoulder + kArmSide * left, forward, arm, -kArmSwing * swing, kArmRadius);
  body.parts[5] = limb(shoulder - kArmSide * left, forward, arm, kArmSwing * swing, kArmRadius);
  return body;
}

void People::in_view(double t, const Vec3& origin, std::span<const Vec3> directions, std::vector<Body>& out) const {
  out.clear();
  for (const Walker& walker : walkers_) {
    const ClosedLine::Place at = place(walker, t);
    const Vec3 to_centre = centre_of(at.at, walker.height) - origin;
    const double radius = sphere_of(walker.height) + kBeamMargin * to_centre.norm();
    for (const Vec3& direction : directions) {
      if (!may_meet(to_centre, radius, direction)) continue;
      out.push_back(body(walker, at, t));
      break;
    }
  }
}

void cast_people(std::span<const Body> bodies, const Vec3& origin, const Vec3& direction, SurfaceHit& hit) {
  for (const Body& body : bodies) {
    if (!may_meet(body.centre - origin, body.radius, direction)) continue;
    for (const Capsule& part : body.parts) {
      const Entry entry = enter(part, origin, direction);
      if (!(entry.range > 0 && entry.range < hit.range)) continue;
      hit.range = entry.range;
      hit.cos_incidence = std::clamp(-direction.dot(entry.normal), 0.0, 1.0);
      hit.reflectivity = kClothReflectivity;
      hit.moving = true;
    }
  }
}

}  // namespace aslio::simulator
