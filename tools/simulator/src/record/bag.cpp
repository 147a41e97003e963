#include "record/bag.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "aslio/simulator/random.hpp"
#include "purposes.hpp"

namespace aslio::simulator {
namespace {

using namespace io::rosbag;

std::uint32_t connect(BagWriter& bag, std::string_view topic, const MessageType& type) {
  return bag.add_connection(std::string(topic), std::string(type.name), std::string(type.md5),
                            std::string(type.definition));
}

/// As velodyne_pointcloud lays points out: x, y, z, intensity, ring, time.
constexpr std::uint32_t kPointStep = 22, kRingOffset = 16, kTimeOffset = 18;
constexpr std::uint8_t kUint16 = 4, kFloat32 = 7;

CloudLayout cloud_layout(std::size_t points) {
  CloudLayout layout;
  layout.width = static_cast<std::uint32_t>(points);
  layout.fields = {{"x", 0, kFloat32},
                   {"y", 4, kFloat32},
                   {"z", 8, kFloat32},
                   {"intensity", 12, kFloat32},
                   {"ring", kRingOffset, kUint16},
                   {"time", kTimeOffset, kFloat32}};
  layout.point_step = kPointStep;
  layout.row_step = kPointStep * layout.width;
  return layout;
}

}  // namespace

RecordingBag::RecordingBag(const Simulation& simulation, const std::filesystem::path& path, bool compress)
    : simulation_(simulation),
      facts_(facts(simulation.sensor_kind())),
      bag_(path, {.compression = compress ? Compression::lz4 : Compression::none}),
      livox_(simulation.pattern().message() == LidarMessage::livox_custom),
      jitter_(simulation.options().seed, purpose::kStampJitter),
      imu_loss_(simulation.options().seed, purpose::kImuLoss) {
  lidar_ = connect(bag_, facts_.lidar_topic, livox_ ? kLivoxCustomMsg : kPointCloud2);
  imu_ = connect(bag_, facts_.imu_topic, kImu);
}

HeaderFields RecordingBag::header(std::uint32_t seq, TimeNs stamp) const {
  return {seq, stamp, std::string(facts_.frame_id)};
}

void RecordingBag::add(const LidarPacket& packet, std::size_t index) {
  // A message arrives when its last pulse has come back.
  const TimeNs arrival = std::min(packet.stamp + Simulation::kPacketPeriod, simulation_.end_time());
  add_imu_until(arrival);
  // By index, so that the loss of one packet does not depend on how many came before.
  RandomStream loss(simulation_.options().seed, purpose::kPacketLoss, index);
  if (loss.uniform() < simulation_.scene().stress.packet_loss) return;
  encode(packet);
  bag_.write(lidar_, arrival, bytes_);
  ++lidar_count_;
}

void RecordingBag::add_imu_until(TimeNs arrival) {
  const StressParams& stress = simulation_.scene().stress;
  const std::vector<ImuSample>& samples = simulation_.imu().samples;
  for (; next_imu_ < samples.size() && samples[next_imu_].t <= arrival; ++next_imu_) {
    const ImuSample& sample = samples[next_imu_];
    const double jitter_us = stress.stamp_jitter * jitter_.normal();
    TimeNs stamp = sample.t + static_cast<TimeNs>(std::llround(1e6 * stress.clock_offset + 1e3 * jitter_us));
    stamp = std::max(stamp, last_imu_stamp_ + 1);
    const bool lost = imu_loss_.uniform() < stress.imu_loss;
    if (lost) continue;
    last_imu_stamp_ = stamp;
    const double unit = livox_ ? kStandardGravity : 1;
    encode_imu(header(imu_count_++, stamp), sample.gyro, sample.acc / unit, bytes_);
    bag_.write(imu_, sample.t, bytes_);
  }
}

void RecordingBag::encode(const LidarPacket& packet) {
  if (livox_) {
    encode_livox(packet);
  } else {
    encode_cloud(packet);
  }
}

void RecordingBag::encode_livox(const LidarPacket& packet) {
  livox_points_.clear();
  for (const TimedPoint& p : packet.points)
    livox_points_.push_back({static_cast<std::uint32_t>(p.t - packet.stamp), p.x, p.y, p.z,
                             static_cast<std::uint8_t>(p.intensity), p.tag, p.line});
  io::rosbag::encode_livox(header(lidar_count_, packet.stamp), packet.stamp, 1, livox_points_, bytes_);
}

void RecordingBag::encode_cloud(const LidarPacket& packet) {
  data_.resize(kPointStep * packet.points.size());
  std::uint8_t* out = data_.data();
  for (const TimedPoint& p : packet.points) {
    const float since = static_cast<float>(to_seconds(p.t - packet.stamp));
    const std::uint16_t ring = p.line;
    const float xyzi[] = {p.x, p.y, p.z, p.intensity};
    std::memcpy(out, xyzi, sizeof xyzi);
    std::memcpy(out + kRingOffset, &ring, sizeof ring);
    std::memcpy(out + kTimeOffset, &since, sizeof since);
    out += kPointStep;
  }
  encode_point_cloud2(header(lidar_count_, packet.stamp), cloud_layout(packet.points.size()), data_, bytes_);
}

void RecordingBag::close() {
  add_imu_until(simulation_.end_time() + kSecond);
  bag_.close();
}

}  // namespace aslio::simulator
