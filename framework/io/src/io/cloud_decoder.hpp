#pragma once
/// Decodes PointCloud2.

#include <memory>
#include <string>

#include "lidar_decoder.hpp"

namespace aslio::io {

/// `imu_time`: of the IMU where the recording begins, if it is known.
std::unique_ptr<LidarDecoder> make_cloud_decoder(const SensorConfig& sensor, std::string where,
                                                 std::optional<TimeNs> imu_time);

}  // namespace aslio::io
