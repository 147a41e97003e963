#pragma once
/// How a simulator writes a sequence of a family: the block `stand_in` of a family file, and what the rest of the file
/// says of files, topics, stamps, units and frames (docs/stand_ins.md).

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "aslio/experiment/family.hpp"
#include "aslio/io/layout.hpp"
#include "aslio/io/source.hpp"

namespace aslio::experiment {

/// What to write, and for which sensor.
struct StandIn {
  io::Layout layout;
  bool sensor_noise = true;            ///< the IMU has the noise of `sensor`
  io::SensorConfig sensor;             ///< that of the sequence
  std::int64_t columns = 0;            ///< firings per turn of a spinning LiDAR, as the simulator can have them
  std::int64_t published_columns = 0;  ///< the same of the published sensor; 0: not known
};

/// Throws ConfigError that names the family file and the key for a sequence that cannot be written.
StandIn stand_in_of(const Family& family, const FamilySequence& sequence);

}  // namespace aslio::experiment
