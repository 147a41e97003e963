#include "worlds/stairs.hpp"

#include <algorithm>
#include <array>
#include <numbers>

namespace aslio::simulator::indoor {
namespace {

constexpr int kSteps = 9;                                                // of a flight
constexpr double kRise = 0.175;                                          // of a step [m]
constexpr double kTread = 0.28;                                          // [m]
constexpr double kBegin = kWall + 0.7, kEnd = kBegin + kSteps * kTread;  // of the flights [m]
constexpr double kInner = 0.15;                                          // half the gap between the flights [m]
constexpr double kLanding = kSteps * kRise;
constexpr double kHalfWidth = 0.5 * Stairwell::kWidth, kBack = kWall + Stairwell::kDepth;

/// A handrail above the noses of a flight from (y0, z0) to (y1, z1), with its posts.
void add_rail(MeshBuilder& builder, double x, double y0, double z0, double y1, double z1) {
  const auto along = builder.place({Vec3(x, 0, 0), 0.5 * std::numbers::pi});  // its x is the frame's y
  const std::array<Vec2, 4> profile{Vec2(y0, z0 + 0.9), Vec2(y1, z1 + 0.9), Vec2(y1, z1 + 0.96), Vec2(y0, z0 + 0.96)};
  builder.extrude(profile, -0.025, 0.025, material::kWood);
  constexpr int kPosts = 6;
  for (int k = 0; k <= kPosts; ++k) {
    const double u = static_cast<double>(k) / kPosts;
    builder.frustum({y0 + u * (y1 - y0), 0, z0 + u * (z1 - z0)}, 0.015, 0.015, 0.92, 6, material::kMetal);
  }
}

}  // namespace

Rect Stairwell::part(double x0, double x1, double y0, double y1) const {
  const Vec2 along(normal_.y(), -normal_.x());
  const Vec2 p = at_ + x0 * along + y0 * normal_, q = at_ + x1 * along + y1 * normal_;
  return {p.cwiseMin(q), p.cwiseMax(q)};
}

void Stairwell::add_to(FloorPlan& plan, double ceiling) const {
  constexpr double kTop = 2 * kLanding + 2.6;
  plan.add({part(-0.5 * kWidth + 0.1, 0.5 * kWidth - 0.1, 0, kWall), 0, std::min(2.3, ceiling - 0.05)});
  plan.add({part(-0.5 * kWidth, 0.5 * kWidth, kWall, kBegin), 0, kTop});
  plan.add({part(-0.5 * kWidth, kInner, kBegin, kBack), 0, kTop});
  plan.add({part(kInner, 0.5 * kWidth, kBegin, kBack), -kLanding, kTop});
}

void build_stairs(MeshBuilder& builder, Site& site, const Stairwell& stairs) {
  site.reserve(stairs.kept_free());
  const auto here = builder.place(stairs.frame());
  for (int k = 0; k < kSteps; ++k) {
    const double y = kBegin + k * kTread, z = (k + 1) * kRise;
    builder.box({-kHalfWidth, y, 0}, {-kInner, y + kTread, z}, material::kConcrete);
    const double down = -(k + 1) * kRise;
    builder.box({kInner, y, -kLanding}, {kHalfWidth, y + kTread, down}, material::kConcrete);
    const double back = kEnd - (k + 1) * kTread, up = kLanding + z;
    builder.box({kInner, back, up - 0.3}, {kHalfWidth, back + kTread, up}, material::kConcrete);
  }
  builder.box({-kHalfWidth, kEnd, kLanding - 0.2}, {kHalfWidth, kBack, kLanding}, material::kConcrete);
  builder.box({-kHalfWidth, kWall, 2 * kLanding - 0.2}, {kHalfWidth, kBegin, 2 * kLanding}, material::kConcrete);
  add_rail(builder, -kInner + 0.03, kBegin, 0, kEnd, kLanding);
  add_rail(builder, kInner + 0.03, kBegin, 2 * kLanding, kEnd, kLanding);
  add_rail(builder, kInner - 0.03, kBegin, 0, kEnd, 0);
}

}  // namespace aslio::simulator::indoor
