#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

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

}  // namespace aslio::cli
