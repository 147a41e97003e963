#pragma once
/// When a map looks for what is out of reach.

#include <optional>

#include "aslio/core/lie.hpp"

namespace aslio {

/// Lets one pass over the map through per step of motion, so that the calls between cost nothing.
class TrimGate {
 public:
  /// Whether the centre [m] has moved by `step` [m] since this was last true; never for one that is not finite.
  bool due(const Vec3& centre_W, double step) {
    if (!centre_W.allFinite() || (last_ && (centre_W - *last_).norm() < step)) return false;
    last_ = centre_W;
    return true;
  }
  void reset() { last_.reset(); }

 private:
  std::optional<Vec3> last_;
};

}  // namespace aslio
