#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <vector>

#include "aslio/core/errors.hpp"
#include "aslio/io/writers.hpp"
#include "aslio/simulator/pose_spline.hpp"
#include "smoothness.hpp"
#include "temporary_folder.hpp"

using namespace aslio;
using namespace aslio::simulator;
using namespace aslio::simulator::test;

namespace {

constexpr double kDuration = 8;                     ///< [s]
constexpr TimeNs kBegin = 1'650'000'000 * kSecond;  ///< of a recording

/// Position, velocity and acceleration of a swing with turns about every axis.
MotionState known(double t) {
  MotionState m;
  m.p << 3 + 2 * std::sin(t), -2 * std::cos(0.8 * t), 1.4 + 0.2 * std::sin(2 * t);
  m.v << 2 * std::cos(t), 1.6 * std::sin(0.8 * t), 0.4 * std::cos(2 * t);
  m.a << -2 * std::sin(t), 1.28 * std::cos(0.8 * t), -0.8 * std::sin(2 * t);
  m.R = exp_so3(Vec3(0, 0, 0.9 * t)) * exp_so3(Vec3(0.2 * std::sin(1.3 * t), 0, 0));
  return m;
}

std::vector<StampedPose> poses_at(double rate, double duration = kDuration) {
  std::vector<StampedPose> poses;
  for (int k = 0; k <= static_cast<int>(std::lround(duration * rate)); ++k) {
    const MotionState m = known(k / rate);
    poses.push_back({kBegin + to_ns(k / rate), {m.R, m.p}});
  }
  return poses;
}

struct Distances {
  double position = 0, rotation = 0, velocity = 0, acceleration = 0;
};
/// From the known motion, `margin` seconds within both ends.
Distances distances(const Motion& motion, double margin) {
  Distances worst;
  for (double t = margin; t < kDuration - margin; t += 0.0037) {
    const MotionState a = motion.at(t), b = known(t);
    worst.position = std::max(worst.position, (a.p - b.p).norm());
    worst.rotation = std::max(worst.rotation, log_so3(a.R.transpose() * b.R).norm());
    worst.velocity = std::max(worst.velocity, (a.v - b.v).norm());
    worst.acceleration = std::max(worst.acceleration, (a.a - b.a).norm());
  }
  return worst;
}

}  // namespace

TEST_CASE("a motion that follows a file passes through its poses") {
  const aslio::test::TemporaryFolder folder;
  const std::vector<StampedPose> poses = poses_at(10);
  io::write_tum(folder / "walk.tum", poses);
  const auto motion = follow_file(folder / "walk.tum", 0.1);
  CHECK(motion->duration() == Approx(kDuration).epsilon(1e-12));
  for (const StampedPose& pose : poses) {
    const MotionState m = motion->at(to_seconds(pose.t - kBegin));
    REQUIRE((m.p - pose.T.p).norm() < 1e-9);
    REQUIRE(log_so3(m.R.transpose() * pose.T.R).norm() < 1e-9);
  }
}

TEST_CASE("a followed motion is that of the poses between them, too, and the better the closer its knots") {
  const auto fine = follow_poses(poses_at(100), 0.05), coarse = follow_poses(poses_at(100), 0.2);
  const Distances near = distances(*fine, 0), far = distances(*coarse, 0);
  CHECK(near.position < 1e-8);
  CHECK(near.rotation < 1e-8);
  CHECK(near.velocity < 1e-6);
  CHECK(near.acceleration < 1e-4);
  CHECK(far.position < 1e-5);
  CHECK(far.position > 10 * near.position);
}

TEST_CASE("the error of the fit is that at the poses") {
  std::vector<StampedPose> poses = poses_at(50);
  double error = 0;
  follow_poses(poses, 0.1, &error);
  CHECK(error < 1e-7);
  poses[200].T.p.z() += 0.05;
  const auto motion = follow_poses(poses, 0.1, &error);
  CHECK(error > 0.02);
  CHECK(error == Approx((motion->at(4).p - poses[200].T.p).norm()));
}

TEST_CASE("a followed motion has exact derivatives, however rough its poses are") {
  std::vector<StampedPose> poses = poses_at(20);
  for (std::size_t k = 0; k < poses.size(); ++k) {
    const double rough = 0.01 * static_cast<double>(k * 7919 % 13);
    poses[k].T.p.y() += rough;
    poses[k].T.R = poses[k].T.R * exp_so3(Vec3(0, rough, 0));
  }
  const auto motion = follow_poses(poses, 0.1);
  const DerivativeErrors errors = derivative_errors(*motion, 2.3e-3);
  CHECK(errors.velocity < 1e-6);
  CHECK(errors.acceleration < 1e-4);
  CHECK(errors.rate < 1e-6);
  CHECK(errors.rotation < 1e-14);
  const LargestChanges rough = largest_changes(*motion, 5e-4), fine = largest_changes(*motion, 5e-5);
  CHECK(fine.jerk < 0.11 * rough.jerk);
  CHECK(fine.rate_curvature < 0.11 * rough.rate_curvature);
}

TEST_CASE("quaternions of changing sign are the same rotations") {
  const aslio::test::TemporaryFolder folder;
  std::string plain, signs;
  for (int k = 0; k <= 80; ++k) {
    const double half = 0.05 * k, side = k % 2 == 0 ? 1 : -1;
    const auto line = [&](double s) {
      return std::to_string(0.1 * k) + " 0 0 0 0 0 " + std::to_string(s * std::sin(half)) + ' ' +
             std::to_string(s * std::cos(half)) + '\n';
    };
    plain += line(1);
    signs += line(side);
  }
  const auto a = follow_file(folder.write("plain.tum", plain), 0.1);
  const auto b = follow_file(folder.write("signs.tum", signs), 0.1);
  for (double t = 0; t < 8; t += 0.03) {
    REQUIRE((a->at(t).R - b->at(t).R).norm() < 1e-9);
    REQUIRE(b->at(t).w.z() == Approx(1).epsilon(1e-3));
  }
}

TEST_CASE("files that cannot be followed are refused with their name and place") {
  const aslio::test::TemporaryFolder folder;
  const auto refusal = [&](const std::string& text, double knots = 0.1) -> std::string {
    try {
      follow_file(folder.write("bad.tum", text), knots);
    } catch (const DataError& error) {
      return error.what();
    }
    return "accepted";
  };
  const auto line = [](double t, const std::string& x = "0") { return std::to_string(t) + ' ' + x + " 0 0 0 0 0 1\n"; };
  const std::string three = line(0) + line(0.1) + line(0.2);
  const std::string six = three + line(0.3) + line(0.4) + line(0.5);
  const auto in_file = [&](const std::string& rest) { return Catch::Contains((folder / "bad.tum").string() + rest); };
  CHECK(refusal(six) == "accepted");
  CHECK_THAT(refusal("# nothing\n"), in_file(": holds no pose"));
  CHECK_THAT(refusal(three), in_file(": the trajectory to follow has 3 poses, needs at least 6"));
  CHECK_THAT(refusal(six + line(0.45)), in_file(":7: its time is not later than"));
  CHECK_THAT(refusal(three + line(0.3, "nan") + line(0.4)), in_file(":4: not a finite number: 'nan'"));
  CHECK_THAT(refusal(six + line(0.9)),
             in_file(": the trajectory to follow has a gap of 0.400 s after 0.500 s (pose 6)") &&
                 Catch::Contains("make it longer"));
  CHECK(refusal(six + line(0.9), 0.2) == "accepted");
  CHECK_THAT(refusal(six + "0.6 0 0 0 0 0 1 0\n"), in_file(": the trajectory to follow turns by 180 deg in 0.100 s"));
  CHECK_THROWS_WITH(follow_file(folder / "none.tum", 0.1),
                    Catch::Contains((folder / "none.tum").string() + ": cannot open the trajectory"));
}

TEST_CASE("poses that cannot be followed are refused by their number") {
  std::vector<StampedPose> poses = poses_at(10);
  CHECK_THROWS_WITH(follow_poses(poses, 0), "follow.knot_interval is 0 s, must be above 0");
  CHECK_THROWS_AS(follow_poses(poses, std::nan("")), ConfigError);
  poses[7].T.p.x() = std::numeric_limits<double>::infinity();
  CHECK_THROWS_WITH(follow_poses(poses, 0.1),
                    "the trajectory to follow has a pose that is not finite after 0.700 s (pose 8)");
  poses = poses_at(10);
  poses[3].t = poses[2].t;
  CHECK_THROWS_WITH(follow_poses(poses, 0.1), Catch::Contains("goes back in time after 0.200 s (pose 3)"));
  poses = poses_at(10);
  for (std::size_t k = 5; k < poses.size(); ++k) poses[k].T.p.x() += 500;
  CHECK_THROWS_WITH(follow_poses(poses, 0.1), Catch::Contains("jumps by 500 m in 0.100 s after 0.400 s (pose 5)"));
}
