#include "recordings.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <vector>

#include "aslio/io/rosbag/messages.hpp"
#include "aslio/io/rosbag/writer.hpp"
#include "aslio/io/writers.hpp"
#include "aslio/simulator/analytic_world.hpp"

namespace aslio::test {

namespace {

using namespace io::rosbag;

constexpr std::uint32_t kCloudStep = 20;  ///< x y z intensity time, all float32

class Recorder {
 public:
  Recorder(const std::filesystem::path& path, const Recording& recording) : recording_(recording), bag_(path) {
    lidar_ = connect(recording.lidar_topic, recording.point_cloud ? kPointCloud2 : kLivoxCustomMsg);
    if (recording.imu) imu_ = connect("/livox/imu", kImu);
  }

  void write(const ImuSample& sample) {
    if (!recording_.imu) return;
    now_ = std::max(now_, sample.t);
    encode_imu({imu_count_++, sample.t, "imu"}, sample.gyro,
               sample.acc / (recording_.acc_in_g ? kStandardGravity : 1.0), bytes_);
    bag_.write(imu_, now_, bytes_);
  }

  void write(LidarPacket packet) {
    if (!packet.points.empty()) now_ = std::max(now_, packet.points.back().t);
    if (recording_.nan_every > 0) {
      for (std::size_t i = 0; i < packet.points.size(); i += static_cast<std::size_t>(recording_.nan_every)) {
        packet.points[i].y = std::nanf("");
      }
    }
    recording_.point_cloud ? encode_cloud(packet) : encode_custom(packet);
    bag_.write(lidar_, now_, bytes_);
  }

  void close() { bag_.close(); }

 private:
  std::uint32_t connect(const std::string& topic, const MessageType& type) {
    return bag_.add_connection(topic, std::string(type.name), std::string(type.md5), std::string(type.definition));
  }

  void encode_custom(const LidarPacket& packet) {
    std::vector<LivoxPoint> points;
    for (const TimedPoint& p : packet.points) {
      points.push_back({static_cast<std::uint32_t>(p.t - packet.stamp), p.x, p.y, p.z,
                        static_cast<std::uint8_t>(p.intensity), p.tag, p.line});
    }
    encode_livox({lidar_count_++, packet.stamp, "lidar"}, packet.stamp, 1, points, bytes_);
  }

  void encode_cloud(const LidarPacket& packet) {
    std::vector<std::uint8_t> data(packet.points.size() * kCloudStep);
    std::uint8_t* to = data.data();
    for (const TimedPoint& p : packet.points) {
      const float time = recording_.zero_times ? 0.0F : static_cast<float>(to_seconds(p.t - packet.stamp));
      for (const float value : {p.x, p.y, p.z, p.intensity, time}) {
        std::memcpy(to, &value, sizeof value);
        to += sizeof value;
      }
    }
    CloudLayout layout;
    layout.width = static_cast<std::uint32_t>(packet.points.size());
    std::uint32_t offset = 0;
    for (const char* name : {"x", "y", "z", "intensity", "time"}) {
      layout.fields.push_back({name, offset, 7, 1});
      offset += 4;
    }
    layout.point_step = kCloudStep;
    layout.row_step = kCloudStep * layout.width;
    encode_point_cloud2({lidar_count_++, packet.stamp, "lidar"}, layout, data, bytes_);
  }

  Recording recording_;
  BagWriter bag_;
  std::uint32_t lidar_ = 0, imu_ = 0, lidar_count_ = 0, imu_count_ = 0;
  TimeNs now_ = 0;
  std::vector<std::uint8_t> bytes_;
};

}  // namespace

void write_bag(const std::filesystem::path& bag, const Recording& recording) {
  simulator::Options options;
  options.duration_scale = recording.slowness;
  const simulator::AnalyticWorld world(options);
  const auto source = world.source();
  Recorder recorder(bag, recording);
  const TimeNs end = world.begin_time() + to_ns(recording.duration);
  while (auto measurement = source->next()) {
    const auto* imu = std::get_if<ImuSample>(&*measurement);
    if (imu != nullptr && imu->t > end) break;
    if (const auto* packet = std::get_if<LidarPacket>(&*measurement)) {
      const double at = to_seconds(packet->stamp - world.begin_time());
      if (at >= recording.blind_from && at < recording.blind_until) continue;
    }
    std::visit([&](auto& m) { recorder.write(std::move(m)); }, *measurement);
  }
  recorder.close();
}

void write_truth(const std::filesystem::path& tum) {
  const simulator::AnalyticWorld world;
  io::write_tum(tum, world.truth().samples());
}

std::string sensor_text(const std::string& more) {
  return "schema: aslio/sensor/1\n"
         "T_imu_lidar: {translation: [0.04165, 0.02326, -0.0284], rotation: [1, 0, 0, 0, 1, 0, 0, 0, 1]}\n" +
         more;
}

std::string pipeline_text(const std::string& more) {
  return "schema: aslio/pipeline/1\n"
         "window: {type: fixed, period: 0.1, cut: time}\n"
         "overlap: {type: soft_voxel, voxel: 0.1, layers: 3, store: {type: flat_hash}}\n"
         "history: {type: none}\n"
         "samplers: [{type: range, min: 0.5, max: 100}, {type: stride, keep_every: 7}, {type: voxel, leaf: 0.4, uses: "
         "[map, match]}]\n"
         "map: {type: voxel_hash}\n"
         "insertion: {type: on_new}\n"
         "estimator: {type: ieskf, motion: {type: imu_midpoint}, residual: {type: point_to_plane}}\n" +
         more;
}

}  // namespace aslio::test
