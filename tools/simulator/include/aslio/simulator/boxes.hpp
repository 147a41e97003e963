#pragma once

#include <array>
#include <span>
#include <vector>

#include "aslio/core/lie.hpp"

namespace aslio::simulator {

/// A solid box, turned about the vertical.
struct Box {
  Vec3 centre = Vec3::Zero();  ///< in W [m]
  Vec3 half = Vec3::Zero();    ///< half of its edges [m]
  double yaw = 0;              ///< [rad]
  double reflectivity = 0.5;   ///< in [0, 1]
};

/// Upright box between two corners.
Box box_between(const Vec3& low, const Vec3& high, double reflectivity = 0.5);

struct Hit {
  double range = 0;          ///< [m]
  double cos_incidence = 0;  ///< between the ray and the surface normal, in (0, 1]
  double reflectivity = 0;
  int solid = -1;  ///< index of the box; -1: nothing was hit
};

/// Solids seen from outside; closed-form intersection of a ray with all of them.
class BoxScene {
 public:
  explicit BoxScene(std::vector<Box> boxes);

  /// Nearest surface along the unit vector `direction` from `origin` (outside all boxes).
  Hit cast(const Vec3& origin, const Vec3& direction) const;
  /// As cast(), but `moving` boxes stand in the way too; their indices follow those of the scene.
  Hit cast(const Vec3& origin, const Vec3& direction, std::span<const Box> moving) const;
  /// Distance to the nearest surface [m]; 0 inside a solid.
  double clearance(const Vec3& p) const;
  const std::vector<Box>& boxes() const { return boxes_; }

 private:
  std::vector<Box> boxes_;
  std::array<std::vector<double>, 6> upright_;  ///< low x y z, high x y z of the boxes that are not turned
  std::vector<int> upright_index_, turned_index_;
};

}  // namespace aslio::simulator
