#include "worlds/vehicles.hpp"

#include <array>
#include <cmath>
#include <numbers>

namespace aslio::simulator::outdoor {
namespace {

constexpr double kMirror = 0.18;  ///< beyond the side [m]
constexpr double kSillZ = 0.22;   ///< underside of the body [m]
constexpr double kFlank = 0.02;   ///< panes stand proud of the body behind them by this [m]

/// Upper part of a body, shares of its length from the rear: where it leaves the body and where the roof begins.
struct Cabin {
  double rear = 0.1, roof_rear = 0.2, roof_front = 0.55, front = 0.72;
  double belt = 0.62;  ///< height of the windows' lower edge, share of the height
};

Cabin cabin_of(VehicleKind kind) {
  switch (kind) {
    case VehicleKind::hatchback:
      return {0.02, 0.14, 0.55, 0.76, 0.62};
    case VehicleKind::estate:
      return {0.02, 0.1, 0.55, 0.74, 0.62};
    case VehicleKind::van:
      return {0.0, 0.02, 0.72, 0.88, 0.5};
    case VehicleKind::saloon:
      break;
  }
  return {0.14, 0.28, 0.55, 0.74, 0.63};
}

void add_wheels(MeshBuilder& builder, const Vehicle& v) {
  constexpr int kSides = 14;
  const double r = v.kind == VehicleKind::van ? 0.35 : 0.31;
  for (const double x : {-0.5 * v.length + 0.18 * v.length, 0.5 * v.length - 0.19 * v.length}) {
    const auto disc = [&](double radius, double from, double to, std::uint8_t reflectivity) {
      std::array<Vec2, kSides> rim;
      for (int k = 0; k < kSides; ++k) {
        const double a = 2 * std::numbers::pi * k / kSides;
        rim.at(static_cast<std::size_t>(k)) = Vec2(x + radius * std::cos(a), r + radius * std::sin(a));
      }
      builder.extrude(rim, from, to, reflectivity);
    };
    for (const double side : {-1.0, 1.0}) {
      const double outer = side * (0.5 * v.width + 0.01), inner = side * (0.5 * v.width - 0.2);
      disc(r, std::min(inner, outer), std::max(inner, outer), material::kRubber);
      disc(0.62 * r, std::min(outer, outer + side * 0.015), std::max(outer, outer + side * 0.015), material::kMetal);
    }
  }
}

/// Windscreen, side windows and rear window round a roof that is narrower than the body.
void add_cabin(MeshBuilder& builder, const Vehicle& v, const Cabin& c) {
  const auto x = [&](double share) { return (share - 0.5) * v.length; };
  const double belt = c.belt * v.height, roof = v.height;
  const double w0 = 0.5 * v.width - 0.03, w1 = 0.5 * v.width - (v.kind == VehicleKind::van ? 0.1 : 0.22);
  const auto body = [&](double share, double y, double z) { return Vec3(x(share), y, z); };
  const std::uint8_t flank = v.kind == VehicleKind::van ? v.paint : material::kGlass;
  for (const double s : {-1.0, 1.0})
    builder.quad(body(c.rear, s * w0, belt), body(c.front, s * w0, belt), body(c.roof_front, s * w1, roof),
                 body(c.roof_rear, s * w1, roof), flank);
  builder.quad(body(c.front, -w0, belt), body(c.front, w0, belt), body(c.roof_front, w1, roof),
               body(c.roof_front, -w1, roof), material::kGlass);
  builder.quad(body(c.rear, w0, belt), body(c.rear, -w0, belt), body(c.roof_rear, -w1, roof),
               body(c.roof_rear, w1, roof), v.kind == VehicleKind::van ? v.paint : material::kGlass);
  builder.quad(body(c.roof_rear, -w1, roof), body(c.roof_front, -w1, roof), body(c.roof_front, w1, roof),
               body(c.roof_rear, w1, roof), v.paint);
  // Pillars between the doors; the front window of a van.
  const auto on_flank = [&](double s, double share, double up) {
    const double y = w0 + up * (w1 - w0) + kFlank;
    return Vec3(x(share), s * y, belt + up * (roof - belt));
  };
  for (const double s : {-1.0, 1.0}) {
    if (v.kind == VehicleKind::van) {
      builder.quad(on_flank(s, 0.6, 0.15), on_flank(s, 0.82, 0.15), on_flank(s, 0.74, 0.85), on_flank(s, 0.6, 0.85),
                   material::kGlass);
      continue;
    }
    const double middle = 0.5 * (c.roof_rear + c.roof_front) + 0.02;
    for (const double share : {middle, c.roof_rear + 0.04})
      builder.quad(on_flank(s, share - 0.012, 0), on_flank(s, share + 0.012, 0), on_flank(s, share + 0.012, 1),
                   on_flank(s, share - 0.012, 1), v.paint);
  }
}

}  // namespace

Vehicle draw_vehicle(RandomStream& random) {
  const double kind = random.uniform(), size = random.uniform(-1, 1), colour = random.uniform();
  constexpr std::array<std::uint8_t, 6> kPaints = {material::kBlackPaint, 40, 70, 110, 160, material::kWhitePaint};
  const std::uint8_t paint = kPaints.at(static_cast<std::size_t>(colour * static_cast<double>(kPaints.size())));
  if (kind < 0.4) return {VehicleKind::hatchback, 3.95 + 0.25 * size, 1.75 + 0.05 * size, 1.48 + 0.05 * size, paint};
  if (kind < 0.65) return {VehicleKind::saloon, 4.6 + 0.25 * size, 1.82 + 0.05 * size, 1.44 + 0.03 * size, paint};
  if (kind < 0.9) return {VehicleKind::estate, 4.55 + 0.25 * size, 1.82 + 0.05 * size, 1.5 + 0.12 * size, paint};
  return {VehicleKind::van, 4.9 + 0.3 * size, 1.93 + 0.05 * size, 1.98 + 0.12 * size, paint};
}

void add_vehicle(MeshBuilder& builder, const Vehicle& v) {
  const Cabin c = cabin_of(v.kind);
  const double l = 0.5 * v.length, w = 0.5 * v.width, belt = c.belt * v.height;
  const double bonnet = v.kind == VehicleKind::van ? belt : belt - 0.12;
  const double boot = v.kind == VehicleKind::saloon ? belt + 0.02 : belt;
  const std::array<Vec2, 9> profile = {Vec2(-l + 0.1, kSillZ),
                                       Vec2(l - 0.12, kSillZ),
                                       Vec2(l, 0.34),
                                       Vec2(l - 0.02, 0.55),
                                       Vec2(l - 0.12, bonnet),
                                       Vec2((c.front - 0.5) * v.length, belt),
                                       Vec2((c.rear - 0.5) * v.length, boot),
                                       Vec2(-l + 0.03, boot - 0.04),
                                       Vec2(-l, 0.45)};
  builder.extrude(profile, -w, w, v.paint);
  add_cabin(builder, v, c);
  add_wheels(builder, v);
  for (const double s : {-1.0, 1.0}) {
    const double x = (c.front - 0.5) * v.length - 0.12, inner = s * (w - 0.03), outer = s * (w + kMirror);
    builder.box({x - 0.05, std::min(inner, outer), belt}, {x + 0.05, std::max(inner, outer), belt + 0.13}, v.paint);
    const double y0 = s > 0 ? w - 0.45 : -w + 0.08, y1 = s > 0 ? w - 0.08 : -w + 0.45;
    builder.box({l - 0.06, y0, 0.5}, {l + 0.005, y1, 0.62}, material::kGlass);    // head lamps
    builder.box({-l - 0.01, y0, 0.6}, {-l + 0.05, y1, 0.76}, material::kRubber);  // tail lamps
  }
  for (const double s : {-1.0, 1.0}) {
    const double end = s * (l + 0.012);
    builder.box({std::min(end, end - s * 0.03), -0.26, 0.36}, {std::max(end, end - s * 0.03), 0.26, 0.47}, 250);
  }
}

Footprint footprint(const Vehicle& v, const Placement& placement) {
  const Vec2 half(0.5 * v.length + 0.05, 0.5 * v.width + kMirror + 0.02);
  return footprint(placement, -half, half);
}

}  // namespace aslio::simulator::outdoor
