#include <variant>

#include "aslio/io/inspect.hpp"
#include "aslio/io/source.hpp"
#include "fuzz/points.hpp"

ASLIO_FUZZ_TARGET(recording) {
  const auto path = written("input.bag", bytes);
  for (const bool timed : {true, false}) {
    io::SensorConfig sensor;
    sensor.require_point_times = timed;
    accepts([&] {
      const auto source = io::open_source(path, sensor);
      while (const auto measurement = source->next()) {
        if (const auto* packet = std::get_if<LidarPacket>(&*measurement)) must_be_returns(*packet);
      }
    });
  }
  accepts([&] { must(!io::render(io::inspect(path)).empty(), "a report has text"); });
}
