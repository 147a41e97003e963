#pragma once
/// A recording with what belongs to it: what `aslio run --dataset` takes in place of --input, --sensor and --reference.

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "aslio/experiment/published_extrinsic.hpp"
#include "aslio/io/reference.hpp"
#include "aslio/io/source.hpp"

namespace aslio::config {
class Binder;
}

namespace aslio::experiment {

/// Dataset file (`schema: aslio/dataset/1`). Paths are relative to the folder of the file.
struct DatasetConfig {
  std::string name;                ///< empty: that of the file, or of its folder when the file is dataset.yaml
  std::string description;         ///< for people
  std::vector<std::string> input;  ///< recordings that are one, folders or patterns of their parts
  bool input_as_text = false;      ///< the key holds one path, no list
  std::string sensor;              ///< sensor file
  io::ReferenceSpec reference;     ///< without a file: none
  bool reference_as_text = false;  ///< the key holds the path alone, or that of a reference file
  double start = 0;                ///< of the data to skip [s]
  std::optional<double> duration;  ///< of the data to use [s]; all if absent
  bool closed_loop = false;        ///< the motion ends in the pose in which it begins
  static void describe(config::Binder& b, DatasetConfig& dataset);
};

/// The sequence of a published data set that a recording is.
struct PublishedSequence {
  std::string family, sequence;
  std::filesystem::path data;                  ///< folder of the user
  std::string extrinsic_source;                ///< of the sensor file's T_imu_lidar; empty: not known
  std::vector<PublishedExtrinsic> extrinsics;  ///< all that are published; the first one is that of the sensor file
  std::int64_t sweeps = 0, imu_samples = 0;    ///< published; 0: not known
};

/// A dataset file or a sequence of a family, with its paths resolved; everything it names exists.
struct Dataset {
  std::filesystem::path file;
  std::string name, description;
  std::vector<std::filesystem::path> inputs;  ///< one at least; patterns among them
  std::filesystem::path sensor;
  std::optional<io::ReferenceSpec> reference;
  io::Section section;
  bool closed_loop = false;
  std::optional<PublishedSequence> published;  ///< where it is of a family
  std::string resolved;                        ///< YAML with every key at its effective value
};

/// Reads a dataset file, or `dataset.yaml` of a folder. Throws ConfigError with everything that is wrong, what is named
/// there and does not exist included: file, line, column, remedy.
Dataset load_dataset(const std::filesystem::path& path);

}  // namespace aslio::experiment
