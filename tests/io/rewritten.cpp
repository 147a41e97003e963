#include "io/rewritten.hpp"

#include <zstd.h>

#include <algorithm>
#include <array>
#include <cstring>

#include "aslio/core/sha256.hpp"
#include "aslio/io/cdr.hpp"
#include "aslio/io/rosbag/messages.hpp"
#include "aslio/io/rosbag/reader.hpp"
#include "aslio/io/rosbag/writer.hpp"

namespace aslio::io::test {

std::vector<std::string> measurements(MeasurementSource& source) {
  std::vector<std::string> all;
  while (const auto measurement = source.next()) {
    if (const auto* imu = std::get_if<ImuSample>(&*measurement)) {
      all.push_back(fmt::format("imu {} {:a} {:a} {:a} {:a} {:a} {:a}", imu->t, imu->gyro.x(), imu->gyro.y(),
                                imu->gyro.z(), imu->acc.x(), imu->acc.y(), imu->acc.z()));
      continue;
    }
    const auto& packet = std::get<LidarPacket>(*measurement);
    std::string line = fmt::format("lidar {} {} {}", packet.stamp, packet.sweep_id, packet.dropped_invalid);
    for (const TimedPoint& p : packet.points) {
      line += fmt::format(" {} {:a} {:a} {:a} {:a} {} {}", p.t, p.x, p.y, p.z, p.intensity, p.line, p.tag);
    }
    all.push_back(std::move(line));
  }
  return all;
}

std::string digest(MeasurementSource& source) {
  Sha256 imu_sha, lidar_sha;
  const auto add = [](Sha256& sha, const auto& value) { sha.add(&value, sizeof(value)); };
  while (const auto measurement = source.next()) {
    if (const auto* imu = std::get_if<ImuSample>(&*measurement)) {
      add(imu_sha, imu->t);
      imu_sha.add(imu->gyro.data(), 3 * sizeof(double));
      imu_sha.add(imu->acc.data(), 3 * sizeof(double));
      continue;
    }
    const auto& packet = std::get<LidarPacket>(*measurement);
    add(lidar_sha, packet.stamp);
    add(lidar_sha, packet.dropped_invalid);
    for (const TimedPoint& p : packet.points) {
      add(lidar_sha, p.t);
      add(lidar_sha, std::array<float, 4>{p.x, p.y, p.z, p.intensity});
      add(lidar_sha, std::array<std::uint8_t, 2>{p.line, p.tag});
    }
  }
  return imu_sha.hex() + " " + lidar_sha.hex();
}

namespace {

class McapFile final : public MessageWriter {
 public:
  McapFile(std::filesystem::path path, const McapOptions& options) : path_(std::move(path)), writer_(options) {}

  std::uint32_t add(const Connection& connection) override {
    const bool ros1 = connection.encoding == Encoding::ros1;
    const std::uint16_t schema =
        writer_.add_schema(connection.type, ros1 ? "ros1msg" : "ros2msg", connection.definition);
    return writer_.add_channel(connection.topic, schema, ros1 ? "ros1" : "cdr");
  }
  void write(std::uint32_t connection, TimeNs time, std::span<const std::uint8_t> bytes) override {
    writer_.write(static_cast<std::uint16_t>(connection), time, {bytes.begin(), bytes.end()});
  }
  void close() override { write_bytes(path_, writer_.close()); }

 private:
  std::filesystem::path path_;
  McapWriter writer_;
};

}  // namespace

std::unique_ptr<MessageWriter> mcap_writer(const std::filesystem::path& path, const McapOptions& options) {
  return std::make_unique<McapFile>(path, options);
}

std::vector<std::uint8_t> cloud_message(TimeNs stamp) {
  rosbag::CloudLayout layout;
  constexpr std::uint32_t kPoints = 40, kStep = 22;
  layout.width = kPoints;
  layout.point_step = kStep;
  layout.row_step = kPoints * kStep;
  layout.fields = {{"x", 0, 7}, {"y", 4, 7}, {"z", 8, 7}, {"intensity", 12, 7}, {"ring", 16, 4}, {"time", 18, 7}};
  std::vector<std::uint8_t> data(kPoints * kStep), out;
  for (std::uint32_t i = 0; i < kPoints; ++i) {
    const std::uint16_t ring = static_cast<std::uint16_t>(i % 16);
    const float values[] = {3.0F + 0.1F * static_cast<float>(i), -1.0F, 0.3F, 7.0F};
    const float time = 0.0025F * static_cast<float>(i);
    std::memcpy(data.data() + i * kStep, values, sizeof(values));
    std::memcpy(data.data() + i * kStep + 16, &ring, 2);
    std::memcpy(data.data() + i * kStep + 18, &time, 4);
  }
  rosbag::encode_point_cloud2({0, stamp, "velodyne"}, layout, data, out);
  return out;
}

void rewrite(const std::filesystem::path& bag, MessageWriter& writer) {
  rosbag::BagReader reader(bag);
  copy_messages(reader, writer, Encoding::cdr);
  writer.close();
}

void split_by_topic(const std::filesystem::path& bag, const std::filesystem::path& folder) {
  rosbag::BagReader reader(bag);
  const std::vector<Connection> connections = reader.connections();
  for (const Connection& c : connections) {
    std::string name = c.topic.substr(1);
    std::replace(name.begin(), name.end(), '/', '_');
    rosbag::BagWriter writer(folder / (name + ".bag"));
    const std::uint32_t id = writer.add(c);
    reader.select({&c.id, 1});
    for (RawMessage message; reader.next(message);) writer.write(id, message.time, message.bytes);
    writer.close();
  }
}

std::vector<std::uint8_t> packed_zstd(const std::vector<std::uint8_t>& bytes) {
  std::vector<std::uint8_t> out(ZSTD_compressBound(bytes.size()));
  out.resize(ZSTD_compress(out.data(), out.size(), bytes.data(), bytes.size(), 3));
  return out;
}

}  // namespace aslio::io::test
