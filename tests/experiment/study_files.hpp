#pragma once
/// A folder with a study file and what it names, and studies read from it.

#include <string>

#include "aslio/experiment/study.hpp"
#include "aslio/experiment/study_run.hpp"
#include "cli/child.hpp"

namespace aslio::test {

/// `{name: NAME, pipeline: configs/pipelines/PIPELINE.yaml of this repository, MORE}`, indented for `methods`.
std::string method(const std::string& name, const std::string& pipeline, const std::string& more = "");

/// small.yaml and what it reads: three seconds of swaying and turning in an empty room.
void write_small_scene(const TemporaryFolder& folder);

/// Keeps what a study tells, and never stops it.
class Quiet final : public experiment::StudyMonitor {
 public:
  void on_line(const std::string& line) override { lines += line + "\n"; }
  bool stop_requested() override { return false; }
  std::string lines;
};

/// The three texts that every study needs, in one line each, and the schema.
std::string head();

/// A folder with two files that stand for scenes, scene_a.yaml and scene_b.yaml.
struct StudyFiles {
  TemporaryFolder folder;

  StudyFiles();
  /// Reads `text` as study.yaml; a scene "resolves" to its content with its overrides.
  experiment::Study load(const std::string& text, const experiment::StudyReading& reading = {}) const;
  /// What load() complains of; empty: nothing.
  std::string complaint(const std::string& text) const;
};

}  // namespace aslio::test
