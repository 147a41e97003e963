#pragma once
/// Sweeps as messages of ROS1.

#include <memory>
#include <vector>

#include "aslio/io/layout_writer.hpp"
#include "aslio/io/rosbag/messages.hpp"

namespace aslio::io {

class LidarMessages {
 public:
  virtual ~LidarMessages() = default;
  virtual const rosbag::MessageType& type() const = 0;
  virtual void encode(const LidarPacket& sweep, std::uint32_t seq, std::vector<std::uint8_t>& out) = 0;
};

/// Throws ConfigError for a grid that the form does not fit.
std::unique_ptr<LidarMessages> make_lidar_messages(const LidarLayout& layout, const SweepGrid& grid);

}  // namespace aslio::io
