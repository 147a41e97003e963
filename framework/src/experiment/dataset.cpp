#include "aslio/experiment/dataset.hpp"

#include <fmt/format.h>

#include <system_error>
#include <utility>

#include "aslio/config/load.hpp"
#include "aslio/core/errors.hpp"
#include "aslio/plugin/registry.hpp"

namespace aslio::experiment {

namespace {

namespace fs = std::filesystem;

constexpr double kMostSeconds = 1e9;  // some 30 years; in nanoseconds it still fits

enum class Wanted : std::uint8_t { file, file_or_folder };

/// What is wrong with a path that is named in the file; empty: nothing.
std::string trouble(const fs::path& path, Wanted wanted) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (status.type() == fs::file_type::not_found) {
    return fmt::format("does not exist: {} (paths are relative to the folder of this file)", path.string());
  }
  if (status.type() == fs::file_type::none)
    return fmt::format("cannot be reached: {}: {}", path.string(), error.message());
  const bool folder = fs::is_directory(status);
  if (wanted == Wanted::file && folder) return fmt::format("is a folder: {} (name a file)", path.string());
  if (!folder && !fs::is_regular_file(status)) {
    return fmt::format("is no regular file: {} (pipes and devices cannot be read twice)", path.string());
  }
  return {};
}

/// The checks that need the folder of the file.
class Paths {
 public:
  explicit Paths(fs::path folder) : folder_(std::move(folder)) {}

  fs::path at(const std::string& written) const { return (folder_ / written).lexically_normal(); }

  void require(config::Binder& b, std::string_view key, const std::string& written, Wanted wanted) const {
    if (written.empty()) return;  // whether it has to be there is for DatasetConfig::describe() to say
    const std::string wrong = trouble(at(written), wanted);
    b.require(wrong.empty(), key, wrong);
  }

 private:
  fs::path folder_;
};

/// The file that stands for `path`.
fs::path dataset_file(const fs::path& path) {
  std::error_code ignored;
  if (!fs::is_directory(path, ignored)) return path;
  fs::path file = path / "dataset.yaml";
  if (fs::exists(file, ignored)) return file;
  throw ConfigError(
      fmt::format("{}: the folder has no dataset.yaml; `aslio simulate` writes one last, when all other files are "
                  "whole. Name another folder or a dataset file",
                  path.string()));
}

std::string default_name(const fs::path& file) {
  if (file.filename() != "dataset.yaml") return file.stem().string();
  std::error_code ignored;
  const fs::path folder = fs::absolute(file, ignored).lexically_normal().parent_path();
  return folder.filename().string();
}

}  // namespace

void DatasetConfig::describe(config::Binder& b, DatasetConfig& dataset) {
  b.text("name", dataset.name, "what tables call it; empty: the name of the file, or of its folder for dataset.yaml");
  b.text("description", dataset.description, "what the recording is");
  b.text("input", dataset.input, "ROS1 bag, or KITTI raw drive folder; required");
  b.text("sensor", dataset.sensor, "sensor file that fits the input; required");
  b.text("reference", dataset.reference, "reference trajectory (TUM, T_W_I); empty: none");
  b.real("start", dataset.start, "s", {.min = 0.0, .max = kMostSeconds}, "data to skip");
  b.optional_real("duration", dataset.duration, "s", {.above = 0.0, .max = kMostSeconds}, "to the end", "data to use");
  b.flag("closed_loop", dataset.closed_loop,
         "whether the motion ends in the pose in which it begins: of others the distance between both ends is no "
         "error, and "
         "end_to_end_m is left out");
  b.require(!dataset.input.empty(), "input", "is required: name the bag, or the folder of the drive");
  b.require(!dataset.sensor.empty(), "sensor",
            "is required: name the sensor file that fits the input (configs/sensors has some)");
}

Dataset load_dataset(const fs::path& path) {
  Dataset dataset;
  dataset.file = dataset_file(path);
  const Paths paths(dataset.file.parent_path());
  DatasetConfig config;
  dataset.resolved = config::bind_text(config::read_text(dataset.file), dataset.file.string(),
                                       config::FileKind::dataset, plugin::Catalog(), {},
                                       [&](config::Binder& b) {
                                         DatasetConfig::describe(b, config);
                                         paths.require(b, "input", config.input, Wanted::file_or_folder);
                                         paths.require(b, "sensor", config.sensor, Wanted::file);
                                         paths.require(b, "reference", config.reference, Wanted::file);
                                       })
                         .resolved;
  dataset.name = config.name.empty() ? default_name(dataset.file) : config.name;
  dataset.description = config.description;
  dataset.input = paths.at(config.input);
  dataset.sensor = paths.at(config.sensor);
  if (!config.reference.empty()) dataset.reference = paths.at(config.reference);
  dataset.section = {config.start, config.duration};
  dataset.closed_loop = config.closed_loop;
  return dataset;
}

}  // namespace aslio::experiment
