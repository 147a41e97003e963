#pragma once
/// Finds steps of the gyro's bias (docs/equations.md MOT-13).

#include "aslio/stages/estimator.hpp"

namespace aslio::pipeline {

/// A filter that is sure of a bias follows a step of it for minutes. Then the points turn every prediction back by the
/// same rate, which is seen here. Deterministic; no allocation.
class BiasWatch {
 public:
  void begin() { *this = BiasWatch(); }
  /// Takes an update. How far the bias may be off now, one standard deviation per axis [rad/s]; 0: nothing is known
  /// against it.
  double observe(const Window& window, const Update& update);

 private:
  Vec3 now_ = Vec3::Zero();  ///< mean rate by which the points turn predictions, in I [rad/s]
  double usual_ = 0;         ///< mean square of now_ as it is usually
  double seen_ = 0;          ///< time of updates that count [s]
  double steps_for_ = 0;     ///< [s] beyond the limits without a break
};

}  // namespace aslio::pipeline
