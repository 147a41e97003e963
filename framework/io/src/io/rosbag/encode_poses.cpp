// Poses, and raw packets.
#include <Eigen/Geometry>
#include <array>

#include "aslio/io/rosbag/messages.hpp"
#include "format.hpp"

namespace aslio::io::rosbag {
namespace {

constexpr std::string_view kPoseText = R"(std_msgs/Header header
geometry_msgs/Pose pose
================================================================================
MSG: std_msgs/Header
uint32 seq
time stamp
string frame_id
================================================================================
MSG: geometry_msgs/Pose
geometry_msgs/Point position
geometry_msgs/Quaternion orientation
================================================================================
MSG: geometry_msgs/Point
float64 x
float64 y
float64 z
================================================================================
MSG: geometry_msgs/Quaternion
float64 x
float64 y
float64 z
float64 w
)";

constexpr std::string_view kPointText = R"(std_msgs/Header header
geometry_msgs/Point point
================================================================================
MSG: std_msgs/Header
uint32 seq
time stamp
string frame_id
================================================================================
MSG: geometry_msgs/Point
float64 x
float64 y
float64 z
)";

constexpr std::string_view kScanText = R"(std_msgs/Header header
velodyne_msgs/VelodynePacket[] packets
================================================================================
MSG: std_msgs/Header
uint32 seq
time stamp
string frame_id
================================================================================
MSG: velodyne_msgs/VelodynePacket
time stamp
uint8[1206] data
)";

void append_position(std::vector<std::uint8_t>& out, const Vec3& p) {
  append(out, std::array<double, 3>{p.x(), p.y(), p.z()});
}

}  // namespace

const MessageType kPoseStamped{"geometry_msgs/PoseStamped", "d3812c3cbc69362b77dc0b19b345f8f5", kPoseText};
const MessageType kPointStamped{"geometry_msgs/PointStamped", "c63aecb41bfdfd6b7e1fac37c7cbe7bf", kPointText};
const MessageType kVelodyneScan{"velodyne_msgs/VelodyneScan", "50804fc9533a0e579e6322c04ae70566", kScanText};

void encode_pose(const HeaderFields& header, const Pose& pose, std::vector<std::uint8_t>& out) {
  append_header(out, header);
  append_position(out, pose.p);
  const Eigen::Quaterniond q(pose.R);
  append(out, std::array<double, 4>{q.x(), q.y(), q.z(), q.w()});
}

void encode_point(const HeaderFields& header, const Vec3& position, std::vector<std::uint8_t>& out) {
  append_header(out, header);
  append_position(out, position);
}

void encode_velodyne_scan(const HeaderFields& header, std::span<const VelodynePacketFields> packets,
                          std::vector<std::uint8_t>& out) {
  append_header(out, header);
  append(out, static_cast<std::uint32_t>(packets.size()));
  for (const VelodynePacketFields& packet : packets) {
    append_time(out, packet.stamp);
    append(out, packet.data);
  }
}

}  // namespace aslio::io::rosbag
