#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "aslio/config/binder.hpp"
#include "aslio/io/layout.hpp"
#include "cloud_form.hpp"

namespace aslio::io {
namespace {

constexpr double kFarthest = 1e7;  ///< [m], of coordinates in UTM

void describe_unit(config::Binder& b, const char* key, TimeUnit& unit, const char* doc) {
  b.choice(key, unit, {{"s", TimeUnit::s}, {"ms", TimeUnit::ms}, {"us", TimeUnit::us}, {"ns", TimeUnit::ns}}, doc);
}

void describe_offset(config::Binder& b, double& offset) {
  b.real("time_offset", offset, "s", {.min = -InputTimes::kMaxOffset, .max = InputTimes::kMaxOffset},
         "of the clock: added to all times of the sensor");
}

/// Each a role, and behind `=` its name in the header.
void describe_columns(config::Binder& b, std::vector<std::string>& columns, const std::vector<std::string>& roles) {
  b.texts("columns", columns, {}, "of a table, each a role (- is a column of zeros), or role=name in the header");
  const bool known = std::all_of(columns.begin(), columns.end(), [&](const std::string& column) {
    return std::find(roles.begin(), roles.end(), column.substr(0, column.find('='))) != roles.end();
  });
  b.require(known && !columns.empty(), "columns", fmt::format("must be of {}", fmt::join(roles, ", ")));
}

bool has(const std::string& text, std::string_view part) { return text.find(part) != std::string::npos; }

/// Which container takes which packing.
bool packs(Container container, Packing packing) {
  if (packing == Packing::none) return true;
  if (container == Container::rosbag) return packing == Packing::lz4;
  if (container == Container::rosbag2) return packing == Packing::zstd;
  return container == Container::mcap;
}

/// The number of files, and what their names hold.
void require_files(config::Binder& b, const Layout& layout) {
  const std::vector<std::string>& files = layout.files;
  if (layout.container == Container::folder) {
    b.require(files.size() == 2 && (has(files[0], "{stamp}") || has(files[0], "{index}")), "files",
              "a folder needs two names: that of a scan, with {stamp} or {index}, and that of the table of the IMU");
    return;
  }
  if (layout.container == Container::kitti) {
    b.require(files.size() == 1, "files", "a drive needs one name: that of its folder");
    return;
  }
  const bool topic = layout.reference.format == ReferenceFile::pose || layout.reference.format == ReferenceFile::point;
  const std::size_t wanted = layout.split == FileSplit::together ? 1 : topic ? 3 : 2;
  b.require(files.size() == wanted, "files",
            "give one name, or with `split: by_topic` those of LiDAR and IMU, and of the reference if it is a topic");
  const bool numbered =
      std::all_of(files.begin(), files.end(), [](const std::string& file) { return has(file, "{part}"); });
  const bool folders = layout.container != Container::rosbag &&
                       std::none_of(files.begin(), files.end(),
                                    [](const auto& f) { return f.ends_with(".db3") || f.ends_with(".mcap"); });
  b.require(layout.parts == 1 || numbered || folders, "files", "names of several parts need {part}");
}

}  // namespace

void LidarLayout::describe(config::Binder& b, LidarLayout& layout) {
  b.choice("form", layout.form,
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
  b.text("topic", layout.topic, "of the LiDAR messages");
  b.text("frame_id", layout.frame_id, "in the header of the LiDAR messages");
  b.choice("order", layout.order, {{"column", PointOrder::column}, {"row", PointOrder::row}},
           "points by time, or line after line");
  b.flag("organised", layout.organised, "a place for every beam, also for those without a return");
  b.choice("stamp", layout.stamp,
           {{"start", SweepMoment::start}, {"middle", SweepMoment::middle}, {"end", SweepMoment::end}},
           "moment of the sweep that stamps its message, or names its file");
  b.choice("point_time", layout.point_time,
           {{"form", PointOrigin::form},
            {"start", PointOrigin::start},
            {"middle", PointOrigin::middle},
            {"end", PointOrigin::end},
            {"absolute", PointOrigin::absolute}},
           "what the times of points count from; form: what the driver does");
  describe_unit(b, "name_unit", layout.name_unit, "unit of the stamps in the names of scans");
  describe_offset(b, layout.time_offset);
  b.require(is_cloud_form(layout.form) || !layout.organised, "organised", "is for forms of points alone");
  b.require(is_cloud_form(layout.form) || layout.point_time == PointOrigin::form, "point_time",
            "is for forms of points alone");
  b.require(!is_livox_form(layout.form) || layout.stamp == SweepMoment::start, "stamp",
            "a Livox message is stamped with the start");
}

void ImuLayout::describe(config::Binder& b, ImuLayout& layout) {
  b.text("topic", layout.topic, "of the IMU messages");
  b.text("frame_id", layout.frame_id, "in the header of the IMU messages");
  b.choice("acc_unit", layout.acc_unit, {{"mps2", AccUnit::mps2}, {"g", AccUnit::g}}, "unit of the acceleration");
  b.choice("gyro_unit", layout.gyro_unit, {{"rad_s", GyroUnit::rad_s}, {"deg_s", GyroUnit::deg_s}},
           "unit of the angular rate");
  b.real("rate", layout.rate, "Hz", {.min = 5.0, .max = 10000.0}, "samples per second");
  for (const auto& [key, signs] : {std::pair{"gyro_signs", &layout.gyro_signs}, {"acc_signs", &layout.acc_signs}}) {
    b.reals(key, *signs, 3, "1", {.min = -1.0, .max = 1.0}, "-1 where the driver turns the axis round");
    b.require(std::all_of(signs->begin(), signs->end(), [](double v) { return std::abs(v) == 1; }), key,
              "must be of 1 and -1 alone");
  }
  describe_offset(b, layout.time_offset);
  describe_columns(b, layout.columns, {"t", "sec", "nsec", "count", "wx", "wy", "wz", "ax", "ay", "az", "-"});
  b.flag("header", layout.header, "the table begins with the names of its columns");
  describe_unit(b, "time_unit", layout.time_unit, "of the column t");
}

void ReferenceLayout::describe(config::Binder& b, ReferenceLayout& layout) {
  b.choice("format", layout.format,
           {{"none", ReferenceFile::none},
            {"tum", ReferenceFile::tum},
            {"csv", ReferenceFile::csv},
            {"pose", ReferenceFile::pose},
            {"point", ReferenceFile::point}},
           "a TUM file, a table of `columns`, or PoseStamped or PointStamped on a topic of the recording");
  b.text("file", layout.file, "name of the file or table; {sequence} is replaced");
  b.text("topic", layout.topic, "of the messages");
  describe_columns(b, layout.columns, {"t", "sec", "nsec", "count", "x", "y", "z", "qx", "qy", "qz", "qw", "-"});
  b.text("separator", layout.separator, "between the columns of a table");
  b.require(!layout.separator.empty(), "separator", "must not be empty");
  b.flag("header", layout.header, "the table begins with the names of its columns");
  describe_unit(b, "time_unit", layout.time_unit, "of the column t");
  b.real("rate", layout.rate, "Hz", {.above = 0.0, .max = 1000.0}, "poses per second, at most");
  b.flag("positions_only", layout.positions_only, "orientations are written as the identity");
  b.group("T_imu_reference", layout.T_imu_reference, "pose of the frame of the reference in the IMU frame");
  describe_offset(b, layout.time_offset);
  b.reals("origin", layout.origin, 3, "m", {.min = -kFarthest, .max = kFarthest},
          "where the world of the simulation lies in that of the reference");
}

void Layout::describe(config::Binder& b, Layout& layout) {
  b.choice("container", layout.container,
           {{"rosbag", Container::rosbag},
            {"rosbag2", Container::rosbag2},
            {"mcap", Container::mcap},
            {"folder", Container::folder},
            {"kitti", Container::kitti}},
           "ROS1 bags, rosbag2 databases, MCAP files, a file for each scan, or a raw drive of KITTI");
  b.choice("compression", layout.compression, {{"none", Packing::none}, {"lz4", Packing::lz4}, {"zstd", Packing::zstd}},
           "of chunks (bag: lz4; MCAP: both) or of messages (rosbag2: zstd)");
  b.require(packs(layout.container, layout.compression), "compression", "the container does not have it");
  b.integer("parts", layout.parts, "1", {.min = 1, .max = 1000}, "files of equal time, one after the other");
  b.choice("split", layout.split, {{"together", FileSplit::together}, {"by_topic", FileSplit::by_topic}},
           "all topics in one file, or a file for each");
  b.texts(
      "files", layout.files, {},
      "names below the folder: one, those by topic, or those of a scan and the table of the IMU; {sequence}, {part}, "
      "{stamp} and {index} are replaced, a name without extension is a folder of rosbag2");
  b.real("begin", layout.begin, "s", {.min = 0.0, .max = 4.0e9}, "stamp of the first measurement, since 1970");
  b.group("lidar", layout.lidar, "messages or scans of the LiDAR");
  b.group("imu", layout.imu, "messages or table of the IMU");
  b.group("reference", layout.reference, "the true trajectory as the data set gives it");
  const bool clouds = is_cloud_form(layout.lidar.form);
  b.require(layout.of_messages() || clouds, "lidar", "files of scans hold points, not messages");
  require_files(b, layout);
}

}  // namespace aslio::io
