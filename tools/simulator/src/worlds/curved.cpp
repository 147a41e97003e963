#include "worlds/curved.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace aslio::simulator::curved {
namespace {

constexpr double kPi = std::numbers::pi;

/// Largest angle of a chord [rad].
double chord_angle(double radius) { return 2 * std::acos(std::max(0.0, 1 - kChordError / radius)); }

}  // namespace

int sides_of(double radius, int least) {
  return std::max(least, static_cast<int>(std::ceil(2 * kPi / chord_angle(radius))));
}

std::vector<Vec2> arc(const Vec2& centre, double radius, double from, double to) {
  const int pieces = std::max(1, static_cast<int>(std::ceil(std::abs(to - from) / chord_angle(radius))));
  std::vector<Vec2> points;
  for (int k = 0; k <= pieces; ++k) {
    const double angle = from + (to - from) * k / pieces;
    points.emplace_back(centre.x() + radius * std::cos(angle), centre.y() + radius * std::sin(angle));
  }
  return points;
}

void sweep(MeshBuilder& builder, std::span<const Vec2> profile, std::span<const Station> stations,
           std::uint8_t reflectivity) {
  const auto at = [](const Station& s, const Vec2& p) {
    return Vec3(s.at.x() - p.x() * s.along.y(), s.at.y() + p.x() * s.along.x(), s.at.z() + p.y());
  };
  for (std::size_t s = 1; s < stations.size(); ++s) {
    const Station &a = stations[s - 1], &b = stations[s];
    for (std::size_t k = 1; k < profile.size(); ++k)
      builder.quad(at(a, profile[k - 1]), at(b, profile[k - 1]), at(b, profile[k]), at(a, profile[k]), reflectivity);
  }
}

void add_column(MeshBuilder& builder, const Vec3& foot, double foot_radius, double top_radius, double height,
                std::uint8_t reflectivity, int least) {
  builder.frustum(foot, foot_radius, top_radius, height, sides_of(std::max(foot_radius, top_radius), least),
                  reflectivity);
}

void add_bar(MeshBuilder& builder, std::span<const Ring> rings, int sides, std::uint8_t reflectivity) {
  // One pair of vectors across the whole bar, so that its faces do not twist.
  const Vec3 axis = (rings.back().at - rings.front().at).normalized(), u = axis.unitOrthogonal(), v = axis.cross(u);
  const auto rim = [&](const Ring& ring, int k) -> Vec3 {
    const double angle = 2 * kPi * (k % sides) / sides;
    return ring.at + ring.radius * (std::cos(angle) * u + std::sin(angle) * v);
  };
  for (int k = 0; k < sides; ++k) {
    for (std::size_t r = 1; r < rings.size(); ++r)
      builder.quad(rim(rings[r - 1], k), rim(rings[r - 1], k + 1), rim(rings[r], k + 1), rim(rings[r], k),
                   reflectivity);
    builder.triangle(rings.front().at, rim(rings.front(), k + 1), rim(rings.front(), k), reflectivity);
    builder.triangle(rings.back().at, rim(rings.back(), k), rim(rings.back(), k + 1), reflectivity);
  }
}

void add_bar(MeshBuilder& builder, const Vec3& from, const Vec3& to, double radius, std::uint8_t reflectivity) {
  const std::array<Ring, 2> rings{Ring{from, radius}, Ring{to, radius}};
  add_bar(builder, rings, sides_of(radius, 8), reflectivity);
}

}  // namespace aslio::simulator::curved
