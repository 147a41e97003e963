#include "worlds/wood.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "worlds/curved.hpp"

namespace aslio::simulator::outdoor {
namespace {

using curved::Ring;

constexpr double kTurn = 2 * std::numbers::pi;
constexpr double kLowestLeaf = 2.6;  // [m]

Vec3 unit_vector(RandomStream& random) {
  const double z = random.uniform(-1, 1), angle = random.uniform(0, kTurn), r = std::sqrt(1 - z * z);
  return {r * std::cos(angle), r * std::sin(angle), z};
}

/// One triangle in any direction.
void add_leaf(MeshBuilder& builder, RandomStream& random, const Vec3& at, double size) {
  const Vec3 normal = unit_vector(random), u = normal.unitOrthogonal(), v = normal.cross(u);
  const double s = size * random.uniform(0.7, 1.3);
  builder.triangle(at + s * u, at - 0.5 * s * u + 0.8 * s * v, at - 0.5 * s * u - 0.8 * s * v,
                   static_cast<std::uint8_t>(material::kFoliage + random.uniform(-30, 30)));
}

/// Middle line of a trunk.
Vec3 stem(const Tree& tree, double z) {
  const double u = z / tree.height;
  const Vec2 p = z * tree.lean + u * u * tree.curve;
  return {p.x(), p.y(), z};
}

void add_trunk(MeshBuilder& builder, const Tree& tree, int sides) {
  const double r = tree.radius, h = tree.height;
  std::vector<Ring> rings{{stem(tree, -0.4), 1.6 * r}, {stem(tree, 0.05), 1.45 * r}, {stem(tree, 0.4), 1.12 * r}};
  for (const double u : {0.15, 0.4, 0.65, 0.92})
    rings.push_back({stem(tree, std::max(u * h, 0.5)), r * (1.02 - 0.85 * u)});
  curved::add_bar(builder, rings, sides, material::kWood);
}

void add_branch(MeshBuilder& builder, const Vec3& from, const Vec3& to, double thick) {
  const std::array<Ring, 2> rings{Ring{from, thick}, Ring{to, 0.3 * thick}};
  curved::add_bar(builder, rings, 4, material::kWood);
}

/// Whorls that shrink to the top, dead branches below.
void add_conifer_crown(MeshBuilder& builder, RandomStream& random, const Tree& tree) {
  const double low = std::max(kLowestLeaf + 0.6, 0.3 * tree.height), widest = 0.15 * tree.height;
  for (double z = 1.2; z < 0.95 * tree.height; z += random.uniform(0.9, 1.3)) {
    const bool dead = z < low;
    const double reach = dead ? random.uniform(0.2, 0.5) : widest * (1.08 - z / tree.height);
    const double turn = random.uniform(0, kTurn);
    const int arms = dead ? 2 : 3;
    for (int k = 0; k < arms; ++k) {
      const double angle = turn + kTurn * k / arms, droop = random.uniform(0, 0.35);
      const Vec3 from = stem(tree, z), out(std::cos(angle), std::sin(angle), -droop);
      if (dead && z < 2.5 && reach > 0.35) continue;
      add_branch(builder, from, from + reach * out, dead ? 0.012 : 0.025);
      if (dead) continue;
      for (int leaf = 0; leaf < 7; ++leaf) {
        const Vec3 at = from + reach * random.uniform(0.2, 1.05) * out + 0.16 * unit_vector(random);
        add_leaf(builder, random, {at.x(), at.y(), std::max(at.z(), kLowestLeaf)}, 0.2);
      }
    }
  }
}

void add_broad_crown(MeshBuilder& builder, RandomStream& random, const Tree& tree) {
  const int arms = 6 + static_cast<int>(random.uniform(0, 4));
  for (int k = 0; k < arms; ++k) {
    const double z = tree.height * random.uniform(0.4, 0.9), angle = random.uniform(0, kTurn);
    const double reach = tree.height * random.uniform(0.1, 0.22);
    const Vec3 from = stem(tree, z), to = from + reach * Vec3(std::cos(angle), std::sin(angle), 0.55);
    add_branch(builder, from, to, 0.3 * tree.radius);
    const double size = tree.height * random.uniform(0.08, 0.13);
    for (int leaf = 0; leaf < 26; ++leaf) {
      const Vec3 at = to + std::cbrt(random.uniform()) * size * unit_vector(random);
      add_leaf(builder, random, {at.x(), at.y(), std::max(at.z(), kLowestLeaf)}, 0.17);
    }
  }
}

}  // namespace

Tree draw_tree(RandomStream& random, double lean) {
  Tree tree;
  tree.conifer = random.uniform() < 0.5;
  tree.height = random.uniform(9, 19);
  tree.radius = 0.009 * tree.height * random.uniform(0.8, 1.9);
  const double to = random.uniform(0, kTurn), by = std::tan(random.uniform(0, lean));
  tree.lean = Vec2(by * std::cos(to), by * std::sin(to));
  const double turn = random.uniform(0, kTurn), bend = random.uniform(0, 0.04 * tree.height);
  tree.curve = Vec2(bend * std::cos(turn), bend * std::sin(turn));
  return tree;
}

void add_tree(MeshBuilder& builder, RandomStream& random, const Tree& tree, int sides) {
  add_trunk(builder, tree, sides);
  if (tree.conifer)
    add_conifer_crown(builder, random, tree);
  else
    add_broad_crown(builder, random, tree);
}

void add_leafy_bush(MeshBuilder& builder, RandomStream& random, double radius, double height) {
  const int stems = 4 + static_cast<int>(random.uniform(0, 4));
  for (int k = 0; k < stems; ++k) {
    const double angle = random.uniform(0, kTurn), out = radius * random.uniform(0.3, 0.75);
    const Vec3 top(out * std::cos(angle), out * std::sin(angle), height * random.uniform(0.6, 0.9));
    add_branch(builder, {0, 0, -0.1}, top, 0.015);
  }
  const int leaves = static_cast<int>(60 + 70 * radius);
  for (int k = 0; k < leaves; ++k) {
    const Vec3 in = std::cbrt(random.uniform(0.05, 1)) * unit_vector(random);
    const double reach = radius - 0.12;
    add_leaf(builder, random, {reach * in.x(), reach * in.y(), height * (0.55 + 0.45 * in.z())}, 0.09);
  }
}

void add_fern(MeshBuilder& builder, RandomStream& random, double radius) {
  const int fronds = 6 + static_cast<int>(random.uniform(0, 5));
  for (int k = 0; k < fronds; ++k) {
    const double angle = random.uniform(0, kTurn), up = radius * random.uniform(0.4, 1.1);
    const Vec3 out(std::cos(angle), std::sin(angle), 0), across(-out.y(), out.x(), 0);
    const Vec3 knee = 0.55 * radius * out + Vec3(0, 0, up), tip = radius * out + Vec3(0, 0, 0.7 * up);
    builder.triangle({0, 0, 0}, knee + 0.07 * across, knee - 0.07 * across, material::kFoliage);
    builder.triangle(tip, knee + 0.07 * across, knee - 0.07 * across, material::kFoliage);
  }
}

void add_rock(MeshBuilder& builder, const Vec3& radii) {
  builder.ellipsoid({0, 0, 0.2 * radii.z()}, radii, 12, material::kConcrete);
}

}  // namespace aslio::simulator::outdoor
