#include "aslio/experiment/stand_in_config.hpp"

#include "aslio/config/binder.hpp"

namespace aslio::experiment {
namespace {

constexpr double kFarthest = 1e7;  ///< [m], of coordinates in UTM

void describe_unit(config::Binder& b, const char* key, io::TimeUnit& unit, const char* doc) {
  using io::TimeUnit;
  b.choice(key, unit, {{"s", TimeUnit::s}, {"ms", TimeUnit::ms}, {"us", TimeUnit::us}, {"ns", TimeUnit::ns}}, doc);
}

void describe_points(config::Binder& b, StandInConfig& config) {
  using io::LidarForm;
  b.choice("points", config.points,
           {{"velodyne", LidarForm::velodyne},
            {"ouster", LidarForm::ouster},
            {"ouster_old", LidarForm::ouster_old},
            {"hesai", LidarForm::hesai},
            {"hesai_general", LidarForm::hesai_general},
            {"livox_cloud", LidarForm::livox_cloud},
            {"livox", LidarForm::livox},
            {"livox2", LidarForm::livox2},
            {"velodyne_packets", LidarForm::velodyne_packets},
            {"helipr_ouster", LidarForm::helipr_ouster},
            {"boreas", LidarForm::boreas},
            {"fomo", LidarForm::fomo}},
           "fields of a point, as the driver or the data set has them, or a message of its own");
  b.choice("order", config.order, {{"column", io::PointOrder::column}, {"row", io::PointOrder::row}},
           "points by time, or line after line");
  b.flag("organised", config.organised, "a place for every beam, also for those without a return");
  b.integer("columns", config.columns, "1", {.min = 100.0, .max = 4000.0}, "firings per sweep of the published sensor");
  describe_unit(b, "name_unit", config.name_unit, "of the stamps in the names of scans");
}

}  // namespace

void StandInConfig::describe(config::Binder& b, StandInConfig& config) {
  using io::Container;
  using io::Packing;
  b.choice("container", config.container,
           {{"rosbag", Container::rosbag},
            {"rosbag2", Container::rosbag2},
            {"mcap", Container::mcap},
            {"folder", Container::folder},
            {"kitti", Container::kitti}},
           "ROS1 bags, rosbag2 databases, MCAP files, a file for each scan, or a raw drive of KITTI");
  b.texts("files", config.files, {},
          "names to write in place of `input`; {sequence}, {variant}, {part}, {stamp} and {index} are replaced");
  b.integer("parts", config.parts, "1", {.min = 1, .max = 1000}, "files of equal time, one after the other");
  b.choice("compression", config.compression, {{"none", Packing::none}, {"lz4", Packing::lz4}, {"zstd", Packing::zstd}},
           "of chunks or messages");
  describe_points(b, config);
  b.real("imu_rate", config.imu_rate, "Hz", {.min = 0.0, .max = 10000.0},
         "samples per second; 0: nothing is said of how the sequence is written");
  b.flag(
      "sensor_noise", config.sensor_noise,
      "simulates the noise of the sensor file; false: that of the scene, where the sensor file has more than the IMU");
  b.texts("imu_columns", config.imu_columns, {}, "of a table of the IMU; empty: those of the sensor file");
  b.flag("imu_header", config.imu_header, "the table of the IMU begins with the names of its columns");
  describe_unit(b, "imu_time_unit", config.imu_time_unit, "of the times in the table of the IMU");
  b.real("reference_rate", config.reference_rate, "Hz", {.above = 0.0, .max = 1000.0}, "poses per second, at most");
  b.text("reference_separator", config.reference_separator, "between the columns of the reference");
  b.flag("reference_header", config.reference_header, "the reference begins with the names of its columns");
  b.reals("reference_origin", config.reference_origin, 3, "m", {.min = -kFarthest, .max = kFarthest},
          "where the world of the simulation lies in that of the reference");
  b.real("begin", config.begin, "s", {.min = 0.0, .max = 4.0e9}, "stamp of the first measurement, since 1970");
}

}  // namespace aslio::experiment
