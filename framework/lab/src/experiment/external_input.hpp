#pragma once
/// What a program of others is given to read: the files of a recording as they are, or what this program reads of them,
/// written again in a form that it knows.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "aslio/experiment/dataset.hpp"
#include "aslio/experiment/external_method.hpp"
#include "aslio/io/source.hpp"

namespace aslio::experiment {

struct FedRecording {
  std::vector<std::filesystem::path> bags;
  std::string imu_topic, lidar_topic;
  std::string sensor;  ///< YAML of a sensor file that fits a copy; empty: there is none
  std::int64_t sweeps = 0, imu_samples = 0;
  TimeNs begin = 0, end = 0;  ///< of the points
  io::SourceNotes notes;
  bool truncated = false;
};

/// Reads the recording once, for its extent, and writes it into `folder` where the method asks for another form.
/// `stop`: asked between measurements. Throws DataError for what cannot be read or written, ConfigError for a section
/// of a recording that would be handed over whole.
FedRecording feed_recording(const Dataset& dataset, const io::SensorConfig& sensor, const ExternalMethod& method,
                            const std::filesystem::path& folder, const std::function<bool()>& stop);

}  // namespace aslio::experiment
