#include "files.hpp"

#include <fmt/format.h>

#include "aslio/core/errors.hpp"
#include "aslio/experiment/dataset.hpp"
#include "aslio/io/source.hpp"
#include "aslio/pipeline/odometry.hpp"
#include "aslio/simulator/scene.hpp"

namespace aslio::cli {

CheckedFile read_checked(const std::filesystem::path& file, const config::StageLookup& stages) {
  const config::FileKind kind = config::peek_kind(file);
  switch (kind) {
    case config::FileKind::pipeline:
      return {kind, config::load<pipeline::PipelineConfig>(file, kind, stages).resolved};
    case config::FileKind::sensor:
      return {kind, config::load<io::SensorConfig>(file, kind, stages).resolved};
    case config::FileKind::dataset:
      return {kind, experiment::load_dataset(file).resolved};
    case config::FileKind::scene:
      return {kind, simulator::load_scene(file).resolved};
    default:
      throw ConfigError(
          fmt::format("{}: this version cannot read a {} file; it reads pipeline, sensor, dataset and scene "
                      "files",
                      file.string(), config::name(kind)));
  }
}

}  // namespace aslio::cli
