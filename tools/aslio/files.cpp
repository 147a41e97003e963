#include "files.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "aslio/config/load.hpp"
#include "aslio/config/named_paths.hpp"
#include "aslio/core/errors.hpp"
#include "aslio/core/sha256.hpp"
#include "aslio/experiment/dataset.hpp"
#include "aslio/experiment/external_method.hpp"
#include "aslio/experiment/family.hpp"
#include "aslio/experiment/study.hpp"
#include "aslio/experiment/study_placeholders.hpp"
#include "aslio/io/reference.hpp"
#include "aslio/io/sensor_file.hpp"
#include "aslio/pipeline/odometry.hpp"
#include "aslio/plugin/registry.hpp"
#include "aslio/simulator/scene.hpp"
#include "aslio/simulator/version.hpp"
#include "dataset_options.hpp"

namespace aslio::cli {

namespace {

/// What a scene reads besides, told with its place where it is not there. (Here, not where scenes are loaded: what
/// changes there makes all simulated data those of another simulator.)
void require_scene_files(const std::filesystem::path& path, const std::vector<std::string>& texts) {
  std::vector<config::Override> overrides;
  for (const std::string& text : texts) overrides.push_back({text});
  simulator::Scene scene;
  const config::NamedPaths paths(path.parent_path());
  const plugin::Catalog no_stages;
  config::bind_text(config::read_text(path), path.string(), config::FileKind::scene, no_stages, overrides,
                    [&](config::Binder& b) {
                      simulator::Scene::describe(b, scene);
                      paths.require(b, "follow", scene.follow.file, config::NamedPaths::Wanted::file);
                      paths.require(b, "world", scene.world.mesh.file, config::NamedPaths::Wanted::file);
                    });
}

CheckedFile checked_sensor(const std::filesystem::path& file, const config::StageLookup& stages) {
  CheckedFile checked{config::FileKind::sensor, {}};
  auto loaded = io::load_sensor(file, stages);
  checked.resolved = std::move(loaded.resolved);
  if (!loaded.value.placeholder_warning.empty()) checked.warnings.push_back(loaded.value.placeholder_warning);
  return checked;
}

/// A family with the sensor files that it names.
CheckedFile checked_family(const std::filesystem::path& file, const config::StageLookup& stages) {
  const experiment::Family family = experiment::load_family(file);
  CheckedFile checked{config::FileKind::family, family.resolved};
  for (const experiment::FamilySequence& sequence : family.sequences) {
    for (std::string& warning : checked_sensor(sequence.sensor, stages).warnings) {
      const bool known = std::find(checked.warnings.begin(), checked.warnings.end(), warning) != checked.warnings.end();
      if (!known) checked.warnings.push_back(std::move(warning));
    }
  }
  return checked;
}

CheckedFile checked_study(const std::filesystem::path& file, const config::StageLookup& stages) {
  experiment::Study study = experiment::load_study(
      file, stages, {.resolve_scene = resolve_scene, .seeds = {}, .scale = 1, .families = shipped_families()});
  return {config::FileKind::study, std::move(study.resolved), experiment::placeholder_warnings(study)};
}

}  // namespace

CheckedFile read_checked(const std::filesystem::path& file, const config::StageLookup& stages) {
  const config::FileKind kind = config::peek_kind(file);
  switch (kind) {
    case config::FileKind::pipeline:
      return {kind, config::load<pipeline::PipelineConfig>(file, kind, stages).resolved};
    case config::FileKind::sensor:
      return checked_sensor(file, stages);
    case config::FileKind::dataset:
      return {kind, experiment::load_dataset(file).resolved};
    case config::FileKind::family:
      return checked_family(file, stages);
    case config::FileKind::reference:
      return {kind, io::resolved_text(io::load_reference_spec(file))};
    case config::FileKind::external:
      return {kind, experiment::resolved_text(experiment::load_external_method(file))};
    case config::FileKind::scene:
      require_scene_files(file, {});
      return {kind, simulator::load_scene(file).resolved};
    case config::FileKind::study:
      return checked_study(file, stages);
  }
  throw ConfigError(fmt::format("{}: this version cannot read such a file", file.string()));
}

experiment::ResolvedScene resolve_scene(const std::filesystem::path& scene, const std::vector<std::string>& overrides) {
  require_scene_files(scene, overrides);
  const simulator::SceneFile file = simulator::load_scene(scene, overrides);
  experiment::ResolvedScene out{.text = fmt::format("{}\nsimulator {}", file.resolved, simulator::sources_digest()),
                                .files = {}};
  for (const std::string& read : {file.scene.follow.file, file.scene.world.mesh.file}) {
    if (read.empty()) continue;
    out.files.push_back(scene.parent_path() / read);
    out.text.append("\n").append(sha256_of_file(out.files.back()));
  }
  return out;
}

}  // namespace aslio::cli
