#include "study_files.hpp"

#include "aslio/core/errors.hpp"
#include "aslio/plugin/registry.hpp"
#include "register_all.hpp"

namespace aslio::test {

namespace {

std::string read_scene(const std::filesystem::path& scene, const std::vector<std::string>& overrides) {
  if (!std::filesystem::exists(scene)) throw ConfigError(scene.string() + ": cannot be opened");
  std::string text = content(scene);
  for (const std::string& assignment : overrides) text.append("\n").append(assignment);
  return text;
}

}  // namespace

std::string head() { return "schema: aslio/study/1\nquestion: Which?\nprediction: This one.\nrule: The lower.\n"; }

std::string method(const std::string& name, const std::string& pipeline, const std::string& more) {
  const std::string file = std::string(ASLIO_SOURCE_DIR) + "/configs/pipelines/" + pipeline + ".yaml";
  return "  - {name: " + name + ", pipeline: " + file + (more.empty() ? "" : ", " + more) + "}\n";
}

StudyFiles::StudyFiles() {
  write_text(folder / "scene_a.yaml", "first\n");
  write_text(folder / "scene_b.yaml", "second\n");
}

experiment::Study StudyFiles::load(const std::string& text, const experiment::StudyReading& reading) const {
  write_text(folder / "study.yaml", text);
  plugin::Catalog catalog;
  plugins::register_all(catalog);
  experiment::StudyReading with_scenes = reading;
  with_scenes.resolve_scene = read_scene;
  return experiment::load_study(folder / "study.yaml", catalog, with_scenes);
}

std::string StudyFiles::complaint(const std::string& text) const {
  try {
    load(text);
  } catch (const ConfigError& error) {
    return error.what();
  }
  return {};
}

}  // namespace aslio::test
