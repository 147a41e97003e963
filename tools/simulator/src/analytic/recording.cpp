#include <algorithm>

#include "aslio/core/errors.hpp"
#include "aslio/io/rosbag/messages.hpp"
#include "aslio/io/rosbag/writer.hpp"
#include "aslio/io/writers.hpp"
#include "aslio/simulator/analytic_world.hpp"

namespace aslio::simulator {
namespace {

using namespace io::rosbag;

std::uint32_t connect(BagWriter& bag, const std::string& topic, const MessageType& type) {
  return bag.add_connection(topic, std::string(type.name), std::string(type.md5), std::string(type.definition));
}

std::vector<LivoxPoint> livox_points(const LidarPacket& packet) {
  std::vector<LivoxPoint> out;
  out.reserve(packet.points.size());
  for (const TimedPoint& p : packet.points)
    out.push_back({static_cast<std::uint32_t>(p.t - packet.stamp), p.x, p.y, p.z,
                   static_cast<std::uint8_t>(p.intensity), p.tag, p.line});
  return out;
}

class Recorder {
 public:
  Recorder(BagWriter& bag) : bag_(bag) {
    lidar_ = connect(bag, "/livox/lidar", kLivoxCustomMsg);
    imu_ = connect(bag, "/livox/imu", kImu);
  }

  void write(const ImuSample& sample) {
    now_ = sample.t;
    encode_imu({imu_count_++, sample.t, "livox_frame"}, sample.gyro, sample.acc / kStandardGravity, bytes_);
    bag_.write(imu_, now_, bytes_);
  }
  void write(const LidarPacket& packet) {
    // A message is recorded when its last point has come.
    if (!packet.points.empty()) now_ = std::max(now_, packet.points.back().t);
    encode_livox({lidar_count_++, packet.stamp, "livox_frame"}, packet.stamp, 1, livox_points(packet), bytes_);
    bag_.write(lidar_, now_, bytes_);
  }
  TimeNs now() const { return now_; }

 private:
  BagWriter& bag_;
  std::uint32_t lidar_ = 0, imu_ = 0, lidar_count_ = 0, imu_count_ = 0;
  TimeNs now_ = 0;
  std::vector<std::uint8_t> bytes_;
};

}  // namespace

void write_recording(const AnalyticWorld& world, const std::filesystem::path& folder,
                     const std::function<void(double)>& progress) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) throw DataError(folder.string() + ": cannot create the folder: " + error.message());
  io::write_tum(folder / "truth.tum", world.truth().samples());
  BagWriter bag(folder / "world.bag");
  Recorder recorder(bag);
  const auto source = world.source();
  const double duration = to_seconds(world.end_time() - world.begin_time());
  while (const auto measurement = source->next()) {
    std::visit([&](const auto& m) { recorder.write(m); }, *measurement);
    if (progress && std::holds_alternative<LidarPacket>(*measurement))
      progress(to_seconds(recorder.now() - world.begin_time()) / duration);
  }
  bag.close();
}

}  // namespace aslio::simulator
