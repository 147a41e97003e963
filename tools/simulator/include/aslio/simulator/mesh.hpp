#pragma once
/// Triangles that rays can hit, and the primitives from which worlds are made.

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "aslio/core/lie.hpp"

namespace aslio::simulator {

using Vec2 = Eigen::Vector2d;  ///< in the level plane [m]

/// Surfaces seen from both sides. World frame, z up [m]. Single precision: coordinates within +-1 km are good to 0.1
/// mm.
struct Mesh {
  struct Triangle {
    std::uint32_t a = 0, b = 0, c = 0;  ///< vertices
  };
  std::vector<Eigen::Vector3f> vertices;
  std::vector<Triangle> triangles;
  std::vector<std::uint8_t> reflectivity;  ///< of each triangle: 255 is a white Lambertian surface

  /// Adds the triangles of another mesh.
  void append(const Mesh& other);
};

/// Reflectivities of common surfaces (share of the light at 905 nm that comes back, times 255).
namespace material {
inline constexpr std::uint8_t kPlaster = 190, kConcrete = 110, kAsphalt = 45, kBrick = 95, kWood = 130, kMetal = 150,
                              kFoliage = 120, kGlass = 12, kPaper = 170, kCloth = 90, kBlackPaint = 15,
                              kWhitePaint = 210, kGrass = 100, kRubber = 20;
}  // namespace material

/// Rotation about the vertical through `origin`, then translation; for things that stand upright.
struct Placement {
  Vec3 origin = Vec3::Zero();  ///< [m]
  double yaw = 0;              ///< [rad]
};

/// Adds surfaces to a mesh; normals of solids point out. Every point is given in the frame of the current placement.
class MeshBuilder {
 public:
  /// Stands for the builder with another placement until it is destroyed; placements nest.
  class Placed {
   public:
    Placed(MeshBuilder& builder, const Placement& placement);
    ~Placed();
    Placed(const Placed&) = delete;
    Placed& operator=(const Placed&) = delete;

   private:
    MeshBuilder& builder_;
    Placement before_;
  };
  [[nodiscard]] Placed place(const Placement& placement) { return Placed(*this, placement); }

  void triangle(const Vec3& a, const Vec3& b, const Vec3& c, std::uint8_t reflectivity);
  /// Plane quadrilateral with its corners in order round it.
  void quad(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d, std::uint8_t reflectivity);
  /// Upright rectangle on the segment from `a` to `b` between two heights.
  void wall(const Vec2& a, const Vec2& b, double low, double high, std::uint8_t reflectivity);
  /// Level rectangle at height `z`.
  void slab(const Vec2& low, const Vec2& high, double z, std::uint8_t reflectivity);
  /// Solid with six faces.
  void box(const Vec3& low, const Vec3& high, std::uint8_t reflectivity);
  /// Upright prism with `sides` faces and the two caps; a cylinder or a cone frustum for many sides.
  void frustum(const Vec3& foot, double foot_radius, double top_radius, double height, int sides,
               std::uint8_t reflectivity);
  /// Sphere of `rings` x 2 `rings` quadrilaterals, stretched along the axes.
  void ellipsoid(const Vec3& centre, const Vec3& radii, int rings, std::uint8_t reflectivity);
  /// Polygon in the x-z plane of the placement (corners in order, each seen from the mean of all) pushed from y =
  /// `from` to y = `to`: sides and, by a fan about that mean, both ends.
  void extrude(std::span<const Vec2> profile, double from, double to, std::uint8_t reflectivity);
  /// Vertices on a regular grid over [low, high] with steps of at most `step`, at height `z(x, y)` of the placement.
  void terrain(const Vec2& low, const Vec2& high, double step, std::uint8_t reflectivity,
               const std::function<double(double, double)>& z);

  const Mesh& mesh() const { return mesh_; }
  Mesh take() { return std::move(mesh_); }

 private:
  std::uint32_t vertex(const Vec3& p);
  void face(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint8_t reflectivity);
  void set_placement(const Placement& placement);

  Mesh mesh_;
  Placement placement_;
  double cos_yaw_ = 1, sin_yaw_ = 0;
};

}  // namespace aslio::simulator
