#pragma once

#include "aslio/core/lie.hpp"

namespace aslio {

/// Local surface about one match.
struct Surface {
  Vec3 normal = Vec3::Zero();  ///< unit normal (plane) or direction (line), W
  Vec3 anchor = Vec3::Zero();  ///< a point on it, W
  double quality = 1.0;        ///< weight in (0, 1]
  bool valid = false;
};

}  // namespace aslio
