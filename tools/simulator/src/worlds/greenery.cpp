#include "worlds/greenery.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace aslio::simulator::outdoor {
namespace {

constexpr double kTurn = 2 * std::numbers::pi;
constexpr double kLeaves = 0.2;  ///< across one quadrilateral, which stands for a twig with its leaves [m]

Vec3 unit_vector(RandomStream& random) {
  const double z = random.uniform(-1, 1), angle = random.uniform(0, kTurn), r = std::sqrt(1 - z * z);
  return {r * std::cos(angle), r * std::sin(angle), z};
}

void add_leaf(MeshBuilder& builder, RandomStream& random, const Vec3& at) {
  const Vec3 normal = unit_vector(random);
  const Vec3 u = normal.unitOrthogonal(), v = normal.cross(u);
  const double size = 0.5 * kLeaves * random.uniform(0.7, 1.3);
  builder.quad(at - size * u, at - size * v, at + size * u, at + size * v,
               static_cast<std::uint8_t>(material::kFoliage + random.uniform(-30, 30)));
}

/// Leaves in an ellipsoid, denser towards its surface.
void add_foliage(MeshBuilder& builder, RandomStream& random, const Vec3& centre, const Vec3& radii, int leaves) {
  for (int k = 0; k < leaves; ++k) {
    const Vec3 direction = unit_vector(random);
    add_leaf(builder, random, centre + std::sqrt(random.uniform(0.15, 1)) * radii.cwiseProduct(direction));
  }
}

/// Tapered branch with four sides.
void add_branch(MeshBuilder& builder, const Vec3& from, const Vec3& to, double thick, double thin) {
  const Vec3 axis = (to - from).normalized(), u = axis.unitOrthogonal(), v = axis.cross(u);
  const auto rim = [&](const Vec3& centre, double radius, int k) -> Vec3 {
    const double angle = kTurn * k / 4;
    return centre + radius * (std::cos(angle) * u + std::sin(angle) * v);
  };
  for (int k = 0; k < 4; ++k)
    builder.quad(rim(from, thick, k), rim(from, thick, k + 1), rim(to, thin, k + 1), rim(to, thin, k), material::kWood);
}

}  // namespace

void add_tree(MeshBuilder& builder, RandomStream& random, double height) {
  const double radius = 0.018 * height + random.uniform(0.02, 0.08), fork = height * random.uniform(0.3, 0.4);
  builder.frustum({0, 0, -0.3}, 1.25 * radius, 0.8 * radius, fork + 0.3, 9, material::kWood);
  const int branches = 5 + static_cast<int>(random.uniform(0, 3));
  const double turn = random.uniform(0, kTurn);
  for (int k = 0; k < branches; ++k) {
    const double angle = turn + kTurn * k / branches + random.uniform(-0.3, 0.3),
                 spread = height * random.uniform(0.12, 0.22);
    const Vec3 from(0, 0, fork - 0.1),
        to(spread * std::cos(angle), spread * std::sin(angle), height * random.uniform(0.5, 0.8));
    add_branch(builder, from, to, 0.5 * radius, 0.2 * radius);
    const double size = height * random.uniform(0.13, 0.19);
    add_foliage(builder, random, to, {size, size, 0.85 * size}, 80);
  }
  const Vec3 top(0, 0, 0.84 * height);
  add_branch(builder, {0, 0, fork - 0.1}, top, 0.7 * radius, 0.2 * radius);
  add_foliage(builder, random, top, {0.18 * height, 0.18 * height, 0.16 * height}, 100);
}

void add_bush(MeshBuilder& builder, RandomStream& random, double radius, double height) {
  builder.ellipsoid({0, 0, 0.4 * height}, {0.7 * radius, 0.7 * radius, 0.45 * height}, 5, material::kFoliage);
  add_foliage(builder, random, {0, 0, 0.5 * height}, {radius - 0.1, radius - 0.1, 0.5 * height}, 50);
}

void add_hedge(MeshBuilder& builder, RandomStream& random, double length, double width, double height) {
  const int pieces = std::max(1, static_cast<int>(std::lround(length / 0.5)));
  const double step = length / pieces;
  for (int k = 0; k < pieces; ++k) {
    const double w = 0.5 * width * random.uniform(0.75, 0.9), h = height * random.uniform(0.85, 0.95);
    builder.box({k * step, -w, -0.4}, {(k + 1) * step, w, h}, material::kFoliage);
    for (int leaf = 0; leaf < 9; ++leaf) {
      const double side = random.uniform(), x = (k + random.uniform()) * step;
      const double across = random.uniform(-w, w), up = random.uniform(0.1, h);
      const Vec3 at = side < 0.35 ? Vec3(x, w, up) : side < 0.7 ? Vec3(x, -w, up) : Vec3(x, across, h);
      add_leaf(builder, random, at);
    }
  }
}

}  // namespace aslio::simulator::outdoor
