#include "aslio/experiment/dataset.hpp"

#include <fmt/format.h>

#include <system_error>
#include <utility>

#include "aslio/config/document.hpp"
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

/// Whether the key holds a path in place of a block, or is left out.
bool names_reference_as_text(const std::string& text, const std::string& source) {
  const config::Node root = config::parse_document(text, source);
  const config::Member* reference = root.is_map() ? root.find("reference") : nullptr;
  return reference == nullptr || !reference->value.is_map();
}

/// What `config` names, its paths made those of the program.
std::optional<io::ReferenceSpec> reference_of(const DatasetConfig& config, const config::NamedPaths& paths) {
  if (config.reference.file.empty()) return std::nullopt;
  if (config.reference_as_text) return io::load_reference_spec(paths.at(config.reference.file));
  io::ReferenceSpec spec = config.reference;
  spec.file = paths.at(spec.file).string();
  if (!spec.times.empty()) spec.times = paths.at(spec.times).string();
  return spec;
}

}  // namespace

void DatasetConfig::describe(config::Binder& b, DatasetConfig& dataset) {
  b.text("name", dataset.name, "name in tables; empty: the name of the file, or of its folder for dataset.yaml");
  b.text("description", dataset.description, "what the recording is");
  b.text("input", dataset.input,
         "recording: a bag (.bag, .mcap, .db3), a network capture, a folder of parts, or a folder of files; required");
  b.text("sensor", dataset.sensor, "sensor file that fits the input; required");
  if (dataset.reference_as_text) {
    b.text("reference", dataset.reference.file, "trajectory, table, recording or reference file; empty: none");
  } else {
    b.group("reference", dataset.reference,
            "the truth; the path of a trajectory, table, recording or reference file may stand for the block");
  }
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
  const std::string text = config::read_text(dataset.file);
  config.reference_as_text = names_reference_as_text(text, dataset.file.string());
  using Wanted = config::NamedPaths::Wanted;
  dataset.resolved =
      config::bind_text(text, dataset.file.string(), config::FileKind::dataset, plugin::Catalog(), {},
                        [&](config::Binder& b) {
                          DatasetConfig::describe(b, config);
                          paths.require(b, "input", config.input, Wanted::file_or_folder);
                          paths.require(b, "sensor", config.sensor, Wanted::file);
                          // A folder is a recording: the block says so.
                          paths.require(b, "reference", config.reference.file,
                                        config.reference_as_text ? Wanted::file : Wanted::file_or_folder);
                        })
          .resolved;
  dataset.name = config.name.empty() ? default_name(dataset.file) : config.name;
  dataset.description = config.description;
  dataset.input = paths.at(config.input);
  dataset.sensor = paths.at(config.sensor);
  dataset.reference = reference_of(config, paths);
  dataset.section = {config.start, config.duration};
  dataset.closed_loop = config.closed_loop;
  return dataset;
}

}  // namespace aslio::experiment
