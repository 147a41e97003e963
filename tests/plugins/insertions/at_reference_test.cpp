// Points enter where the reference places them (INS-3), in the frame of the run.
#include "insertions/at_reference.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <catch2/catch.hpp>

#include "aslio/core/errors.hpp"
#include "plugins/build_environment.hpp"
#include "plugins/insertions/random_windows.hpp"
#include "plugins/insertions/recording_map.hpp"
#include "temporary_folder.hpp"

using namespace aslio;
using namespace aslio::test;

namespace {

constexpr TimeNs kMs = 1'000'000, kEpoch = 1'700'000'000 * kSecond;

/// What the filter believes: it drifts away from the truth.
struct Drifting final : TrajectoryModel {
  Pose pose(TimeNs t) const override {
    const double s = to_seconds(t - kEpoch);
    return {exp_so3(Vec3(0, 0, 0.3 + 0.05 * s)), Vec3(1 + 0.9 * s, 2, 0)};
  }
  int dof() const override { return 0; }
  Pose moved(TimeNs t, const Eigen::VectorXd&) const override { return pose(t); }
  void jacobian(TimeNs, Eigen::MatrixXd& out) const override { out.resize(6, 0); }
};

Pose truth(TimeNs t) { return {exp_so3(Vec3(0, 0, -1)), Vec3(5 + to_seconds(t - kEpoch), 0, 0)}; }

std::string table() {
  std::string text = "t,px,py,pz,vx,qx,qy,qz,qw\n";
  for (TimeNs t = kEpoch; t <= kEpoch + 2 * kSecond; t += 5 * kMs) {
    const Pose pose = truth(t);
    const Eigen::Quaterniond q(pose.R);
    text += fmt::format("{}.{:09},{:.12g},{:.12g},{:.12g},1,{:.12g},{:.12g},{:.12g},{:.12g}\n", t / kSecond,
                        t % kSecond, pose.p.x(), pose.p.y(), pose.p.z(), q.x(), q.y(), q.z(), q.w());
  }
  return text;
}

/// The same as a trajectory of the TUM benchmark.
std::string tum_lines() {
  std::string text = "# t px py pz qx qy qz qw\n\n";
  for (TimeNs t = kEpoch; t <= kEpoch + 2 * kSecond; t += 5 * kMs) {
    const Pose pose = truth(t);
    const Eigen::Quaterniond q(pose.R);
    text += fmt::format("{}.{:09} {:.12g} {:.12g} {:.12g} {:.12g} {:.12g} {:.12g} {:.12g}\n", t / kSecond, t % kSecond,
                        pose.p.x(), pose.p.y(), pose.p.z(), q.x(), q.y(), q.z(), q.w());
  }
  return text;
}

}  // namespace

TEST_CASE("at_reference: a wall that the drifting filter sees stays where it was first seen") {
  const TemporaryFolder folder;
  BuildEnvironment environment;
  const bool tum = GENERATE(false, true);
  const std::string name = tum ? "truth.tum" : "truth.csv";
  plugins::InsertAtReference insertion({folder.write(name, tum ? tum_lines() : table()).string()},
                                       environment.context());
  RecordingMap map;
  const Drifting filter;
  // A corner of the true world, and where the first update ties the frames.
  const Vec3 corner_R(9, 4, 1);
  const TimeNs first_end = kEpoch + 100 * kMs;
  const Pose T_W_R = filter.pose(first_end) * truth(first_end).inverse();
  for (std::uint32_t k = 1; k <= 10; ++k) {
    const TimeNs end = kEpoch + k * 100 * kMs;
    WorldPoint point;
    point.t = end - 33 * kMs;
    point.p_W = filter.pose(point.t) * (truth(point.t).inverse() * corner_R);
    const std::vector<WorldPoint> points(3, point);
    Update update;
    update.map_points = points;
    update.trajectory = &filter;
    update.state.R = filter.pose(end).R;
    update.state.p = filter.pose(end).p;
    const Window window = window_of(k, end - 100 * kMs, end - 100 * kMs, end);
    insertion.begin(window, map);
    insertion.apply(window, update, map);
  }
  insertion.finish(map);
  REQUIRE(map.given.size() == 30);
  CHECK_THAT(environment.logged(), Catch::Contains(name) && Catch::Contains("no result of a method"));
  for (const WorldPoint& point : map.given) CHECK((point.p_W - T_W_R * corner_R).norm() < 1e-6);
}

TEST_CASE("at_reference: the truth of other data is refused with its file and times") {
  const TemporaryFolder folder;
  BuildEnvironment environment;
  plugins::InsertAtReference insertion({folder.write("truth.csv", table()).string()}, environment.context());
  RecordingMap map;
  Update update;
  CHECK_THROWS_WITH(insertion.apply(window_of(1, 0, 0, 5 * kSecond), update, map),
                    Catch::Contains("truth.csv") && Catch::Contains("5.000 s") && Catch::Contains("1700000002.000"));
}

TEST_CASE("at_reference: errors of a table name the file, the line and the value") {
  const TemporaryFolder folder;
  BuildEnvironment environment;
  const auto complaint = [&](const std::string& text, const std::string& name = "bad.csv") {
    try {
      plugins::InsertAtReference({folder.write(name, text).string()}, environment.context());
    } catch (const DataError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  const std::string header = "t,px,py,pz,qx,qy,qz,qw\n";
  CHECK_THAT(complaint(header + "1.5,0,0,0,0,0,0,1\n1.6,0,zero,0,0,0,0,1\n"),
             Catch::Contains("bad.csv:3") && Catch::Contains("py 'zero'"));
  CHECK_THAT(complaint(header + "1.x,0,0,0,0,0,0,1\n"), Catch::Contains("bad.csv:2") && Catch::Contains("1.x"));
  CHECK_THAT(complaint(header + "1.5,0,0,0,0,0,0,0\n"), Catch::Contains("quaternion"));
  CHECK_THAT(complaint("t,px,py,pz\n1,0,0,0\n"), Catch::Contains("qx"));
  CHECK_THAT(complaint("# t\n1 0 0 0 0 0 1\n", "bad.tum"), Catch::Contains("bad.tum:2") && Catch::Contains("7 values"));
  CHECK_THAT(complaint("1 0 0 x 0 0 0 1\n", "bad.tum"), Catch::Contains("bad.tum:1") && Catch::Contains("pz 'x'"));
  CHECK_THAT(complaint(header + "2,0,0,0,0,0,0,1\n1,0,0,0,0,0,0,1\n"), Catch::Contains("not later"));
}
