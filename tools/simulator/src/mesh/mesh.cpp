#include "aslio/simulator/mesh.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace aslio::simulator {

void Mesh::append(const Mesh& other) {
  const auto first = static_cast<std::uint32_t>(vertices.size());
  vertices.insert(vertices.end(), other.vertices.begin(), other.vertices.end());
  for (const Triangle& t : other.triangles) triangles.push_back({t.a + first, t.b + first, t.c + first});
  reflectivity.insert(reflectivity.end(), other.reflectivity.begin(), other.reflectivity.end());
}

MeshBuilder::Placed::Placed(MeshBuilder& builder, const Placement& placement)
    : builder_(builder), before_(builder.placement_) {
  const Placement outer = before_;
  const double c = std::cos(outer.yaw), s = std::sin(outer.yaw);
  const Vec3& o = placement.origin;
  builder_.set_placement(
      {outer.origin + Vec3(c * o.x() - s * o.y(), s * o.x() + c * o.y(), o.z()), outer.yaw + placement.yaw});
}

MeshBuilder::Placed::~Placed() { builder_.set_placement(before_); }

void MeshBuilder::set_placement(const Placement& placement) {
  placement_ = placement;
  cos_yaw_ = std::cos(placement.yaw);
  sin_yaw_ = std::sin(placement.yaw);
}

std::uint32_t MeshBuilder::vertex(const Vec3& p) {
  const Vec3 turned(cos_yaw_ * p.x() - sin_yaw_ * p.y(), sin_yaw_ * p.x() + cos_yaw_ * p.y(), p.z());
  mesh_.vertices.push_back((placement_.origin + turned).cast<float>());
  return static_cast<std::uint32_t>(mesh_.vertices.size() - 1);
}

void MeshBuilder::face(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint8_t reflectivity) {
  mesh_.triangles.push_back({a, b, c});
  mesh_.reflectivity.push_back(reflectivity);
}

void MeshBuilder::triangle(const Vec3& a, const Vec3& b, const Vec3& c, std::uint8_t reflectivity) {
  const std::uint32_t i = vertex(a), j = vertex(b), k = vertex(c);
  face(i, j, k, reflectivity);
}

void MeshBuilder::quad(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d, std::uint8_t reflectivity) {
  const std::uint32_t i = vertex(a), j = vertex(b), k = vertex(c), l = vertex(d);
  face(i, j, k, reflectivity);
  face(i, k, l, reflectivity);
}

void MeshBuilder::wall(const Vec2& a, const Vec2& b, double low, double high, std::uint8_t reflectivity) {
  quad({a.x(), a.y(), low}, {b.x(), b.y(), low}, {b.x(), b.y(), high}, {a.x(), a.y(), high}, reflectivity);
}

void MeshBuilder::slab(const Vec2& low, const Vec2& high, double z, std::uint8_t reflectivity) {
  quad({low.x(), low.y(), z}, {high.x(), low.y(), z}, {high.x(), high.y(), z}, {low.x(), high.y(), z}, reflectivity);
}

void MeshBuilder::box(const Vec3& low, const Vec3& high, std::uint8_t reflectivity) {
  const Vec2 a(low.x(), low.y()), b(high.x(), low.y()), c(high.x(), high.y()), d(low.x(), high.y());
  wall(a, b, low.z(), high.z(), reflectivity);
  wall(b, c, low.z(), high.z(), reflectivity);
  wall(c, d, low.z(), high.z(), reflectivity);
  wall(d, a, low.z(), high.z(), reflectivity);
  const auto at = [&](const Vec2& p) { return Vec3(p.x(), p.y(), low.z()); };
  quad(at(a), at(d), at(c), at(b), reflectivity);
  slab(a, c, high.z(), reflectivity);
}

void MeshBuilder::frustum(const Vec3& foot, double foot_radius, double top_radius, double height, int sides,
                          std::uint8_t reflectivity) {
  const Vec3 top = foot + Vec3(0, 0, height);
  const auto rim = [&](const Vec3& centre, double radius, int k) -> Vec3 {
    const double angle = 2 * std::numbers::pi * (k % sides) / sides;
    return centre + radius * Vec3(std::cos(angle), std::sin(angle), 0);
  };
  for (int k = 0; k < sides; ++k) {
    const Vec3 a = rim(foot, foot_radius, k), b = rim(foot, foot_radius, k + 1);
    const Vec3 c = rim(top, top_radius, k + 1), d = rim(top, top_radius, k);
    quad(a, b, c, d, reflectivity);
    triangle(foot, b, a, reflectivity);
    triangle(top, d, c, reflectivity);
  }
}

void MeshBuilder::ellipsoid(const Vec3& centre, const Vec3& radii, int rings, std::uint8_t reflectivity) {
  const int around = 2 * rings;
  const auto at = [&](int ring, int k) -> Vec3 {
    const double polar = std::numbers::pi * ring / rings;
    const double angle = 2 * std::numbers::pi * (k % around) / around;
    const Vec3 unit(std::sin(polar) * std::cos(angle), std::sin(polar) * std::sin(angle), std::cos(polar));
    return centre + radii.cwiseProduct(unit);
  };
  for (int ring = 0; ring < rings; ++ring) {
    for (int k = 0; k < around; ++k) {
      if (ring == 0) {
        triangle(at(0, 0), at(1, k), at(1, k + 1), reflectivity);
      } else if (ring == rings - 1) {
        triangle(at(ring, k), at(rings, 0), at(ring, k + 1), reflectivity);
      } else {
        quad(at(ring, k), at(ring + 1, k), at(ring + 1, k + 1), at(ring, k + 1), reflectivity);
      }
    }
  }
}

void MeshBuilder::extrude(std::span<const Vec2> profile, double from, double to, std::uint8_t reflectivity) {
  Vec2 centroid = Vec2::Zero();
  for (const Vec2& p : profile) centroid += p / static_cast<double>(profile.size());
  const auto at = [](const Vec2& p, double y) { return Vec3(p.x(), y, p.y()); };
  for (std::size_t k = 0; k < profile.size(); ++k) {
    const Vec2 &p = profile[k], &q = profile[(k + 1) % profile.size()];
    quad(at(p, from), at(q, from), at(q, to), at(p, to), reflectivity);
    triangle(at(centroid, from), at(q, from), at(p, from), reflectivity);
    triangle(at(centroid, to), at(p, to), at(q, to), reflectivity);
  }
}

void MeshBuilder::terrain(const Vec2& low, const Vec2& high, double step, std::uint8_t reflectivity,
                          const std::function<double(double, double)>& z) {
  const auto cells = [&](double extent) { return std::max(1, static_cast<int>(std::ceil(extent / step - 1e-9))); };
  const int nx = cells(high.x() - low.x()), ny = cells(high.y() - low.y());
  const auto first = static_cast<std::uint32_t>(mesh_.vertices.size());
  for (int j = 0; j <= ny; ++j) {
    for (int i = 0; i <= nx; ++i) {
      const double x = low.x() + (high.x() - low.x()) * i / nx, y = low.y() + (high.y() - low.y()) * j / ny;
      vertex({x, y, z(x, y)});
    }
  }
  const auto index = [&](int i, int j) { return first + static_cast<std::uint32_t>(j * (nx + 1) + i); };
  for (int j = 0; j < ny; ++j) {
    for (int i = 0; i < nx; ++i) {
      face(index(i, j), index(i + 1, j), index(i + 1, j + 1), reflectivity);
      face(index(i, j), index(i + 1, j + 1), index(i, j + 1), reflectivity);
    }
  }
}

}  // namespace aslio::simulator
