#include <catch2/catch.hpp>
#include <limits>

#include "aslio/core/errors.hpp"
#include "aslio/core/trajectory.hpp"

namespace {

using namespace aslio;

StampedPose at(TimeNs t, const Vec3& p, const Vec3& phi = Vec3::Zero()) { return {t, {exp_so3(phi), p}}; }

Trajectory example() {
  return Trajectory(
      {at(1'000, Vec3(0, 0, 0)), at(2'000, Vec3(1, 0, 0), Vec3(0, 0, 0.4)), at(6'000, Vec3(1, 2, 0), Vec3(0, 0, 0.4))});
}

}  // namespace

TEST_CASE("a trajectory interpolates between its samples and gives nothing outside") {
  const Trajectory trajectory = example();
  CHECK(trajectory.size() == 3);
  CHECK(trajectory.begin_time() == 1'000);
  CHECK(trajectory.end_time() == 6'000);
  CHECK_FALSE(trajectory.pose(999).has_value());
  CHECK_FALSE(trajectory.pose(6'001).has_value());
  REQUIRE(trajectory.pose(1'250).has_value());
  CHECK((trajectory.pose(1'250)->p - Vec3(0.25, 0, 0)).norm() < 1e-15);
  CHECK((log_so3(trajectory.pose(1'250)->R) - Vec3(0, 0, 0.1)).norm() < 1e-15);
}

TEST_CASE("at a sample's own time its pose comes back unchanged") {
  const Trajectory trajectory = example();
  for (const StampedPose& sample : trajectory.samples()) {
    REQUIRE(trajectory.pose(sample.t).has_value());
    CHECK(trajectory.pose(sample.t)->p == sample.T.p);
    CHECK(trajectory.pose(sample.t)->R == sample.T.R);
  }
}

TEST_CASE("a gap wider than allowed gives nothing inside, but its ends stand") {
  const Trajectory trajectory = example();
  CHECK_FALSE(trajectory.pose(4'000, 3'999).has_value());
  CHECK(trajectory.pose(4'000, 4'000).has_value());
  CHECK(trajectory.pose(1'500, 3'999).has_value());
  CHECK(trajectory.pose(2'000, 1).has_value());
  CHECK(trajectory.pose(6'000, 1).has_value());
}

TEST_CASE("an empty trajectory has no pose and no length") {
  const Trajectory trajectory;
  CHECK(trajectory.empty());
  CHECK_FALSE(trajectory.pose(0).has_value());
  CHECK(trajectory.path_length() == 0.0);
}

TEST_CASE("path length is the sum of the steps") { CHECK(example().path_length() == Approx(3.0).epsilon(1e-15)); }

TEST_CASE("times far from zero keep their nanoseconds") {
  const TimeNs epoch = 1'600'000'000LL * kSecond;
  const Trajectory trajectory({at(epoch, Vec3(0, 0, 0)), at(epoch + 10, Vec3(10, 0, 0))});
  REQUIRE(trajectory.pose(epoch + 3).has_value());
  CHECK(trajectory.pose(epoch + 3)->p.x() == Approx(3.0).epsilon(1e-15));
}

TEST_CASE("times that do not increase are refused with both times") {
  const std::string said =
      "trajectory: pose 1 at t = 5 ns is not later than the one before it at t = 5 ns; sort the poses by time and "
      "remove duplicates";
  CHECK_THROWS_WITH(Trajectory({at(5, Vec3::Zero()), at(5, Vec3::Zero())}), said);
  CHECK_THROWS_AS(Trajectory({at(5, Vec3::Zero()), at(4, Vec3::Zero())}), DataError);
  Trajectory trajectory({at(5, Vec3::Zero())});
  CHECK_THROWS_WITH(trajectory.append(at(5, Vec3::Zero())), said);
  trajectory.append(at(6, Vec3(1, 0, 0)));
  CHECK(trajectory.size() == 2);
}

TEST_CASE("a pose that is not finite is refused") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::string said =
      "trajectory: pose 0 at t = 5 ns is not finite; remove it, or cut the trajectory before it diverged";
  CHECK_THROWS_WITH(Trajectory({at(5, Vec3(0, nan, 0))}), said);
  StampedPose pose = at(5, Vec3::Zero());
  pose.T.R(1, 1) = std::numeric_limits<double>::infinity();
  Trajectory trajectory;
  CHECK_THROWS_WITH(trajectory.append(pose), said);
  CHECK(trajectory.empty());
}

TEST_CASE("seconds and nanoseconds convert to the nearest nanosecond") {
  CHECK(to_ns(0.1) == 100'000'000);
  CHECK(to_ns(-1.5e-9) == -2);
  CHECK(to_seconds(250'000'000) == Approx(0.25).epsilon(1e-15));
  CHECK(to_ns(to_seconds(49LL * 86'400 * kSecond + 1)) == 49LL * 86'400 * kSecond + 1);
}
