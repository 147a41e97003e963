/// The studies of this repository.

#include <algorithm>
#include <catch2/catch.hpp>

#include "aslio/plugin/registry.hpp"
#include "register_all.hpp"
#include "study_files.hpp"

using namespace aslio::test;
using namespace aslio::experiment;

namespace fs = std::filesystem;

namespace {

std::vector<std::string> shipped() {
  std::vector<std::string> files;
  for (const auto& entry : fs::directory_iterator(fs::path(ASLIO_SOURCE_DIR) / "experiments")) {
    if (entry.path().extension() == ".yaml") files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

}  // namespace

TEST_CASE("every shipped study is valid, with all its scenes, pipelines and overrides") {
  const std::vector<std::string> files = shipped();
  REQUIRE(files.size() >= 10);
  std::vector<std::string> arguments = {"check"};
  arguments.insert(arguments.end(), files.begin(), files.end());
  const Ended ended = run_aslio(arguments);
  INFO(ended.err);
  CHECK(ended.code == 0);
  CHECK(line_count(files.front()) > 10);
}

TEST_CASE("no two methods of a shipped study are the same pipeline") {
  aslio::plugin::Catalog catalog;
  aslio::plugins::register_all(catalog);
  StudyReading reading;
  reading.resolve_scene = [](const fs::path& scene, const std::vector<std::string>&) {
    return ResolvedScene{.text = scene.string(), .files = {}};
  };
  for (const std::string& file : shipped()) {
    const Study study = load_study(file, catalog, reading);
    for (std::size_t i = 0; i < study.methods.size(); ++i) {
      for (std::size_t j = 0; j < i; ++j) {
        INFO(file << ": " << study.methods[j].name << " and " << study.methods[i].name);
        CHECK(study.methods[i].resolved != study.methods[j].resolved);
      }
    }
  }
}
