#pragma once
/// PointCloud2 messages made to measure, and recordings of them.

#include <cstring>
#include <functional>
#include <string>
#include <vector>

#include "io/bag_fixture.hpp"

namespace aslio::io::test {

inline constexpr int kPoints = 50;
inline constexpr std::uint8_t kU8 = 2, kU16 = 4, kI32 = 5, kU32 = 6, kF32 = 7, kF64 = 8, kI64 = 9, kU64 = 10,
                              kBool = 11;

struct Cloud {
  rosbag::CloudLayout layout;
  std::vector<std::uint8_t> data;

  void field(const std::string& name, std::uint32_t offset, std::uint8_t datatype) {
    layout.fields.push_back({name, offset, datatype, 1});
  }
  template <class T>
  void put(int point, std::uint32_t offset, T value) {
    std::memcpy(data.data() + static_cast<std::size_t>(point) * layout.point_step + offset, &value, sizeof(T));
  }
  void size(std::uint32_t step, int points = kPoints) {
    layout.point_step = step;
    layout.width = static_cast<std::uint32_t>(points);
    layout.row_step = step * layout.width;
    data.assign(layout.row_step, 0);
    field("x", 0, kF32);
    field("y", 4, kF32);
    field("z", 8, kF32);
    for (int i = 0; i < points; ++i) {
      put(i, 0, 3.0F + static_cast<float>(i));
      put(i, 4, 1.0F);
      put(i, 8, 0.5F);
    }
  }
  std::vector<std::uint8_t> message(TimeNs stamp) const {
    std::vector<std::uint8_t> out;
    rosbag::encode_point_cloud2({0, stamp, "lidar"}, layout, data, out);
    return out;
  }
};

/// Time of point i after the begin of the sweep [ns]: 0 to 98 ms.
inline TimeNs offset_of(int i) { return i * 2'000'000; }

inline Recording recording_of(std::function<Cloud(TimeNs stamp)> make) {
  Recording recording;
  recording.seconds = 0.5;
  recording.lidar_type = rosbag::kPointCloud2;
  recording.lidar_topic = "/points";
  recording.lidar = [make = std::move(make)](int, TimeNs stamp) { return make(stamp).message(stamp); };
  return recording;
}

inline LidarPacket first_packet(MeasurementSource& source) {
  while (auto measurement = source.next()) {
    if (auto* packet = std::get_if<LidarPacket>(&*measurement)) return std::move(*packet);
  }
  return {};
}

inline std::string refusal(const Recording& recording, const SensorConfig& sensor = {}) {
  TemporaryFolder folder;
  recording.write(folder / "a.bag");
  return data_error([&] { open_source(folder / "a.bag", sensor); });
}

/// A float32 time of the given value per point.
inline Cloud with_f32_time(const std::function<float(int)>& value, const std::string& name = "time") {
  Cloud cloud;
  cloud.size(22);
  cloud.field("intensity", 12, kF32);
  cloud.field("ring", 16, kU16);
  cloud.field(name, 18, kF32);
  for (int i = 0; i < kPoints; ++i) cloud.put(i, 18, value(i));
  return cloud;
}

}  // namespace aslio::io::test
