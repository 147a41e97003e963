#include "files.hpp"

#include <fmt/format.h>

#include "aslio/core/errors.hpp"
#include "aslio/core/sha256.hpp"
#include "aslio/experiment/dataset.hpp"
#include "aslio/experiment/study.hpp"
#include "aslio/io/source.hpp"
#include "aslio/pipeline/odometry.hpp"
#include "aslio/simulator/scene.hpp"
#include "aslio/simulator/version.hpp"

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
    case config::FileKind::study:
      return {kind,
              experiment::load_study(file, stages, {.resolve_scene = resolve_scene, .seeds = {}, .scale = 1}).resolved};
  }
  throw ConfigError(fmt::format("{}: this version cannot read such a file", file.string()));
}

std::string resolve_scene(const std::filesystem::path& scene, const std::vector<std::string>& overrides) {
  const simulator::SceneFile file = simulator::load_scene(scene, overrides);
  std::string text = fmt::format("{}\nsimulator {}", file.resolved, simulator::sources_digest());
  for (const std::string& read : {file.scene.follow.file, file.scene.world.mesh.file}) {
    if (!read.empty()) text.append("\n").append(sha256_of_file(scene.parent_path() / read));
  }
  return text;
}

}  // namespace aslio::cli
