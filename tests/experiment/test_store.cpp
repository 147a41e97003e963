/// Simulated data that studies share: what is made again, and what is never touched. The runs are those of
/// child_program.cpp.

#include <sys/file.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <cerrno>
#include <functional>

#include "aslio/core/errors.hpp"
#include "aslio/experiment/study_run.hpp"
#include "folder_lock.hpp"
#include "study_files.hpp"

using namespace aslio::test;
using namespace aslio::experiment;
using Catch::Matchers::Contains;

namespace fs = std::filesystem;

namespace {

/// Called before a lock is taken: other calls have their say at the worst of moments.
std::function<void(int file, int operation)>& before_lock() {
  static std::function<void(int, int)> call;
  return call;
}

}  // namespace

/// What every lock fails with, as on a file system that has none; 0: they are taken.
int& lock_error() {
  static int error = 0;
  return error;
}

/// In place of that of the C library.
extern "C" int flock(int file, int operation) noexcept {
  if (before_lock()) before_lock()(file, operation);
  if (lock_error() != 0) {
    errno = lock_error();
    return -1;
  }
  return static_cast<int>(::syscall(SYS_flock, file, operation));
}

namespace {

/// Data of one recording that a study has left in a shared folder.
class SharedData {
 public:
  SharedData() { again(); }

  /// What a further call tells. All of its runs must be good.
  std::string again(bool keep = true) {
    StudyOptions how;
    how.output = files.folder / ("out_" + std::to_string(++calls_));  // nothing is finished there
    how.program = "program";
    how.executable = ASLIO_CHILD_PROGRAM;
    how.data = shared;
    how.keep_data = keep;
    Quiet monitor;
    const StudyResult result = run_study(study, how, monitor);
    CHECK(result.failures() == 0);
    return monitor.lines;
  }

  /// The other place, for data whose name is taken.
  fs::path second() const { return shared / ("scene_a_1-" + study.data[0].identity.substr(0, 8)); }

  StudyFiles files;
  Study study = files.load(head() + "datasets: [{scene: scene_a.yaml}]\nmethods:\n" + method("one", "fixed_window"));
  fs::path shared = files.folder / "shared", data = shared / "scene_a_1";

 private:
  int calls_ = 0;
};

const char* const kSimulated = "scene_a_1: simulated";

}  // namespace

TEST_CASE("a study runs on a file system without locks") {
  for (const int error : {ENOSYS, ENOLCK, EOPNOTSUPP}) {
    lock_error() = error;
    SharedData data;  // checks that all runs are good
    const std::string lines = data.again();
    lock_error() = 0;
    CHECK_THAT(lines, Contains("has no file locks"));
  }
}

TEST_CASE("a trajectory without a pose is an empty file, and not made again for that") {
  const StudyFiles files;
  const std::string replay = "set: {window: {type: replay, file: '{run:first}/trajectory.tum'}}";
  const Study study =
      files.load(head() + "datasets: [{scene: scene_a.yaml}]\nmethods:\n" + method("first", "as_lio_plus") +
                 method("second", "as_lio_plus", replay) + "metrics: [ate_m]\n");
  const fs::path output = files.folder / "out", trajectory = output / "runs/scene_a_1/first/trajectory.tum";
  StudyOptions how;
  how.output = output;
  how.program = "program";
  how.executable = ASLIO_CHILD_PROGRAM;
  Quiet monitor;
  REQUIRE(run_study(study, how, monitor).failures() == 0);
  write_text(trajectory, "");
  monitor.lines.clear();
  CHECK(run_study(study, how, monitor).failures() == 0);
  CHECK(monitor.lines.empty());
  fs::remove(trajectory);
  CHECK(run_study(study, how, monitor).failures() == 0);
  CHECK_THAT(monitor.lines, Contains("scene_a_1/first: ok"));
}

TEST_CASE("shared data without one of the files that studies read, or with an empty one, are simulated again") {
  SharedData d;
  REQUIRE_THAT(d.again(), !Contains(kSimulated));
  for (const char* file :
       {"dataset.yaml", "sensor.yaml", "truth.tum", "overlap.csv", "scene.yaml", "preview.svg", "data.bag"}) {
    for (const bool gone : {true, false}) {
      INFO(file << (gone ? " is gone" : " is empty"));
      fs::remove(d.data / file);
      if (!gone) write_text(d.data / file, "");
      CHECK_THAT(d.again(), Contains(kSimulated) && !Contains("warning"));
      CHECK(fs::file_size(d.data / file) > 0);
      CHECK_FALSE(fs::exists(d.second()));
      CHECK_THAT(d.again(), !Contains(kSimulated));
    }
  }
}

TEST_CASE("broken shared data stay where anything lies beside them, and the new ones get another place") {
  SharedData d;
  std::string mine;
  SECTION("a folder") { mine = "my_run/notes.txt"; }
  SECTION("a file") { mine = "notes.txt"; }
  SECTION("another bag") { mine = "mine.bag"; }
  SECTION("a folder that has the name of a file of the data") { mine = "truth.csv/notes.txt"; }
  fs::create_directories((d.data / mine).parent_path());
  write_text(d.data / mine, "mine");
  fs::remove(d.data / "data.bag");
  const std::string told = d.again(), warning = "warning: " + d.data.string() + ": files of these data are missing";
  CHECK_THAT(told, Contains(warning) && Contains("the data are in " + d.second().filename().string() + ". Move"));
  CHECK(told.find("warning") == told.rfind("warning"));
  CHECK(content(d.data / mine) == "mine");
  for (const char* file : {"truth.tum", "sensor.yaml", "identity.txt"}) CHECK(fs::exists(d.data / file));
  CHECK(fs::exists(d.second() / "data.bag"));
  // They serve later calls.
  CHECK_THAT(d.again(), !Contains(kSimulated) && !Contains("warning"));
  // And none is left when there is no other place.
  write_text(d.second() / "mine.txt", "mine");
  fs::remove(d.second() / "data.bag");
  CHECK_THROWS_WITH(d.again(), Contains("simulated data cannot be put there as scene_a_1 or scene_a_1-") &&
                                   Contains("move your own files elsewhere"));
  CHECK(content(d.second() / "mine.txt") == "mine");
}

TEST_CASE("shared data without the world that a study asks for are made again in their place") {
  SharedData d;
  d.study = d.files.load(head() + "datasets: [{scene: scene_a.yaml}]\noutputs: [world]\nmethods:\n" +
                         method("one", "fixed_window"));
  CHECK_THAT(d.again(), Contains(kSimulated) && !Contains("warning"));
  CHECK(fs::exists(d.data / "world.ply"));
  CHECK_FALSE(fs::exists(d.second()));
  CHECK_THAT(d.again(), !Contains(kSimulated));
}

TEST_CASE("shared data that another study puts in the place of broken ones are left to it") {
  SharedData d;
  const fs::path theirs = d.files.folder / "theirs";
  fs::copy(d.data, theirs);
  write_text(theirs / "data.bag", std::string(3000, 't'));
  fs::remove(d.data / "data.bag");
  int swaps = 0;
  // This call has found the data broken and opened their folder.
  before_lock() = [&](int file, int operation) {
    std::error_code error;
    const fs::path locked = fs::read_symlink("/proc/self/fd/" + std::to_string(file), error);
    if (swaps > 0 || locked != fs::canonical(d.data, error) || (operation & LOCK_EX) == 0) return;
    ++swaps;
    fs::remove_all(d.data);
    fs::rename(theirs, d.data);
  };
  CHECK_THAT(d.again(false), Contains(kSimulated));
  before_lock() = nullptr;
  CHECK(swaps == 1);
  CHECK(content(d.data / "data.bag") == std::string(3000, 't'));
  CHECK_THAT(d.again(), !Contains(kSimulated));
}

TEST_CASE("only another process's lock means that somebody is at work") {
  const StudyFiles files;
  const fs::path folder = files.folder / "folder", none = files.folder / "none", file = files.folder / "scene_a.yaml";
  fs::create_directory(folder);
  const auto lock = FolderLock::take(folder, true);
  REQUIRE(lock.has_value());
  CHECK_FALSE(FolderLock::take(folder, false).has_value());
  CHECK(FolderLock::is_held(folder, false));
  CHECK_FALSE(FolderLock::take(none, true).has_value());
  CHECK_FALSE(FolderLock::is_held(none, true));
  CHECK_THROWS_WITH(FolderLock::take(file, true), Contains("scene_a.yaml: cannot be opened: Not a directory"));
  CHECK_FALSE(FolderLock::is_held(file, true));
}
