#pragma once

#include "child.hpp"
#include "recordings.hpp"

namespace aslio::test {

/// A folder with a recording, a sensor file and a pipeline, and how to run them.
struct Bench {
  TemporaryFolder folder;

  explicit Bench(const Recording& recording = {}) {
    write_bag(folder / "recording.bag", recording);
    write_text(folder / "sensor.yaml", sensor_text());
    write_text(folder / "pipeline.yaml", pipeline_text());
  }
  std::vector<std::string> arguments(const std::string& output, const std::vector<std::string>& more = {}) const {
    std::vector<std::string> out = {"run",      folder / "pipeline.yaml", "--input",  folder / "recording.bag",
                                    "--sensor", folder / "sensor.yaml",   "--output", folder / output};
    out.insert(out.end(), more.begin(), more.end());
    return out;
  }
  Ended run(const std::string& output, const std::vector<std::string>& more = {}) const {
    return run_aslio(arguments(output, more));
  }
  std::filesystem::path operator/(const std::string& name) const { return folder / name; }
};

}  // namespace aslio::test
