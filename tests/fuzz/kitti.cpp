#include <variant>

#include "aslio/io/inspect.hpp"
#include "aslio/io/source.hpp"
#include "fuzz/points.hpp"

ASLIO_FUZZ_TARGET(kitti) {
  const auto& at = unpacked(
      bytes, {"calib_imu_to_velo.txt", "oxts/timestamps.txt", "oxts/data/0000000000.txt", "oxts/data/0000000001.txt",
              "velodyne_points/timestamps_start.txt", "velodyne_points/timestamps_end.txt",
              "velodyne_points/data/0000000000.bin", "velodyne_points/data/0000000001.bin"});
  accepts([&] {
    io::SensorConfig sensor;
    sensor.from_file = true;
    const auto source = io::open_source(at, sensor);
    while (const auto measurement = source->next()) {
      if (const auto* packet = std::get_if<LidarPacket>(&*measurement)) must_be_returns(*packet);
    }
  });
  accepts([&] { must(!io::render(io::inspect(at)).empty(), "a report has text"); });
}
