#pragma once
/// Decodes the CustomMsg of a Livox driver.

#include <memory>
#include <string>

#include "lidar_decoder.hpp"

namespace aslio::io {

std::unique_ptr<LidarDecoder> make_livox_decoder(const SensorConfig& sensor, std::string where);

}  // namespace aslio::io
