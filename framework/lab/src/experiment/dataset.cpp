#include "aslio/experiment/dataset.hpp"

#include <fmt/format.h>

#include <system_error>
#include <utility>

#include "aslio/config/load.hpp"
#include "aslio/config/named_paths.hpp"
#include "aslio/core/errors.hpp"
#include "aslio/plugin/registry.hpp"

namespace aslio::experiment {

namespace {

namespace fs = std::filesystem;

constexpr double kMaxSeconds = 1e9;  // some 30 years; in nanoseconds it still fits

/// The file that stands for `path`.
fs::path dataset_file(const fs::path& path) {
  std::error_code ignored;
  if (!fs::is_directory(path, ignored)) return path;
  fs::path file = path / "dataset.yaml";
  if (fs::exists(file, ignored)) return file;
  throw ConfigError(
      fmt::format("{}: the folder has no dataset.yaml; `aslio simulate` writes it last, when all other files are "
                  "complete. Name another folder or a dataset file",
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
  b.text("name", dataset.name, "name in tables; empty: the name of the file, or of its folder for dataset.yaml");
  b.text("description", dataset.description, "what the recording is");
  b.text("input", dataset.input,
         "recording: a bag (.bag, .db3), a folder of its parts, or a KITTI raw drive; required");
  b.text("sensor", dataset.sensor, "sensor file that fits the input; required");
  b.text("reference", dataset.reference, "reference trajectory (TUM, T_W_I); empty: none");
  b.real("start", dataset.start, "s", {.min = 0.0, .max = kMaxSeconds}, "data to skip");
  b.optional_real("duration", dataset.duration, "s", {.above = 0.0, .max = kMaxSeconds}, "to the end", "data to use");
  b.flag("closed_loop", dataset.closed_loop,
         "whether the motion ends in the pose in which it begins. Only then is end_to_end_m measured: else the "
         "distance between the ends is no error");
  b.require(!dataset.input.empty(), "input", "is required: name the bag, or the folder of the drive");
  b.require(!dataset.sensor.empty(), "sensor",
            "is required: name the sensor file that fits the input (configs/sensors has some)");
}

Dataset load_dataset(const fs::path& path) {
  Dataset dataset;
  dataset.file = dataset_file(path);
  const config::NamedPaths paths(dataset.file.parent_path());
  DatasetConfig config;
  dataset.resolved =
      config::bind_text(config::read_text(dataset.file), dataset.file.string(), config::FileKind::dataset,
                        plugin::Catalog(), {},
                        [&](config::Binder& b) {
                          DatasetConfig::describe(b, config);
                          paths.require(b, "input", config.input, config::NamedPaths::Wanted::file_or_folder);
                          paths.require(b, "sensor", config.sensor, config::NamedPaths::Wanted::file);
                          paths.require(b, "reference", config.reference, config::NamedPaths::Wanted::file);
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
