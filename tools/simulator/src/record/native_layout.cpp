#include "record/native_layout.hpp"

#include <fmt/format.h>

#include <system_error>

#include "aslio/core/errors.hpp"

namespace aslio::simulator {
namespace {

namespace fs = std::filesystem;

std::string_view extension_of(RecordFormat format) {
  return format == RecordFormat::bag ? ".bag" : format == RecordFormat::db3 ? ".db3" : ".mcap";
}

/// A database of rosbag2 always lies in a folder.
bool in_folder(const RecordOptions& options) { return options.parts > 1 || options.format == RecordFormat::db3; }

}  // namespace

std::string native_input(const RecordOptions& options) {
  return in_folder(options) ? options.name : options.name + std::string(extension_of(options.format));
}

RecordLayout native_layout(const Simulation& simulation, const RecordOptions& options) {
  const SensorFacts& f = facts(simulation.sensor_kind());
  const bool livox = simulation.pattern().message() == LidarMessage::livox_custom;
  const bool ros1 = options.format == RecordFormat::bag;
  RecordLayout record{{}, options.folder, options.name, to_seconds(Simulation::kPacketPeriod)};
  io::Layout& layout = record.layout;
  layout.container = ros1                                  ? io::Container::rosbag
                     : options.format == RecordFormat::db3 ? io::Container::rosbag2
                                                           : io::Container::mcap;
  // Messages of a database stay as they are: not every player of rosbag2 decompresses them.
  const bool pack = options.compress && options.format != RecordFormat::db3;
  layout.compression = !pack ? io::Packing::none : ros1 ? io::Packing::lz4 : io::Packing::zstd;
  layout.parts = options.parts;
  layout.files = {ros1 && options.parts > 1 ? "{sequence}/{sequence}_{part}.bag" : native_input(options)};
  layout.lidar.form = !livox ? io::LidarForm::velodyne : ros1 ? io::LidarForm::livox : io::LidarForm::livox2;
  layout.lidar.topic = f.lidar_topic;
  layout.imu.topic = f.imu_topic;
  layout.lidar.frame_id = layout.imu.frame_id = f.frame_id;
  layout.imu.acc_unit = livox ? io::AccUnit::g : io::AccUnit::mps2;
  layout.reference.format = io::ReferenceFile::none;
  return record;
}

void remove_earlier_parts(const RecordOptions& options) {
  if (!in_folder(options)) return;
  const fs::path folder = options.folder / options.name;
  std::error_code error;
  if (!fs::exists(folder, error)) return;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    const std::string name = it->path().filename().string();
    const bool part = name.starts_with(options.name + "_") && name.ends_with(extension_of(options.format));
    if (part || name == "metadata.yaml") fs::remove(it->path(), error);
  }
  if (error) {
    throw DataError(fmt::format("{}: cannot remove the parts of an earlier recording: {}; name another folder",
                                folder.string(), error.message()));
  }
}

}  // namespace aslio::simulator
