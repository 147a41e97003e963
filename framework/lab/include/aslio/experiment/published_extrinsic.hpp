#pragma once
/// What different sources say of one extrinsic.

#include <string>

#include "aslio/core/lie.hpp"

namespace aslio::experiment {

/// A pose of the LiDAR in the IMU frame as somebody publishes it.
struct PublishedExtrinsic {
  std::string source;  ///< who publishes it, and where
  Pose T_imu_lidar;
};

}  // namespace aslio::experiment
