#include "worlds/street_furniture.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace aslio::simulator::outdoor {
namespace {

namespace m = material;

/// Upright wheel in the x-z plane.
void add_wheel(MeshBuilder& builder, double x, double y, double radius) {
  constexpr int kSides = 12;
  for (int k = 0; k < kSides; ++k) {
    const auto rim = [&](double r, int corner) {
      const double a = 2 * std::numbers::pi * corner / kSides;
      return Vec3(x + r * std::cos(a), y, radius + r * std::sin(a));
    };
    builder.quad(rim(radius, k), rim(radius, k + 1), rim(radius - 0.04, k + 1), rim(radius - 0.04, k), m::kRubber);
  }
}

}  // namespace

void add_lamp_post(MeshBuilder& builder, double height) {
  builder.frustum({0, 0, -0.3}, 0.11, 0.11, 1.3, 10, m::kMetal);
  builder.frustum({0, 0, 1}, 0.075, 0.045, height - 1, 10, m::kMetal);
  builder.box({-0.03, -0.03, height - 0.06}, {0.03, 0.8, height}, m::kMetal);
  builder.box({-0.13, 0.6, height - 0.1}, {0.13, 1.2, height + 0.03}, m::kMetal);
}

void add_bollard(MeshBuilder& builder) {
  builder.frustum({0, 0, -0.2}, 0.07, 0.07, 1.1, 10, m::kMetal);
  builder.frustum({0, 0, 0.7}, 0.075, 0.075, 0.12, 10, m::kWhitePaint);
}

void add_bench(MeshBuilder& builder) {
  for (const double x : {-0.7, 0.64}) {
    builder.box({x, -0.22, -0.2}, {x + 0.06, 0.22, 0.42}, m::kConcrete);
    builder.box({x, -0.27, 0.42}, {x + 0.06, -0.21, 0.86}, m::kMetal);
  }
  for (const double y : {-0.2, -0.06, 0.08}) builder.box({-0.85, y, 0.42}, {0.85, y + 0.11, 0.46}, m::kWood);
  for (const double z : {0.58, 0.73}) builder.box({-0.85, -0.21, z}, {0.85, -0.18, z + 0.11}, m::kWood);
}

void add_bin(MeshBuilder& builder) {
  builder.frustum({0, 0, -0.1}, 0.21, 0.24, 0.9, 12, m::kMetal);
  builder.frustum({0, 0, 0.8}, 0.27, 0.1, 0.12, 12, m::kBlackPaint);
}

void add_sign(MeshBuilder& builder, double width) {
  builder.frustum({0, -0.03, -0.2}, 0.03, 0.03, 2.6 + width, 8, m::kMetal);
  // Retro-reflecting film is as bright as it gets.
  builder.box({-0.5 * width, 0, 2.3}, {0.5 * width, 0.012, 2.3 + width}, 255);
}

void add_cabinet(MeshBuilder& builder, RandomStream& random) {
  const double w = random.uniform(0.3, 0.5), h = random.uniform(0.9, 1.4);
  builder.box({-w - 0.04, -0.21, -0.2}, {w + 0.04, 0.21, 0.12}, m::kConcrete);
  builder.box({-w, -0.17, 0.12}, {w, 0.17, h}, m::kPlaster);
  builder.box({-w - 0.03, -0.2, h}, {w + 0.03, 0.2, h + 0.04}, m::kPlaster);
}

void add_bicycle_rack(MeshBuilder& builder, RandomStream& random) {
  for (double y = -1.2; y < 1.3; y += 0.8) {
    for (const double x : {-0.4, 0.36}) builder.box({x, y - 0.02, -0.2}, {x + 0.04, y + 0.02, 0.8}, m::kMetal);
    builder.box({-0.4, y - 0.02, 0.78}, {0.4, y + 0.02, 0.82}, m::kMetal);
    if (random.uniform() < 0.3) continue;
    const double at = y + 0.12, shift = random.uniform(-0.1, 0.1);
    for (const double x : {-0.52, 0.52}) add_wheel(builder, x + shift, at, 0.34);
    builder.quad({shift - 0.35, at, 0.5}, {shift + 0.4, at, 0.75}, {shift + 0.4, at, 0.82}, {shift - 0.35, at, 0.57},
                 m::kMetal);
    builder.box({shift - 0.25, at - 0.05, 0.9}, {shift, at + 0.05, 0.97}, m::kBlackPaint);
    builder.box({shift + 0.4, at - 0.25, 0.98}, {shift + 0.44, at + 0.25, 1.02}, m::kMetal);
  }
}

void add_shelter(MeshBuilder& builder) {
  for (const double x : {-1.8, 1.76}) {
    for (const double y : {-0.65, 0.6}) builder.box({x, y, -0.2}, {x + 0.04, y + 0.04, 2.4}, m::kMetal);
    builder.wall({x + 0.02, -0.6}, {x + 0.02, 0.4}, 0.25, 2.1, m::kGlass);
  }
  builder.wall({-1.75, -0.63}, {1.75, -0.63}, 0.25, 2.1, m::kGlass);
  builder.box({-1.9, -0.75, 2.4}, {1.9, 0.8, 2.5}, m::kMetal);
  builder.box({-1.2, -0.55, 0.42}, {1.2, -0.2, 0.46}, m::kWood);
  for (const double x : {-1.1, 1.06}) builder.box({x, -0.4, -0.2}, {x + 0.04, -0.36, 0.42}, m::kMetal);
}

void add_fence(MeshBuilder& builder, double length, double height) {
  const int pieces = std::max(1, static_cast<int>(std::lround(length / 2)));
  for (int k = 0; k <= pieces; ++k) {
    const double x = length * k / pieces;
    builder.box({x - 0.04, -0.04, -0.4}, {x + 0.04, 0.04, height + 0.05}, m::kMetal);
  }
  for (const double z : {0.12, height - 0.06}) builder.box({0, -0.015, z}, {length, 0.015, z + 0.05}, m::kMetal);
  for (double x = 0.15; x < length; x += 0.15) builder.wall({x, 0}, {x + 0.025, 0}, 0.12, height - 0.02, m::kMetal);
}

void add_low_wall(MeshBuilder& builder, double length, double height) {
  builder.box({0, -0.12, -0.6}, {length, 0.12, height}, m::kBrick);
  builder.box({0, -0.16, height}, {length, 0.16, height + 0.06}, m::kConcrete);
}

}  // namespace aslio::simulator::outdoor
