#pragma once
/// How a recording lies on disk, as data sets publish theirs: containers, messages, points, stamps and references. What
/// LayoutWriter writes.

#include <cstdint>
#include <string>
#include <vector>

#include "aslio/io/source.hpp"
#include "aslio/io/time_unit.hpp"
#include "aslio/io/transforms.hpp"

namespace aslio::io {

/// What holds the measurements.
enum class Container : std::uint8_t {
  rosbag,   ///< ROS1 bags
  rosbag2,  ///< rosbag2 databases: a file `.db3`, or a folder with its metadata.yaml
  mcap,     ///< MCAP of ROS2 messages: a file `.mcap`, or a folder with its metadata.yaml
  folder,   ///< a file for each scan, and a table of the IMU
  kitti     ///< a raw drive of KITTI that is not synchronised (`_extract`)
};
enum class Packing : std::uint8_t { none, lz4, zstd };
enum class FileSplit : std::uint8_t {
  together,  ///< all topics in one file
  by_topic   ///< a file for each topic
};

/// How the points of a sweep are written: the fields of a PointCloud2 or of the file of a scan, as the driver of the
/// sensor has them, or a message of its own.
enum class LidarForm : std::uint8_t {
  velodyne,          ///< x y z intensity f32, ring u16, time f32 [s]: velodyne_pointcloud
  ouster,            ///< t u32 [ns], reflectivity, ring u16, ambient, range: ouster-ros
  ouster_old,        ///< the same with ring u8 and noise: drivers until 2020
  hesai,             ///< ring u16, timestamp f64 [s since 1970], packed: HesaiLidar_ROS_2.0, rslidar_sdk
  hesai_general,     ///< timestamp f64 [s since 1970], ring u16, aligned as PCL has it: HesaiLidar_General_ROS
  livox_cloud,       ///< tag u8, line u8, timestamp f64 [ns since 1970]: livox_ros_driver2
  livox,             ///< livox_ros_driver/CustomMsg
  livox2,            ///< livox_ros_driver2/CustomMsg
  velodyne_packets,  ///< velodyne_msgs/VelodyneScan of the raw packets of a VLP-16
  helipr_ouster,     ///< x y z intensity f32, t u32 [ns], reflectivity u16, ring u16, ambient u16
  boreas,            ///< x y z intensity ring time [s], all f32
  fomo               ///< x y z intensity f32, ring u16, time u64 [us since 1970]
};
enum class PointOrder : std::uint8_t {
  column,  ///< by time
  row      ///< line after line
};
/// A moment of a sweep. `end` is one sweep period after `start`.
enum class SweepMoment : std::uint8_t { start, middle, end };
/// What the times of points count from.
enum class PointOrigin : std::uint8_t {
  form,  ///< what the driver of the form does
  start,
  middle,
  end,
  absolute  ///< 1970
};

struct LidarLayout {
  LidarForm form = LidarForm::velodyne;
  std::string topic = "/velodyne_points", frame_id = "velodyne";
  PointOrder order = PointOrder::column;
  bool organised = false;  ///< a place for every beam of the sweep, also for those without a return
  SweepMoment stamp = SweepMoment::start;
  PointOrigin point_time = PointOrigin::form;
  TimeUnit name_unit = TimeUnit::ns;  ///< of the stamps in the names of scans
  double time_offset = 0;             ///< of the sensor's clock: added to all its times [s]
};

struct ImuLayout {
  std::string topic = "/imu/data", frame_id = "imu";
  AccUnit acc_unit = AccUnit::mps2;      ///< g or mps2
  GyroUnit gyro_unit = GyroUnit::rad_s;  ///< rad_s or deg_s
  double rate = 200;                     ///< [Hz]
  /// -1: the driver turns the axis round.
  std::vector<double> gyro_signs{1, 1, 1}, acc_signs{1, 1, 1};
  double time_offset = 0;  ///< of its clock: added to its stamps [s]
  /// Of a table: t, sec, nsec, count, wx wy wz, ax ay az; `-` is a column of zeros. `wx=gyro_x` names it in the header.
  std::vector<std::string> columns = {"t", "wx", "wy", "wz", "ax", "ay", "az"};
  bool header = false;                ///< a line with the names of the columns
  TimeUnit time_unit = TimeUnit::ns;  ///< of the column t
};

enum class ReferenceFile : std::uint8_t {
  none,
  tum,
  csv,   ///< a table of `columns`
  pose,  ///< geometry_msgs/PoseStamped on a topic of the recording
  point  ///< geometry_msgs/PointStamped on a topic of the recording
};

struct ReferenceLayout {
  ReferenceFile format = ReferenceFile::tum;
  std::string file = "{sequence}.tum", topic = "/reference";
  /// Of a table: t, sec, nsec, count, x y z, qx qy qz qw; `-` is a column of zeros. `x=pos_x` names it in the header.
  std::vector<std::string> columns = {"t", "x", "y", "z", "qx", "qy", "qz", "qw"};
  std::string separator = ",";
  bool header = false;
  TimeUnit time_unit = TimeUnit::s;     ///< of the column t
  double rate = 10;                     ///< [Hz], at most that of the poses given
  bool positions_only = false;          ///< orientations are written as the identity
  TransformBlock T_imu_reference;       ///< pose of the frame of the reference in the IMU frame
  double time_offset = 0;               ///< added to its stamps [s]
  std::vector<double> origin{0, 0, 0};  ///< where the world of the simulation lies in that of the reference [m]
};

struct Layout {
  Container container = Container::rosbag;
  Packing compression = Packing::none;
  std::int64_t parts = 1;  ///< files of equal time, one after the other
  FileSplit split = FileSplit::together;
  /// One, or with `by_topic` those of LiDAR, IMU and, if it has a topic, reference; of a folder those of a scan and of
  /// the table of the IMU. {sequence}, {part} and, of a scan, {stamp} or {index} are replaced. A name without extension
  /// is that of a folder (rosbag2, MCAP) with its metadata.yaml.
  std::vector<std::string> files = {"{sequence}.bag"};
  double begin = 1'700'000'000;  ///< stamp of the first measurement, since 1970 [s]
  LidarLayout lidar;
  ImuLayout imu;
  ReferenceLayout reference;

  bool of_messages() const { return container != Container::folder && container != Container::kitti; }
};

}  // namespace aslio::io
