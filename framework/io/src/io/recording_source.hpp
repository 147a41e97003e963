#pragma once
/// The LiDAR and IMU messages of a recording as measurements: chooses the topics, judges units, point times and clocks
/// by the first messages, then decodes.

#include <memory>
#include <string>

#include "aslio/io/message_reader.hpp"
#include "aslio/io/source.hpp"

namespace aslio::io {

/// `name`: of the recording, for messages. Throws DataError where it cannot be used.
std::unique_ptr<MeasurementSource> open_recording(std::string name, std::unique_ptr<MessageReader> reader,
                                                  const SensorConfig& sensor, const Section& section);

}  // namespace aslio::io
