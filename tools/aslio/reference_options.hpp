#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <vector>

#include "aslio/core/errors.hpp"
#include "aslio/io/reference.hpp"

namespace aslio::cli {

/// --reference and --reference-set; returns the first.
inline CLI::Option* add_reference_options(CLI::App& app, std::string& path, std::vector<std::string>& sets) {
  app.add_option("--reference-set", sets,
                 "key=value (YAML) of the reference, as `aslio describe reference` lists them: time_unit=ns, "
                 "lever_arm=[0.1, 0, 0.2], protocol=ntu_viral; may be repeated")
      ->type_name("KEY=VALUE")
      ->allow_extra_args(false);
  return app
      .add_option("--reference", path,
                  "the truth to measure the error against: trajectory (TUM, EuRoC, KITTI), table, recording, or "
                  "reference file (schema: aslio/reference/1)")
      ->check(CLI::ExistingPath);
}

/// What the two options make of the reference of a dataset, if it has one. Throws ConfigError for sets without any.
inline std::optional<io::ReferenceSpec> chosen_reference(std::optional<io::ReferenceSpec> of_dataset,
                                                         const std::string& path,
                                                         const std::vector<std::string>& sets) {
  if (!path.empty()) return io::load_reference_spec(path, sets);
  if (of_dataset) return io::with_overrides(*of_dataset, sets);
  if (sets.empty()) return std::nullopt;
  throw ConfigError("--reference-set changes a reference, and there is none: give --reference, or a dataset with one");
}

}  // namespace aslio::cli
