// The trajectories of the shipped pipelines over the first 5 s of the analytic world, kept as files: a change of
// behaviour shows up as a diff. Not bits (they depend on the compiler) but 0.1 mm and 0.1 mrad.
// To accept a change: run this test, then `cp BUILD/golden/*.tum tests/pipeline/golden/`.
#include <catch2/catch.hpp>
#include <filesystem>

#include "aslio/io/writers.hpp"
#include "aslio/simulator/analytic_world.hpp"
#include "pipeline/runs.hpp"

using namespace aslio;
using namespace aslio::test;

TEST_CASE("the first 5 s of the analytic world come out as recorded in the golden trajectories") {
  const simulator::AnalyticWorld world({.seed = 1});
  const auto source = world.source();
  const Recording recording = record(*source, world.begin_time() + to_ns(5.1));
  const std::filesystem::path folder = ASLIO_BINARY_DIR "/golden";
  std::filesystem::create_directories(folder);
  for (const std::string name : {"as_lio_plus", "fixed_window"}) {
    CAPTURE(name);
    Run run(shipped(name), world.sensor());
    const Trajectory trajectory = run.play(recording).trajectory();
    std::vector<StampedPose> actual;
    for (TimeNs t = world.begin_time() + kSecond / 5; t <= world.begin_time() + 5 * kSecond; t += kSecond / 10) {
      const auto pose = trajectory.pose(t);
      REQUIRE(pose);
      actual.push_back({t, *pose});
    }
    io::write_tum(folder / (name + ".tum"), actual);
    const auto golden = io::read_tum(ASLIO_SOURCE_DIR "/tests/pipeline/golden/" + name + ".tum");
    REQUIRE(golden.size() == actual.size());
    for (std::size_t i = 0; i < golden.size(); ++i) {
      CAPTURE(to_seconds(golden[i].t - world.begin_time()));
      REQUIRE(golden[i].t == actual[i].t);
      CHECK((golden[i].T.p - actual[i].T.p).norm() < 1e-4);
      CHECK(log_so3(golden[i].T.R.transpose() * actual[i].T.R).norm() < 1e-4);
    }
  }
}
