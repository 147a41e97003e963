#include "dataset_options.hpp"

#include <fmt/format.h>

#include <system_error>

#include "aslio/config/load.hpp"
#include "aslio/core/errors.hpp"
#include "aslio/experiment/family.hpp"
#include "data_folder.hpp"

namespace aslio::cli {

namespace {

namespace fs = std::filesystem;

/// A dataset file or folder; of what is none, what it was probably meant to be.
experiment::Dataset dataset_at(const std::string& path) {
  std::error_code ignored;
  if (fs::exists(path, ignored)) {
    if (fs::is_regular_file(path, ignored) && config::peek_kind(path) == config::FileKind::family) {
      throw ConfigError(
          fmt::format("--dataset {0}: is a family file; name a sequence of it and the folder of the data: "
                      "--dataset {0}/SEQUENCE --data DIR (`aslio datasets {0}` lists them)",
                      path));
    }
    return experiment::load_dataset(path);
  }
  const auto name = experiment::parse_family_name(path);
  if (!name) {
    throw ConfigError(
        fmt::format("--dataset {}: does not exist; give a dataset file, a folder with dataset.yaml, or FAMILY/SEQUENCE "
                    "with --data DIR (`aslio datasets` lists the families)",
                    path));
  }
  const experiment::Family family = [&] {
    try {
      return experiment::load_family(experiment::find_family(name->family, shipped_families()));
    } catch (const ConfigError& error) {
      throw ConfigError(fmt::format("--dataset {}: does not exist; as FAMILY/SEQUENCE: {}", path, error.what()));
    }
  }();
  experiment::find_sequence(family, name->sequence);
  throw ConfigError(
      fmt::format("--dataset {}: needs --data DIR, the folder with the files of {}; `aslio datasets {}` shows which",
                  path, family.name, name->family));
}

}  // namespace

fs::path shipped_families() { return data_path("configs") / "datasets"; }

void add_dataset_options(CLI::App& app, std::string& dataset, std::string& data) {
  app.add_option("--dataset", dataset,
                 "dataset file (schema: aslio/dataset/1) or a folder with dataset.yaml: names input, sensor, reference "
                 "and section; other options override it. With --data: FAMILY/SEQUENCE of a published data set "
                 "(`aslio datasets` lists them)");
  app.add_option("--data", data, "folder with the files of the published data set that --dataset names");
}

experiment::Dataset find_dataset(const std::string& dataset, const std::string& data) {
  if (data.empty()) return dataset_at(dataset);
  const auto name = experiment::parse_family_name(dataset);
  if (!name) {
    throw ConfigError(
        fmt::format("--dataset {}: with --data it is FAMILY/SEQUENCE, as in newer_college_2021/quad_hard "
                    "(`aslio datasets` lists the families)",
                    dataset));
  }
  const experiment::Family family = experiment::load_family(experiment::find_family(name->family, shipped_families()));
  return experiment::dataset_of(family, experiment::find_sequence(family, name->sequence), data);
}

}  // namespace aslio::cli
