#include "io/bag_fixture.hpp"

#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <iterator>

#include "aslio/core/errors.hpp"

namespace aslio::io::test {

namespace {

std::filesystem::path quick_folder() {
  const std::filesystem::path memory = "/dev/shm";
  return ::access(memory.c_str(), W_OK) == 0 ? memory : std::filesystem::temp_directory_path();
}

}  // namespace

TemporaryFolder::TemporaryFolder() : aslio::test::TemporaryFolder(quick_folder()) {}

std::vector<std::uint8_t> livox_message(TimeNs stamp, TimeNs timebase, int points) {
  std::vector<rosbag::LivoxPoint> cloud;
  for (int i = 0; i < points; ++i) {
    rosbag::LivoxPoint p;
    p.offset_time = static_cast<std::uint32_t>(99'000'000LL * i / std::max(points - 1, 1));
    p.x = 5.0F + static_cast<float>(i);
    p.y = 1.0F;
    p.z = -0.5F;
    p.reflectivity = static_cast<std::uint8_t>(i % 200);
    p.tag = 0x10;
    p.line = static_cast<std::uint8_t>(i % 6);
    cloud.push_back(p);
  }
  std::vector<std::uint8_t> out;
  rosbag::encode_livox({0, stamp, "livox_frame"}, timebase, 0, cloud, out);
  return out;
}

void Recording::write(const std::filesystem::path& path) const {
  rosbag::BagWriter bag(path, options);
  const auto add = [&](const std::string& topic, const rosbag::MessageType& type) {
    return bag.add_connection(topic, std::string(type.name), std::string(type.md5), std::string(type.definition));
  };
  const std::uint32_t imu_id = add(imu_topic, imu_type), lidar_id = add(lidar_topic, lidar_type);
  std::vector<std::uint8_t> bytes;
  const int samples = static_cast<int>(seconds * 100);
  for (int i = 0; i < samples; ++i) {
    const TimeNs stamp = kStart + i * kSecond / 100;
    const TimeNs now = recorded ? recorded(stamp) : stamp;
    const TimeNs sent = imu_stamp ? imu_stamp(i, stamp) : stamp;
    rosbag::encode_imu({static_cast<std::uint32_t>(i), sent, "imu"}, turn ? turn(i) : gyro, acc, bytes);
    bag.write(imu_id, now, bytes);
    if (i % 10 != 0) continue;
    bytes = lidar ? lidar(i / 10, stamp) : livox_message(stamp, stamp + timebase_shift, points);
    bag.write(lidar_id, now + 1, bytes);
  }
  bag.close();
}

Counts drain(MeasurementSource& source) {
  Counts counts;
  while (const auto measurement = source.next()) {
    if (const auto* packet = std::get_if<LidarPacket>(&*measurement)) {
      ++counts.packets;
      counts.points += packet->points.size();
      counts.dropped += packet->dropped_invalid;
    } else {
      ++counts.imu;
    }
  }
  return counts;
}

std::vector<std::uint8_t> read_bytes(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

void write_bytes(const std::filesystem::path& path, const std::vector<std::uint8_t>& bytes) {
  std::ofstream file(path, std::ios::binary);
  file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
}

std::string data_error(const std::function<void()>& action) {
  try {
    action();
  } catch (const DataError& error) {
    return error.what();
  }
  return {};
}

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

bool contains(const std::vector<std::string>& texts, const std::string& part) {
  return std::any_of(texts.begin(), texts.end(), [&](const std::string& text) { return contains(text, part); });
}

}  // namespace aslio::io::test
