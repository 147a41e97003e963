/// `aslio status` and `aslio compare`, by what they are made of.

#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <chrono>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <thread>

#include "aslio/core/errors.hpp"
#include "aslio/experiment/study_compare.hpp"
#include "aslio/experiment/study_run.hpp"
#include "aslio/experiment/study_slurm.hpp"
#include "aslio/experiment/study_status.hpp"
#include "slurm_queue.hpp"
#include "study_files.hpp"

using namespace aslio::test;
using namespace aslio::experiment;
using Catch::Matchers::Contains;

namespace fs = std::filesystem;

namespace {

StudyOptions options(const fs::path& output) {
  StudyOptions out;
  out.output = output;
  out.program = "program";
  out.executable = ASLIO_CHILD_PROGRAM;
  return out;
}

std::string study_text(const std::vector<std::string>& names) {
  std::string text = head() + "datasets: [{scene: scene_a.yaml, seeds: 1-4}]\nmethods:\n";
  for (const std::string& name : names) text += method(name, "fixed_window");
  return text + "metrics: [ate_m]\ntime_limit: 20\n";
}

/// Of a study that is killed when a run hangs and the runs of the folder `done` are finished: its status before, and
/// when nobody holds its locks any more, as a child that was just begun does until it is gone.
std::pair<StudyStatus, StudyStatus> status_before_and_after(const Study& study, const StudyOptions& how,
                                                            const fs::path& done) {
  const pid_t id = ::fork();
  if (id == 0) {
    Quiet monitor;
    run_study(study, how, monitor);
    ::_exit(0);
  }
  const auto pause = [] { std::this_thread::sleep_for(std::chrono::milliseconds(10)); };
  StudyStatus before;
  for (int i = 0; i < 1000 && before.running.empty(); ++i, pause()) {
    if (fs::exists(how.output / "plan.csv") && fs::exists(how.output / done / "run_key.json"))
      before = read_status(how.output);
  }
  ::kill(id, SIGKILL);
  ::waitpid(id, nullptr, 0);
  StudyStatus after = read_status(how.output);
  for (int i = 0; i < 1000 && after.at_work; ++i, pause()) after = read_status(how.output);
  return {before, after};
}

}  // namespace

TEST_CASE("the status of a study tells what is finished, what runs and what waits") {
  const StudyFiles files;
  const Study study = files.load(study_text({"one", "mute", "hang"}));
  const fs::path output = files.folder / "out";
  CHECK_THROWS_WITH(read_status(output), Contains("holds no study"));
  const auto [status, after] = status_before_and_after(study, options(output), "runs/scene_a_1/mute");
  const std::string text = to_text(status);
  INFO(text);
  CHECK(status.at_work);
  CHECK(status.methods == std::vector<std::string>{"one", "mute", "hang"});
  CHECK(status.total.good == 1);
  CHECK(status.total.failed == 1);
  CHECK(status.total.running == 1);
  CHECK(status.total.waiting == 9);
  CHECK(status.left_s.has_value());
  CHECK_THAT(text, Contains("scene_a   1/4  1/4 1x  0/4 1r") && Contains("12 runs: 1 finished, 1 failed, 1 running") &&
                       Contains("scene_a_1/hang, for ") &&
                       Contains("scene_a_1/mute: failed (exit code 1 without a complaint)"));
  // Killed: what was running waits again.
  CHECK_FALSE(after.at_work);
  CHECK(after.total.running == 0);
  CHECK(after.total.waiting == 10);
}

TEST_CASE("a folder holds one study, and says so when it was made at another scale") {
  const StudyFiles files;
  const Study study = files.load(study_text({"one"}));
  const fs::path output = files.folder / "out";
  fs::create_directories(output);
  CHECK_FALSE(require_same_study(study, output));
  write_plan(study, plan_runs(study, "program"), 1, output);
  CHECK_FALSE(require_same_study(study, output));
  Study scaled = study;
  for (StudyData& data : scaled.data) data.scale = 0.25;
  REQUIRE(require_same_study(scaled, output));
  CHECK_THAT(*require_same_study(scaled, output), Contains("--scale 1") && Contains("this call has 0.25"));
  Study other = study;
  other.name = "another";
  CHECK_THROWS_WITH(require_same_study(other, output), Contains("would be mixed with it: name another folder"));
}

TEST_CASE("a call over one recording is seen at work, and one of yesterday's plans is no plan of today") {
  const StudyFiles files;
  const Study study = files.load(study_text({"one", "hang"}));
  const fs::path output = files.folder / "out";
  fs::create_directories(output);
  write_text(output / "plan.csv", "data,sequence,run,method,identity,key,jobs\nold_1,old,one,one,x,y,7\n");
  StudyOptions part = options(output);
  part.recording = "scene_a_2";
  const auto [status, after] = status_before_and_after(study, part, "runs/scene_a_2/one");
  CHECK(status.at_work);
  CHECK(status.total.running == 1);
  CHECK(status.total.all() == 8);
  CHECK_FALSE(after.at_work);
  CHECK(after.total.running == 0);
}

TEST_CASE("a plan whose number of jobs is none leaves one job") {
  const StudyFiles files;
  fs::create_directories(files.folder / "runs/a/one");
  write_text(files.folder / "runs/a/one/run_key.json",
             R"({"key": "k", "status": "crashed", "reason": "", "wall_s": 3, "final": true, "limit": 0})");
  for (const std::string jobs : {"1", "99999999999", "-1", "", "many"}) {
    write_text(files.folder / "plan.csv",
               "data,sequence,run,method,identity,key,jobs\na,a,one,m,x,k," + jobs + "\na,a,two,m,x,l," + jobs + "\n");
    CHECK(read_status(files.folder.path()).left_s == 3.0);
  }
}

TEST_CASE("nobody is at work when the cluster has refused") {
  const StudyFiles files;
  const Study study = files.load(study_text({"one"}));
  fs::create_directories(files.folder / "bin");
  for (const auto& [name, code] : {std::pair("squeue", 0), std::pair("sbatch", 1)}) {
    const fs::path program = fs::path(files.folder / "bin") / name;
    write_text(program, "#!/bin/sh\necho invalid partition\nexit " + std::to_string(code) + "\n");
    fs::permissions(program, fs::perms::owner_all);
  }
  std::string answer = "nothing";
  const std::string path = std::getenv("PATH");
  ::setenv("PATH", (fs::path(files.folder / "bin").string() + ":" + path).c_str(), 1);
  try {
    Quiet monitor;
    run_study_on_slurm(study, options(files.folder / "out"), SlurmOptions{}, monitor);
  } catch (const aslio::ConfigError& error) {
    answer = error.what();
  }
  ::setenv("PATH", path.c_str(), 1);
  CHECK_THAT(answer, Contains("sbatch refuses: "));
  CHECK(fs::exists(files.folder / "out/slurm"));
  CHECK_FALSE(read_status(files.folder / "out").at_work);
}

TEST_CASE("a site's notes beside the job id are no job id") {
  const auto submitted = [](const std::string& script) {
    const StudyFiles files;
    const fs::path bin = fs::path(files.folder / "bin");
    fs::create_directories(bin);
    write_text(bin / "sbatch", "#!/bin/sh\necho called >> '" + (bin / "calls").string() + "'\n" + script);
    fs::permissions(bin / "sbatch", fs::perms::owner_all);
    const std::string path = std::getenv("PATH");
    ::setenv("PATH", (bin.string() + ":" + path).c_str(), 1);
    std::string answer;
    try {
      SlurmOptions options;
      SlurmQueue queue(files.folder / "slurm", options);
      answer = queue.submit({"one", "two"}, 1).value().job;
    } catch (const aslio::ConfigError& error) {
      answer = error.what();
    }
    ::setenv("PATH", path.c_str(), 1);
    std::ifstream calls(bin / "calls");
    CHECK(std::count(std::istreambuf_iterator<char>(calls), {}, '\n') == 1);
    return answer;
  };
  CHECK(submitted("echo 'site note: queue chosen for you' >&2\necho 4242\n") == "4242");
  CHECK(submitted("echo '2026-01-01 a note'\necho '2026-01-01 another'\necho 4242\n") == "4242");
  CHECK(submitted("echo '4242;cluster1'\n") == "4242");
  CHECK_THAT(submitted("echo Submitted batch job\n"),
             Contains("sbatch printed no job id") && Contains("Submitted batch job"));
}

TEST_CASE("folders of the same runs compare as equal, whatever the clock said") {
  const StudyFiles files;
  const Study study = files.load(study_text({"one", "two"}));
  Quiet monitor;
  run_study(study, options(files.folder / "a"), monitor);
  run_study(study, options(files.folder / "b"), monitor);
  const FolderComparison same = compare_folders(files.folder / "a", files.folder / "b");
  INFO(to_text(same));
  CHECK(same.same());
  CHECK(same.shared == 8);

  // Other runs, other data, other outcomes, other figures.
  write_text(files.folder / "scene_a.yaml", "changed\n");
  const Study other = files.load(study_text({"one", "mute"}));
  run_study(other, options(files.folder / "c"), monitor);
  const FolderComparison c = compare_folders(files.folder / "a", files.folder / "c");
  CHECK_FALSE(c.same());
  CHECK(c.shared == 4);
  CHECK(c.only_a == std::vector<std::string>{"scene_a_1/two", "scene_a_2/two", "scene_a_3/two", "scene_a_4/two"});
  CHECK(c.only_b.size() == 4);
  CHECK(c.other_data.size() == 4);
  CHECK(c.different.empty());
  CHECK_THROWS_AS(compare_folders(files.folder / "a", files.folder / "gone"), aslio::ConfigError);
}

TEST_CASE("a comparison tells which runs differ, by how much and in what configuration") {
  const TemporaryFolder folder;
  const std::string header = "data,sequence,seed,order_seed,method,status,reason,ate_m,cpu_s_per_s\n";
  std::string a = header, b = header;
  for (int k = 1; k <= 7; ++k) {
    const std::string run = "x_" + std::to_string(k) + ",x," + std::to_string(k) + ",0,m,";
    a += run + "ok,\"a, \"\"b\"\"\",0." + std::to_string(k) + ",1\n";
    b += run + (k == 7 ? "failed,why,,2\n" : "ok,,0." + std::to_string(k) + "5,2\n");
  }
  for (const auto& [name, text, period] : {std::tuple("a", a, "0.1"), std::tuple("b", b, "0.05")}) {
    fs::create_directories(folder / name / "runs/x_1/m");
    write_text(folder / name / "results.csv", text);
    write_text(folder / name / "runs/x_1/m/resolved.yaml",
               std::string("schema: aslio/pipeline/1\nwindow: {type: fixed, period: ") + period + "}\n");
  }
  const FolderComparison c = compare_folders(folder / "a", folder / "b");
  INFO(to_text(c));
  CHECK(c.different.size() == 7);
  CHECK(c.outcomes == std::vector<std::string>{"x_7/m: ok -> failed"});
  CHECK(c.configurations == std::vector<std::string>{"m: window.period: 0.1 -> 0.05"});
  REQUIRE(c.figures.size() == 2);
  CHECK(c.figures[0].figure == "ate_m");
  CHECK(c.figures[0].pairs == 7);
  CHECK(*c.figures[0].difference == Approx(0.05));
  CHECK(c.figures[0].tally.lost == 7);
  CHECK(*c.figures[0].p < 0.05);
  write_text(folder / "b/results.csv", header + "x_1,x,1\n");
  CHECK_THROWS_AS(compare_folders(folder / "a", folder / "b"), aslio::DataError);
}

TEST_CASE("where the outputs lie is no difference of configuration") {
  const TemporaryFolder folder;
  const std::string table = "data,sequence,seed,order_seed,method,status,reason,ate_m\nx_1,x,1,0,m,ok,,0.1\n";
  // e11 has been moved since, and its manifest knows from where; that of e1 is lost.
  const std::string one = fs::path(folder / "e1").string(), moved = "/of another/./machine/e1";
  const auto write = [&](const std::string& name, const std::string& output, const std::string& file) {
    fs::create_directories(folder / name / "runs/x_1/m");
    write_text(folder / name / "results.csv", table);
    write_text(folder / name / "runs/x_1/m/resolved.yaml",
               "schema: aslio/pipeline/1\nwindow:\n  type: replay\n  file: \"" + output + file + "\"\nlist: [\"" +
                   output + "/data/x_1/a.csv\", /elsewhere/b.csv]\n");
  };
  write("e1", one, "/runs/x_1/as_lio_plus/updates.csv");
  write("e11", moved, "/runs/x_1/as_lio_plus/updates.csv");
  write_text(folder / "e11/runs/x_1/m/manifest.json",
             R"({"command_line": ["aslio", "run", "--output", ")" + moved + R"(/runs/x_1/m", "--quiet"]})");
  const FolderComparison same = compare_folders(folder / "e1", folder / "e11");
  INFO(to_text(same));
  CHECK(same.same());
  CHECK(same.configurations.empty());
  // A manifest that cannot be read is as good as none.
  fs::create_directories(folder / "e1/runs/x_1/m/manifest.json");
  CHECK(compare_folders(folder / "e1", folder / "e11").configurations.empty());
  // Of another run, or of another study, is one.
  write("e11", moved, "/runs/x_1/fixed/updates.csv");
  CHECK(compare_folders(folder / "e1", folder / "e11").configurations ==
        std::vector<std::string>{"m: window.file: runs/x_1/as_lio_plus/updates.csv -> runs/x_1/fixed/updates.csv"});
  write("e11", moved, "0/runs/x_1/as_lio_plus/updates.csv");
  CHECK(compare_folders(folder / "e1", folder / "e11").configurations.size() == 1);
}

TEST_CASE("the commands exit with what they found") {
  const StudyFiles files;
  const Study study = files.load(study_text({"one"}));
  Quiet monitor;
  run_study(study, options(files.folder / "a"), monitor);
  const std::string a = files.folder / "a", gone = files.folder / "gone";
  const Ended status = run_aslio({"status", a});
  CHECK(status.code == 0);
  CHECK_THAT(status.out, Contains("4 runs: 4 finished, 0 failed, 0 running, 0 waiting; nobody is at work"));
  CHECK(run_aslio({"status", gone}).code == 2);
  CHECK(run_aslio({"compare", a, a}).code == 0);
  CHECK(run_aslio({"compare", a, gone}).code == 2);
  fs::create_directories(files.folder / "b");
  std::string text = content(files.folder / "a/results.csv");
  write_text(files.folder / "b/results.csv", text.replace(text.rfind(",ok,"), 4, ",failed,"));
  const Ended differ = run_aslio({"compare", a, files.folder / "b"});
  CHECK(differ.code == 1);
  CHECK_THAT(differ.out, Contains("scene_a_4/one: ok -> failed"));
}
