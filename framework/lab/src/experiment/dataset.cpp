#include "aslio/experiment/dataset.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <system_error>
#include <utility>

#include "aslio/config/document.hpp"
#include "aslio/config/load.hpp"
#include "aslio/config/named_paths.hpp"
#include "aslio/core/errors.hpp"
#include "aslio/plugin/registry.hpp"
#include "matching_paths.hpp"

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

/// Which of the two forms of `input` and `reference` the file has.
void note_forms(const std::string& text, const std::string& source, DatasetConfig& config) {
  const config::Node root = config::parse_document(text, source);
  const config::Member* reference = root.is_map() ? root.find("reference") : nullptr;
  config.reference_as_text = reference == nullptr || !reference->value.is_map();
  const config::Member* input = root.is_map() ? root.find("input") : nullptr;
  config.input_as_text = input == nullptr || !input->value.is_list();
}

/// A file may have such characters in its name.
bool is_input_pattern(const fs::path& folder, const std::string& input) {
  std::error_code ignored;
  return is_pattern(input) && !fs::exists(folder / input, ignored);
}

/// A pattern is checked by what it matches, any other path as every path is.
void require_inputs(config::Binder& b, const std::vector<std::string>& inputs, const config::NamedPaths& paths,
                    const fs::path& folder) {
  for (const std::string& input : inputs) {
    if (!is_input_pattern(folder, input)) {
      paths.require(b, "input", input, config::NamedPaths::Wanted::file_or_folder);
    } else {
      b.require(!matching_paths(folder, input).empty(), "input",
                "matches nothing (patterns are relative to the folder of this file)");
    }
  }
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
  const std::string_view input =
      "recording: a bag (.bag, .mcap, .db3), a network capture, a folder or pattern of parts, or a folder of files; "
      "several are read as one; a path may stand for a list of one; required";
  if (dataset.input_as_text) {
    std::string path = dataset.input.empty() ? std::string() : dataset.input.front();
    b.text("input", path, input);
    dataset.input.clear();
    if (!path.empty()) dataset.input.push_back(std::move(path));
  } else {
    b.texts("input", dataset.input, {}, input);
  }
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
  const bool no_empty = std::find(dataset.input.begin(), dataset.input.end(), "") == dataset.input.end();
  b.require(!dataset.input.empty() && no_empty, "input", "is required: name the bag, or the folder of the drive");
  b.require(!dataset.sensor.empty(), "sensor",
            "is required: name the sensor file that fits the input (configs/sensors has some)");
}

Dataset load_dataset(const fs::path& path) {
  Dataset dataset;
  dataset.file = dataset_file(path);
  const config::NamedPaths paths(dataset.file.parent_path());
  DatasetConfig config;
  const std::string text = config::read_text(dataset.file);
  note_forms(text, dataset.file.string(), config);
  using Wanted = config::NamedPaths::Wanted;
  dataset.resolved =
      config::bind_text(text, dataset.file.string(), config::FileKind::dataset, plugin::Catalog(), {},
                        [&](config::Binder& b) {
                          DatasetConfig::describe(b, config);
                          require_inputs(b, config.input, paths, dataset.file.parent_path());
                          paths.require(b, "sensor", config.sensor, Wanted::file);
                          // A folder is a recording: the block says so.
                          paths.require(b, "reference", config.reference.file,
                                        config.reference_as_text ? Wanted::file : Wanted::file_or_folder);
                        })
          .resolved;
  dataset.name = config.name.empty() ? default_name(dataset.file) : config.name;
  dataset.description = config.description;
  for (const std::string& input : config.input) {
    const fs::path folder = dataset.file.parent_path();
    dataset.inputs.push_back(is_input_pattern(folder, input) ? pattern_in(folder, input) : paths.at(input));
  }
  dataset.sensor = paths.at(config.sensor);
  dataset.reference = reference_of(config, paths);
  dataset.section = {config.start, config.duration};
  dataset.closed_loop = config.closed_loop;
  return dataset;
}

}  // namespace aslio::experiment
