#include <variant>

#include "aslio/io/inspect.hpp"
#include "aslio/io/source.hpp"
#include "fuzz/points.hpp"

ASLIO_FUZZ_TARGET(folder) {
  const auto& at =
      unpacked(bytes, {"lidar/0.bin", "lidar/1.bin", "lidar/1600000000000000000.bin", "lidar/1600000000100000000.pcd",
                       "lidar/1600000000.2.ply", "timestamps.txt", "imu.csv"});
  io::SensorConfig sensor;
  sensor.scan_columns = "x y z intensity time ring:u16";
  accepts([&] {
    const auto source = io::open_source(at, sensor);
    while (const auto measurement = source->next()) {
      if (const auto* packet = std::get_if<LidarPacket>(&*measurement)) must_be_returns(*packet);
    }
  });
  accepts([&] { must(!io::render(io::inspect(at, sensor)).empty(), "a report has text"); });
}
