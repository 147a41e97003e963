#include "study_files.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "aslio/core/errors.hpp"
#include "aslio/plugin/registry.hpp"
#include "register_all.hpp"

namespace aslio::test {

namespace {

/// "reads FILE" is one of its lines where it reads another.
experiment::ResolvedScene read_scene(const std::filesystem::path& scene, const std::vector<std::string>& overrides) {
  if (!std::filesystem::exists(scene)) throw ConfigError(scene.string() + ": cannot be opened");
  experiment::ResolvedScene out{.text = content(scene), .files = {}};
  for (const std::string& assignment : overrides) out.text.append("\n").append(assignment);
  if (out.text.starts_with("reads ")) out.files = {scene.parent_path() / out.text.substr(6, out.text.find('\n') - 6)};
  return out;
}

}  // namespace

std::string head() { return "schema: aslio/study/1\nquestion: Which?\nprediction: This one.\nrule: The lower.\n"; }

std::string method(const std::string& name, const std::string& pipeline, const std::string& more) {
  const std::string file = std::string(ASLIO_SOURCE_DIR) + "/configs/pipelines/" + pipeline + ".yaml";
  return "  - {name: " + name + ", pipeline: " + file + (more.empty() ? "" : ", " + more) + "}\n";
}

void write_small_scene(const TemporaryFolder& folder) {
  std::string mesh;
  for (const char* x : {"-4", "5"}) {
    for (const char* y : {"-3", "3.5"}) {
      for (const char* z : {"-1.2", "1.6"}) mesh += std::string("v ") + x + " " + y + " " + z + "\n";
    }
  }
  for (const char* face : {"1 3 4 2", "5 7 8 6", "1 2 6 5", "3 4 8 7", "1 3 7 5", "2 4 8 6"}) {
    mesh += std::string("f ") + face + "\n";
  }
  write_text(folder / "room.obj", mesh);
  std::string walk;
  for (int k = 0; k <= 60; ++k) {
    const double t = 0.05 * k, s = std::max(0.0, t - 0.4), yaw = 0.8 * std::pow(std::sin(1.2 * s), 2);
    for (const double value : {t, 0.5 * std::pow(std::sin(0.8 * s), 2), 0.3 * std::pow(std::sin(1.5 * s), 2),
                               0.1 * std::pow(std::sin(1.1 * s), 2), 0.0, 0.0, std::sin(yaw / 2)}) {
      walk += std::to_string(value) + " ";
    }
    walk += std::to_string(std::cos(yaw / 2)) + "\n";
  }
  write_text(folder / "walk.tum", walk);
  write_text(folder / "small.yaml",
             "schema: aslio/scene/1\nworld: {type: mesh, file: room.obj}\nfollow: {file: walk.tum}\n");
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
