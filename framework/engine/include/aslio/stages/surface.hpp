#pragma once

#include "aslio/core/lie.hpp"

namespace aslio {

/// Local surface about one match.
struct Surface {
  Vec3 normal = Vec3::Zero();  ///< unit normal (plane) or direction (line), W
  Vec3 anchor = Vec3::Zero();  ///< a point on it, W
  double quality = 1.0;        ///< weight in (0, 1]
  bool valid = false;
  /// The same for all matches of one surface that the map keeps, whose error they share; nullptr where none is known
  /// to. To be compared, not to be followed.
  const void* owner = nullptr;
  /// Matches that share that error, this one included, as far as an estimator counted them; those of all windows that
  /// see the surface for a while, if it knows of them, so that this need not be a whole number.
  double shared_matches = 1.0;
};

}  // namespace aslio
