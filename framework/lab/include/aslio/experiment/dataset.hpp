#pragma once
/// A recording with what belongs to it: what `aslio run --dataset` takes in place of --input, --sensor and --reference.

#include <filesystem>
#include <optional>
#include <string>

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
  std::string input;               ///< a recording, or a folder of its parts
  std::string sensor;              ///< sensor file
  io::ReferenceSpec reference;     ///< without a file: none
  bool reference_as_text = false;  ///< the key holds the path alone, or that of a reference file
  double start = 0;                ///< of the data to skip [s]
  std::optional<double> duration;  ///< of the data to use [s]; all if absent
  bool closed_loop = false;        ///< the motion ends in the pose in which it begins
  static void describe(config::Binder& b, DatasetConfig& dataset);
};

/// A dataset file with its paths resolved; everything it names exists.
struct Dataset {
  std::filesystem::path file;
  std::string name, description;
  std::filesystem::path input, sensor;
  std::optional<io::ReferenceSpec> reference;
  io::Section section;
  bool closed_loop = false;
  std::string resolved;  ///< YAML with every key at its effective value
};

/// Reads a dataset file, or `dataset.yaml` of a folder. Throws ConfigError with everything that is wrong, what is named
/// there and does not exist included: file, line, column, remedy.
Dataset load_dataset(const std::filesystem::path& path);

}  // namespace aslio::experiment
