#pragma once
/// What a ray meets first: triangles by Embree, moving people in closed form.

#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>

#include "aslio/simulator/mesh.hpp"

namespace aslio::simulator {

struct SurfaceHit {
  double range = std::numeric_limits<double>::infinity();  ///< [m]; infinite: nothing was hit
  double cos_incidence = 0;                                ///< between ray and surface normal, in [0, 1]
  double reflectivity = 0;                                 ///< in [0, 1]
  bool moving = false;                                     ///< a person
  std::uint8_t material = 0;                               ///< reflectivity of the triangle as in Mesh
  Vec3 normal = Vec3::UnitZ();                             ///< of the triangle, unit; on either side
};

/// Embree scene over a mesh. Thread-safe after construction.
class Caster {
 public:
  /// Throws ConfigError for a mesh without triangles, DataError when Embree reports an error (out of memory).
  explicit Caster(Mesh mesh);
  ~Caster();
  Caster(const Caster&) = delete;
  Caster& operator=(const Caster&) = delete;

  /// Nearest surface within `max_range` along each unit vector of `directions`, all from `origin` and at best not far
  /// apart (they are cast in packets of 8). Which triangle is hit is Embree's decision (single precision; of two that
  /// meet in an edge or lie in one plane it may be either); range and incidence are computed from its plane in double
  /// precision. Surfaces nearer than 0.1 mm are not seen. No ray slips through an edge that two triangles share, but
  /// one that passes a corner within rounding (1e-7 of the range) may.
  void cast(const Vec3& origin, std::span<const Vec3> directions, double max_range, std::span<SurfaceHit> hits) const;
  SurfaceHit cast(const Vec3& origin, const Vec3& direction, double max_range) const;

  const Mesh& mesh() const { return mesh_; }
  /// Memory of the mesh and of Embree's tree [bytes].
  std::size_t bytes() const;

 private:
  struct Impl;
  SurfaceHit resolved(std::uint32_t geometry, std::uint32_t triangle, const Vec3& origin, const Vec3& direction,
                      double max_range) const;

  Mesh mesh_;
  std::unique_ptr<Impl> impl_;
};

}  // namespace aslio::simulator
