#include "external_input.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <memory>
#include <optional>
#include <variant>

#include "aslio/config/file_text.hpp"
#include "aslio/core/errors.hpp"
#include "aslio/io/inspect.hpp"
#include "aslio/io/layout_writer.hpp"
#include "aslio/io/writers.hpp"
#include "aslio/plugin/registry.hpp"
#include "matching_paths.hpp"

namespace aslio::experiment {

namespace {

namespace fs = std::filesystem;

constexpr const char* kName = "recording";

/// A sweep's points are in the LiDAR's frame, each with its own time.
TimeNs end_of(const LidarPacket& sweep) {
  TimeNs end = sweep.stamp;
  for (const TimedPoint& point : sweep.points) end = std::max(end, point.t);
  return end;
}

/// A PCD file for each sweep, named by its stamp, and imu.csv.
class PcdFolder final : public io::LayoutWriter {
 public:
  PcdFolder(const io::Layout& layout, fs::path folder)
      : layout_(layout), folder_(std::move(folder)), imu_(folder_ / "imu.csv") {
    imu_.write("timestamp_ns,wx,wy,wz,ax,ay,az\n");
  }

  void add_imu(const ImuSample& measured, TimeNs) override {
    const ImuSample s = as_told(layout_.imu, measured);
    imu_.write(fmt::format("{},{},{},{},{},{},{}\n", s.t, s.gyro.x(), s.gyro.y(), s.gyro.z(), s.acc.x(), s.acc.y(),
                           s.acc.z()));
  }

  void add_sweep(const LidarPacket& measured, TimeNs) override {
    const LidarPacket& sweep = as_told(layout_.lidar, measured, scratch_);
    const std::size_t n = sweep.points.size();
    std::string text = fmt::format(
        "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z intensity ring t\nSIZE 4 4 4 4 2 4\nTYPE F F F F U U\n"
        "COUNT 1 1 1 1 1 1\nWIDTH {0}\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS {0}\nDATA binary\n",
        n);
    const auto append = [&text](const auto& value) {
      char bytes[sizeof(value)];
      std::memcpy(bytes, &value, sizeof(value));
      text.append(bytes, sizeof(value));
    };
    for (const TimedPoint& point : sweep.points) {
      append(point.x);
      append(point.y);
      append(point.z);
      append(point.intensity);
      append(static_cast<std::uint16_t>(point.line));
      append(static_cast<std::uint32_t>(point.t - sweep.stamp));  // [ns]; a sweep lasts 4 s at most
    }
    io::AtomicFile file(folder_ / fmt::format("{}.pcd", sweep.stamp), true);
    file.write(text);
    file.close();
  }

  void add_reference(const StampedPose&) override {}
  void close() override { imu_.close(); }
  const std::vector<fs::path>& files() const override { return files_; }

 private:
  const io::Layout layout_;
  fs::path folder_;
  LidarPacket scratch_;
  io::AtomicFile imu_;
  std::vector<fs::path> files_{"."};
};

/// The topics that are read; what the sensor file leaves open is found.
struct Topics {
  std::string lidar, imu;
  bool livox = false;  ///< the driver's own message
};

Topics topics_of(const Dataset& dataset, const io::SensorConfig& sensor) {
  Topics topics{sensor.lidar_topic, sensor.imu_topic, sensor.lidar_topic.find("livox") != std::string::npos};
  if (!topics.lidar.empty() && !topics.imu.empty()) return topics;
  for (const io::TopicReport& found : io::inspect(dataset.inputs, sensor).topics) {
    if (!found.problem.empty()) continue;
    if (found.role == io::TopicRole::lidar && topics.lidar.empty()) {
      topics.lidar = found.topic;
      topics.livox = found.type.find("CustomMsg") != std::string::npos;
    }
    if (found.role == io::TopicRole::imu && topics.imu.empty()) topics.imu = found.topic;
  }
  return topics;
}

io::LidarForm form_of(const ExternalMethod& method, bool livox) {
  switch (method.points) {
    case ExternalPoints::velodyne:
      return io::LidarForm::velodyne;
    case ExternalPoints::ouster:
      return io::LidarForm::ouster;
    case ExternalPoints::hesai:
      return io::LidarForm::hesai;
    case ExternalPoints::livox_cloud:
      return io::LidarForm::livox_cloud;
    case ExternalPoints::livox:
      return io::LidarForm::livox;
    case ExternalPoints::livox2:
      return io::LidarForm::livox2;
    case ExternalPoints::automatic:
      break;
  }
  if (!livox) return io::LidarForm::velodyne;
  return method.input == ExternalInput::bag ? io::LidarForm::livox : io::LidarForm::livox2;
}

io::Layout layout_of(const ExternalMethod& method, const io::SensorConfig& sensor, const Topics& topics) {
  io::Layout layout;
  layout.container = method.input == ExternalInput::bag   ? io::Container::rosbag
                     : method.input == ExternalInput::db3 ? io::Container::rosbag2
                                                          : io::Container::mcap;
  layout.files = {method.input == ExternalInput::bag   ? "{sequence}.bag"
                  : method.input == ExternalInput::db3 ? "{sequence}"
                                                       : "{sequence}.mcap"};
  layout.lidar.form = form_of(method, topics.livox);
  if (!topics.lidar.empty()) layout.lidar.topic = topics.lidar;
  if (!topics.imu.empty()) layout.imu.topic = topics.imu;
  layout.lidar.frame_id = "lidar";
  layout.imu.frame_id = "imu";
  // Programs for a sensor expect the unit of its driver.
  if (sensor.acc_unit == io::AccUnit::g || (sensor.acc_unit == io::AccUnit::automatic && topics.livox)) {
    layout.imu.acc_unit = io::AccUnit::g;
  }
  layout.reference.format = io::ReferenceFile::none;
  return layout;
}

/// The sensor file of a copy: what reading has put right is right there.
std::string sensor_of_copy(io::SensorConfig sensor, const io::Layout& layout, bool folder) {
  const bool deskewed = sensor.times.deskewed;
  sensor.times = {};
  sensor.times.deskewed = deskewed;
  sensor.lidar_topic = folder ? "" : layout.lidar.topic;
  sensor.imu_topic = folder ? "" : layout.imu.topic;
  sensor.acc_unit = layout.imu.acc_unit;
  sensor.gyro_unit = io::GyroUnit::rad_s;
  sensor.gyro_signs = sensor.acc_signs = {1, 1, 1};
  sensor.gyro_sensitivity = Mat3::Zero();
  sensor.imu_delay = 0;
  sensor.lidar_id = -1;
  sensor.scan_columns = sensor.imu_columns = sensor.lidar_frame = "";
  sensor.lidar_metadata = sensor.lidar_calibration = sensor.lidar_address = "";
  return config::file_text(sensor, config::FileKind::sensor, plugin::Catalog());
}

/// Measurements in the order in which they are read; a message counts as received when its last point was measured.
class Copy {
 public:
  Copy(const ExternalMethod& method, const io::SensorConfig& sensor, const Topics& topics, const fs::path& folder)
      : layout_(layout_of(method, sensor, topics)) {
    if (method.input == ExternalInput::folder) {
      writer_ = std::make_unique<PcdFolder>(layout_, folder);
      return;
    }
    io::LayoutPlace place;
    place.folder = folder;
    place.sequence = kName;
    place.grid.lines = sensor.model.scan_lines;
    place.T_imu_lidar = sensor.model.T_imu_lidar;
    writer_ = io::open_layout_writer(layout_, place);
  }

  void add(const Measurement& measurement) {
    if (const auto* sweep = std::get_if<LidarPacket>(&measurement)) {
      sweep_ = *sweep;
      std::stable_sort(sweep_.points.begin(), sweep_.points.end(),
                       [](const TimedPoint& a, const TimedPoint& b) { return a.t < b.t; });
      if (!sweep_.points.empty()) sweep_.stamp = sweep_.points.front().t;  // the layout has that of the start
      received_ = std::max(received_, end_of(*sweep));
      writer_->add_sweep(sweep_, received_);
    } else {
      const ImuSample& sample = std::get<ImuSample>(measurement);
      received_ = std::max(received_, sample.t);
      writer_->add_imu(sample, received_);
    }
  }

  fs::path close(const fs::path& folder) {
    writer_->close();
    return (folder / writer_->files().front()).lexically_normal();
  }

  const io::Layout& layout() const { return layout_; }

 private:
  io::Layout layout_;
  std::unique_ptr<io::LayoutWriter> writer_;
  LidarPacket sweep_;
  TimeNs received_ = kTimeMin;
};

/// The files by their names: a pattern is one of this program.
std::vector<fs::path> files_as_they_are(const Dataset& dataset) {
  std::vector<fs::path> files;
  std::error_code ignored;
  for (const fs::path& input : dataset.inputs) {
    if (fs::exists(input, ignored)) {
      files.push_back(fs::absolute(input).lexically_normal());
      continue;
    }
    for (const fs::path& found : matching_paths({}, input.string())) {
      files.push_back(fs::absolute(found).lexically_normal());
    }
  }
  return files;
}

void require_whole(const Dataset& dataset) {
  if (dataset.section.start == 0 && !dataset.section.duration) return;
  throw ConfigError(fmt::format(
      "{}: has `start` or `duration`, and `input: as_is` hands over the whole recording: give the method `input: bag` "
      "(or db3, mcap, folder), which writes that part alone",
      dataset.file.string()));
}

}  // namespace

FedRecording feed_recording(const Dataset& dataset, const io::SensorConfig& sensor, const ExternalMethod& method,
                            const fs::path& folder, const std::function<bool()>& stop) {
  FedRecording fed;
  std::optional<Copy> copy;
  const bool written = !method.command.empty() && method.input != ExternalInput::as_is;
  if (!method.command.empty() && !written) require_whole(dataset);
  const bool asked = std::any_of(method.command.begin(), method.command.end(),
                                 [](const std::string& word) { return word.find("_topic}") != std::string::npos; });
  const Topics topics = written || asked ? topics_of(dataset, sensor) : Topics{};
  if (written) {
    fs::create_directories(folder);
    copy.emplace(method, sensor, topics, folder);
    fed.sensor = sensor_of_copy(sensor, copy->layout(), method.input == ExternalInput::folder);
  }
  const auto source = io::open_source(dataset.inputs, sensor, dataset.section);
  fed.begin = kTimeMax;
  fed.end = kTimeMin;
  while (!stop()) {
    const auto measurement = source->next();
    if (!measurement) break;
    if (copy) copy->add(*measurement);
    const auto* sweep = std::get_if<LidarPacket>(&*measurement);
    if (sweep == nullptr) {
      ++fed.imu_samples;
      continue;
    }
    ++fed.sweeps;
    for (const TimedPoint& point : sweep->points) {
      fed.begin = std::min(fed.begin, point.t);
      fed.end = std::max(fed.end, point.t);
    }
  }
  source->conclude();
  fed.notes = source->notes();
  fed.truncated = source->status() == io::InputStatus::truncated;
  fed.imu_topic = copy ? copy->layout().imu.topic : topics.imu;
  fed.lidar_topic = copy ? copy->layout().lidar.topic : topics.lidar;
  fed.bags = copy ? std::vector<fs::path>{copy->close(folder)} : files_as_they_are(dataset);
  return fed;
}

}  // namespace aslio::experiment
