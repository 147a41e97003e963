#include <array>

#include "aslio/io/rosbag/messages.hpp"
#include "format.hpp"

namespace aslio::io::rosbag {
namespace {

// Definitions travel inside the bag, so that other tools can read it; comments do not count for the checksum.
constexpr std::string_view kLivoxText = R"(std_msgs/Header header
uint64 timebase
uint32 point_num
uint8 lidar_id
uint8[3] rsvd
CustomPoint[] points
================================================================================
MSG: std_msgs/Header
uint32 seq
time stamp
string frame_id
================================================================================
MSG: livox_ros_driver/CustomPoint
uint32 offset_time
float32 x
float32 y
float32 z
uint8 reflectivity
uint8 tag
uint8 line
)";

constexpr std::string_view kLivox2Text = R"(std_msgs/Header header
uint64 timebase
uint32 point_num
uint8 lidar_id
uint8[3] rsvd
CustomPoint[] points
================================================================================
MSG: std_msgs/Header
uint32 seq
time stamp
string frame_id
================================================================================
MSG: livox_ros_driver2/CustomPoint
uint32 offset_time
float32 x
float32 y
float32 z
uint8 reflectivity
uint8 tag
uint8 line
)";

constexpr std::string_view kImuText = R"(std_msgs/Header header
geometry_msgs/Quaternion orientation
float64[9] orientation_covariance
geometry_msgs/Vector3 angular_velocity
float64[9] angular_velocity_covariance
geometry_msgs/Vector3 linear_acceleration
float64[9] linear_acceleration_covariance
================================================================================
MSG: std_msgs/Header
uint32 seq
time stamp
string frame_id
================================================================================
MSG: geometry_msgs/Quaternion
float64 x
float64 y
float64 z
float64 w
================================================================================
MSG: geometry_msgs/Vector3
float64 x
float64 y
float64 z
)";

constexpr std::string_view kCloudText = R"(std_msgs/Header header
uint32 height
uint32 width
sensor_msgs/PointField[] fields
bool is_bigendian
uint32 point_step
uint32 row_step
uint8[] data
bool is_dense
================================================================================
MSG: std_msgs/Header
uint32 seq
time stamp
string frame_id
================================================================================
MSG: sensor_msgs/PointField
uint8 INT8=1
uint8 UINT8=2
uint8 INT16=3
uint8 UINT16=4
uint8 INT32=5
uint8 UINT32=6
uint8 FLOAT32=7
uint8 FLOAT64=8
string name
uint32 offset
uint8 datatype
uint32 count
)";

void append_vector(std::vector<std::uint8_t>& out, const Vec3& v) {
  for (int i = 0; i < 3; ++i) append(out, v[i]);
}

}  // namespace

void append_header(std::vector<std::uint8_t>& out, const HeaderFields& header) {
  out.clear();
  append(out, header.seq);
  append_time(out, header.stamp);
  append_string(out, header.frame_id);
}

const MessageType kLivoxCustomMsg{"livox_ros_driver/CustomMsg", "e4d6829bdfe657cb6c21a746c86b21a6", kLivoxText};
const MessageType kLivox2CustomMsg{"livox_ros_driver2/CustomMsg", "e4d6829bdfe657cb6c21a746c86b21a6", kLivox2Text};
const MessageType kImu{"sensor_msgs/Imu", "6a62c6daae103f4ff57a132d6f95cec2", kImuText};
const MessageType kPointCloud2{"sensor_msgs/PointCloud2", "1158d486dd51d683ce2f1be655c3c181", kCloudText};

void encode_livox(const HeaderFields& header, TimeNs timebase, std::uint8_t lidar_id,
                  std::span<const LivoxPoint> points, std::vector<std::uint8_t>& out) {
  constexpr std::size_t kPointBytes = 19;
  append_header(out, header);
  append(out, static_cast<std::uint64_t>(timebase));
  append(out, static_cast<std::uint32_t>(points.size()));
  append(out, std::array<std::uint8_t, 4>{lidar_id, 0, 0, 0});
  append(out, static_cast<std::uint32_t>(points.size()));
  std::size_t at = out.size();
  out.resize(at + kPointBytes * points.size());
  for (const LivoxPoint& p : points) {
    std::uint8_t* to = out.data() + at;
    std::memcpy(to, &p.offset_time, 4);
    const std::array<float, 3> xyz{p.x, p.y, p.z};
    std::memcpy(to + 4, xyz.data(), 12);
    to[16] = p.reflectivity;
    to[17] = p.tag;
    to[18] = p.line;
    at += kPointBytes;
  }
}

void encode_imu(const HeaderFields& header, const Vec3& gyro, const Vec3& acc, std::vector<std::uint8_t>& out) {
  constexpr std::array<double, 9> kUnknown{-1, 0, 0, 0, 0, 0, 0, 0, 0};
  constexpr std::array<double, 9> kZero{};
  append_header(out, header);
  append(out, std::array<double, 4>{0, 0, 0, 1});
  append(out, kUnknown);
  append_vector(out, gyro);
  append(out, kZero);
  append_vector(out, acc);
  append(out, kZero);
}

void encode_point_cloud2(const HeaderFields& header, const CloudLayout& layout, std::span<const std::uint8_t> data,
                         std::vector<std::uint8_t>& out) {
  append_header(out, header);
  append(out, layout.height);
  append(out, layout.width);
  append(out, static_cast<std::uint32_t>(layout.fields.size()));
  for (const PointField& field : layout.fields) {
    append_string(out, field.name);
    append(out, field.offset);
    append(out, field.datatype);
    append(out, field.count);
  }
  append(out, static_cast<std::uint8_t>(layout.is_bigendian));
  append(out, layout.point_step);
  append(out, layout.row_step);
  append(out, static_cast<std::uint32_t>(data.size()));
  out.insert(out.end(), data.begin(), data.end());
  append(out, static_cast<std::uint8_t>(layout.is_dense));
}

}  // namespace aslio::io::rosbag
