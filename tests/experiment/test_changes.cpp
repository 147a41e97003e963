/// Files of a study that change while it is at work.

#include <catch2/catch.hpp>

#include "aslio/core/sha256.hpp"
#include "aslio/experiment/study_run.hpp"
#include "study_files.hpp"

using namespace aslio::test;
using namespace aslio::experiment;
using Catch::Matchers::Contains;

namespace fs = std::filesystem;

namespace {

/// Writes to a file when the first run is told.
struct Writer final : StudyMonitor {
  explicit Writer(fs::path to) : file(std::move(to)) {}
  void on_line(const std::string& line) override {
    if (line.find("[1/") != std::string::npos) write_text(file, content(file) + "# changed\n");
  }
  bool stop_requested() override { return false; }
  fs::path file;
};

StudyOptions one_at_a_time(const fs::path& output) {
  StudyOptions how;
  how.output = output;
  how.jobs = 1;
  how.program = "program";
  how.executable = ASLIO_CHILD_PROGRAM;
  return how;
}

/// dataset.yaml and what it names; nothing is read of its points.
void write_recording(const StudyFiles& files) {
  const fs::path sensor = fs::path(ASLIO_SOURCE_DIR) / "configs/sensors/livox_avia.yaml";
  fs::copy(sensor, files.folder / "avia.yaml", fs::copy_options::overwrite_existing);
  write_text(files.folder / "points.bag", "none is read");
  write_text(files.folder / "truth.tum", "0 0 0 0 0 0 0 1\n");
  write_text(files.folder / "dataset.yaml",
             "schema: aslio/dataset/1\ninput: points.bag\nsensor: avia.yaml\nreference: truth.tum\nname: walk\n");
}

}  // namespace

TEST_CASE("a pipeline or a scene that changes ends the study, and no run stands under the old text") {
  const StudyFiles files;
  const std::string pipeline = content(std::string(ASLIO_SOURCE_DIR) + "/configs/pipelines/fixed_window.yaml");
  for (const std::string changed : {"own.yaml", "scene_c.yaml"}) {
    CAPTURE(changed);
    write_text(files.folder / "own.yaml", pipeline);
    write_text(files.folder / "scene_c.yaml", "third place\n");
    const Study study = files.load(head() +
                                   "datasets: [{scene: scene_a.yaml}, {scene: scene_b.yaml}, {scene: scene_c.yaml}]\n"
                                   "methods:\n  - {name: own, pipeline: own.yaml}\n");
    const StudyOptions how = one_at_a_time(files.folder / ("out_" + changed));
    Writer writer(files.folder / changed);
    CHECK_THROWS_WITH(run_study(study, how, writer), Contains(changed + ": has changed"));
    const auto rows = rows_so_far(study, plan_runs(study, how.program, fs::absolute(how.output) / "runs"), how.output);
    CHECK(rows[0].has_value());
    CHECK_FALSE(rows[2].has_value());  // of jobs + 1 scenes the data are made ahead
    CHECK_FALSE(fs::exists(how.output / "runs/scene_c_1/own"));
  }
}

TEST_CASE("a file of a recording that changes ends the study, too") {
  const StudyFiles files;
  for (const std::string changed : {"avia.yaml", "dataset.yaml", "truth.tum"}) {
    CAPTURE(changed);
    write_recording(files);
    const Study study = files.load(head() + "datasets: [{dataset: dataset.yaml}]\nmethods:\n" +
                                   method("first", "fixed_window") + method("second", "fixed_window"));
    const StudyOptions how = one_at_a_time(files.folder / ("out_" + changed));
    Writer writer(files.folder / changed);
    CHECK_THROWS_WITH(run_study(study, how, writer), Contains(changed + ": has changed"));
    CHECK(fs::exists(how.output / "runs/walk/first"));
    CHECK_FALSE(fs::exists(how.output / "runs/walk/second"));
  }
}

TEST_CASE("a run during which one of its texts changes is not kept") {
  const StudyFiles files;
  const std::string pipeline = content(std::string(ASLIO_SOURCE_DIR) + "/configs/pipelines/fixed_window.yaml");
  for (const auto& [who, changed] : {std::pair{"edits_pipeline", "own.yaml"}, {"edits_truth", "truth.tum"}}) {
    CAPTURE(who);
    write_recording(files);
    write_text(files.folder / "own.yaml", pipeline);
    const Study study = files.load(head() + "datasets: [{dataset: dataset.yaml}]\nmethods:\n" + "  - {name: " + who +
                                   ", pipeline: own.yaml}\n");
    const StudyOptions how = one_at_a_time(files.folder / (std::string("out_") + who));
    Quiet quiet;
    CHECK_THROWS_WITH(run_study(study, how, quiet), Contains(std::string(changed) + ": has changed"));
    CHECK((!fs::exists(how.output / "runs/walk") || fs::is_empty(how.output / "runs/walk")));
  }
}

TEST_CASE("a plugin, or what a scene reads, that changes ends the study, too") {
  const StudyFiles files;
  for (const std::string changed : {"libmine.so", "room.obj"}) {
    CAPTURE(changed);
    write_text(files.folder / "libmine.so", "code");
    write_text(files.folder / "room.obj", "v 0 0 0\n");
    write_text(files.folder / "reads.yaml", "reads room.obj\n");
    Study study =
        files.load(head() + "datasets: [{scene: scene_a.yaml}, {scene: scene_b.yaml}, {scene: reads.yaml}]\n" +
                   "methods:\n" + method("first", "fixed_window"));
    study.plugins = {files.folder / "libmine.so"};
    study.sources.emplace(study.plugins[0], aslio::sha256_of_file(study.plugins[0]));
    const StudyOptions how = one_at_a_time(files.folder / ("out_" + changed));
    Writer writer(files.folder / changed);
    CHECK_THROWS_WITH(run_study(study, how, writer), Contains(changed + ": has changed"));
    CHECK(fs::exists(how.output / "runs/scene_a_1/first"));
    CHECK_FALSE(fs::exists(how.output / "runs/reads_1/first"));
  }
}
