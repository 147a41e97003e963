// From what a family says to its readers, to what a writer has to know.
#include "aslio/experiment/stand_in.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>

#include "aslio/config/load.hpp"
#include "aslio/core/errors.hpp"
#include "aslio/io/layout_writer.hpp"
#include "aslio/io/reference.hpp"
#include "aslio/plugin/registry.hpp"
#include "matching_paths.hpp"

namespace aslio::experiment {
namespace {

[[noreturn]] void refuse(const Family& family, const FamilySequence& sequence, const std::string& why) {
  throw ConfigError(fmt::format("{}: {}: {}", family.file.string(), sequence.name, why));
}

/// A name that the pattern matches. A star stands for the part, and otherwise says that the data are simulated.
std::string name_of(const std::string& pattern) {
  std::string name = alternatives(pattern).front();
  const std::size_t star = name.rfind('*');
  if (star == std::string::npos) return name;
  const bool bare = star == 0 || name[star - 1] == '/';
  name.replace(star, 1, bare ? "simulated_{part}" : "{part}");
  for (std::size_t at = name.find('*'); at != std::string::npos; at = name.find('*')) name.replace(at, 1, "simulated");
  return name;
}

/// Names of the recordings; the reference, where it is one, may be among them or lie beside them.
std::vector<std::string> files_of(const Family& family, const FamilySequence& sequence) {
  std::vector<std::string> files;
  std::vector<std::string> patterns = sequence.stand_in.files.empty() ? sequence.input : sequence.stand_in.files;
  const bool recorded = sequence.reference && sequence.reference->format == io::ReferenceFormat::recording;
  const auto same = [&](const std::string& pattern) { return pattern == sequence.reference->file; };
  if (recorded && std::none_of(patterns.begin(), patterns.end(), same)) patterns.push_back(sequence.reference->file);
  for (const std::string& pattern : patterns) {
    files.push_back(io::filled_in(name_of(pattern), "variant", sequence.variant));
    if (files.back().find_first_of("?[") != std::string::npos) {
      refuse(family, sequence, fmt::format("give `stand_in.files`: no name follows from '{}'", pattern));
    }
  }
  return files;
}

/// Frames as the drivers name them.
std::string frame_of(io::LidarForm form) {
  switch (form) {
    case io::LidarForm::ouster:
    case io::LidarForm::ouster_old:
      return "os_sensor";
    case io::LidarForm::hesai:
    case io::LidarForm::hesai_general:
      return "PandarXT-32";
    case io::LidarForm::livox:
    case io::LidarForm::livox2:
    case io::LidarForm::livox_cloud:
      return "livox_frame";
    default:
      return "velodyne";
  }
}

void fill_lidar(const StandInConfig& config, const io::SensorConfig& sensor, io::LidarLayout& lidar) {
  lidar.form = config.points;
  if (!sensor.lidar_topic.empty()) lidar.topic = sensor.lidar_topic;
  lidar.frame_id = sensor.lidar_frame.empty() ? frame_of(config.points) : sensor.lidar_frame;
  lidar.order = config.order;
  lidar.organised = config.organised;
  lidar.name_unit = config.name_unit;
  lidar.time_offset = -sensor.times.lidar_time_offset;
  const io::LidarStamp stamp = sensor.times.lidar_stamp;
  lidar.stamp = stamp == io::LidarStamp::end      ? io::SweepMoment::end
                : stamp == io::LidarStamp::middle ? io::SweepMoment::middle
                                                  : io::SweepMoment::start;
  // The file of a scan tells no stamp but its name: for Boreas that of the middle.
  if (config.points == io::LidarForm::boreas) lidar.stamp = io::SweepMoment::middle;
  const io::PointTime times = sensor.times.point_time;
  lidar.point_time = times == io::PointTime::start      ? io::PointOrigin::start
                     : times == io::PointTime::end      ? io::PointOrigin::end
                     : times == io::PointTime::absolute ? io::PointOrigin::absolute
                                                        : io::PointOrigin::form;
}

void fill_imu(const StandInConfig& config, const io::SensorConfig& sensor, io::ImuLayout& imu) {
  if (!sensor.imu_topic.empty()) imu.topic = sensor.imu_topic;
  // The drivers of Livox send g.
  const bool livox = sensor.imu_topic.find("livox") != std::string::npos;
  const bool in_g = sensor.acc_unit == io::AccUnit::g || (sensor.acc_unit == io::AccUnit::automatic && livox);
  imu.acc_unit = in_g ? io::AccUnit::g : io::AccUnit::mps2;
  imu.gyro_unit = sensor.gyro_unit == io::GyroUnit::deg_s ? io::GyroUnit::deg_s : io::GyroUnit::rad_s;
  imu.gyro_signs.assign(sensor.gyro_signs.begin(), sensor.gyro_signs.end());
  imu.acc_signs.assign(sensor.acc_signs.begin(), sensor.acc_signs.end());
  imu.rate = config.imu_rate;
  imu.time_offset = -sensor.times.imu_time_offset;
  imu.header = config.imu_header;
  imu.time_unit = config.imu_time_unit;
  if (!config.imu_columns.empty()) imu.columns = config.imu_columns;
}

io::TransformBlock block_of(const Pose& T) {
  const Eigen::Quaterniond q(T.R);
  io::TransformBlock block;
  block.translation = {T.p.x(), T.p.y(), T.p.z()};
  block.quaternion = {q.x(), q.y(), q.z(), q.w()};
  return block;
}

/// The format and the columns in which the reader expects a file.
void fill_columns(const Family& family, const FamilySequence& sequence, const io::ReferenceSpec& spec,
                  io::ReferenceLayout& reference) {
  using io::ReferenceFormat;
  const bool tum =
      spec.format == ReferenceFormat::tum || (spec.format == ReferenceFormat::automatic && spec.columns.empty());
  if (tum) {
    reference.format = io::ReferenceFile::tum;
    return;
  }
  if (spec.format == ReferenceFormat::kitti) refuse(family, sequence, "references of KITTI's format are not written");
  reference.format = io::ReferenceFile::csv;
  if (spec.format == ReferenceFormat::euroc) {
    reference.columns = {"t", "x", "y", "z", "qw", "qx", "qy", "qz"};
    reference.time_unit = io::TimeUnit::ns;
  }
  if (!spec.columns.empty()) reference.columns = spec.columns;
  for (const std::string& column : reference.columns) {
    if (column.starts_with('r')) refuse(family, sequence, "references with matrices are not written");
  }
}

void fill_reference(const Family& family, const FamilySequence& sequence, const StandInConfig& config,
                    const io::SensorConfig& sensor, io::ReferenceLayout& reference) {
  reference.format = io::ReferenceFile::none;
  if (!sequence.reference) return;
  const io::ReferenceSpec spec = io::with_protocol(*sequence.reference);
  const bool on_topic = spec.format == io::ReferenceFormat::recording || !spec.topic.empty();
  if (on_topic) {
    reference.format = io::ReferenceFile::pose;
    reference.topic = spec.topic;
  } else {
    fill_columns(family, sequence, spec, reference);
    reference.file = io::filled_in(name_of(spec.file), "part", "0");
  }
  reference.separator = config.reference_separator;
  reference.header = config.reference_header;
  if (spec.time_unit != io::TimeUnit::automatic) reference.time_unit = spec.time_unit;
  reference.rate = config.reference_rate;
  reference.positions_only = spec.positions_only == io::PositionsOnly::yes;
  reference.T_imu_reference = block_of(io::pose_in_imu(spec, sensor.all_transforms()));
  reference.time_offset = -spec.time_offset;
  reference.origin = config.reference_origin;
}

/// The number of columns next to the published one with which the simulator's firings end with every 10 ms.
std::int64_t simulated_columns(std::int64_t published) {
  constexpr std::array<std::int64_t, 7> kColumns = {400, 500, 800, 1000, 1250, 1600, 2000};
  return *std::min_element(kColumns.begin(), kColumns.end(), [published](std::int64_t a, std::int64_t b) {
    return std::abs(a - published) < std::abs(b - published);
  });
}

}  // namespace

StandIn stand_in_of(const Family& family, const FamilySequence& sequence) {
  const StandInConfig& config = sequence.stand_in;
  if (!config.given()) {
    refuse(family, sequence, "has no block `stand_in`, without which nobody knows how its files are written");
  }
  StandIn out;
  out.sensor = config::load<io::SensorConfig>(sequence.sensor, config::FileKind::sensor, plugin::Catalog()).value;
  io::Layout& layout = out.layout;
  layout.container = config.container;
  layout.compression = config.compression;
  layout.parts = config.parts;
  layout.files = files_of(family, sequence);
  layout.split = layout.of_messages() && layout.files.size() > 1 ? io::FileSplit::by_topic : io::FileSplit::together;
  layout.begin = config.begin;
  fill_lidar(config, out.sensor, layout.lidar);
  fill_imu(config, out.sensor, layout.imu);
  fill_reference(family, sequence, config, out.sensor, layout.reference);
  out.sensor_noise = config.sensor_noise;
  out.published_columns = config.columns;
  // A sweep of half a turn has half of its columns.
  constexpr double kTurn = 0.1;
  out.columns =
      simulated_columns(std::llround(static_cast<double>(config.columns) * kTurn / out.sensor.model.sweep_period));
  return out;
}

}  // namespace aslio::experiment
