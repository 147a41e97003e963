// Faults 41 to 45: what there is to see.
#include <Eigen/Geometry>
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <optional>
#include <sstream>
#include <utility>

#include "aslio/core/trajectory.hpp"
#include "aslio/simulator/random.hpp"
#include "faults/table.hpp"

namespace aslio::test::faults {
namespace {

/// What a ray meets first of some planes n . p = d in W.
struct Plane {
  Vec3 n = Vec3::UnitZ();
  double d = 0;
};

/// The walk in another world, of these planes alone: every ray of the recording is cast anew, and lost beyond
/// `farthest`.
Walk in_world(const std::vector<Plane>& planes, double farthest) {
  Walk walk = clean_walk();
  const Trajectory truth(walk.truth);
  simulator::RandomStream random(101, 9004);
  alter_packets({}, [&](LidarPacket& packet, std::size_t) {
    std::erase_if(packet.points, [&](TimedPoint& p) {
      const double error = 0.02 * random.normal();
      const auto T_W_I = truth.pose(p.t);
      if (!T_W_I) return true;
      const Pose T_W_L = *T_W_I * walk.sensor.T_imu_lidar;
      // The sensor looks up, and what is there is below: as one that is mounted the other way round.
      const Vec3 ray_L = Vec3(p.x, p.y, -p.z).normalized(), ray = T_W_L.R * ray_L;
      double range = farthest;
      for (const Plane& plane : planes) {
        const double along = plane.n.dot(ray), away = (plane.d - plane.n.dot(T_W_L.p)) / along;
        if (std::abs(along) > 0.05 && away > 0.3) range = std::min(range, away);
      }
      const Vec3 hit = (range + error) * ray_L;
      p.x = static_cast<float>(hit.x());
      p.y = static_cast<float>(hit.y());
      p.z = static_cast<float>(hit.z());
      return range >= farthest;
    });
  })(walk.data);
  return walk;
}

std::function<Outcome()> seeing(std::vector<Plane> planes, double farthest) {
  return [planes = std::move(planes), farthest] {
    const Walk walk = in_world(planes, farthest);
    return run_over(walk.data, walk.truth, walk.sensor);
  };
}

/// Positions of the run in the frame of the truth, against the truth: the largest error along `axis` of W [m].
double error_along(const Outcome& o, const Vec3& axis) {
  const Walk& walk = clean_walk();
  const Trajectory truth(walk.truth);
  std::istringstream lines(o.trajectory);
  double worst = 0;
  std::optional<Pose> first;  // T_truth_run
  double t = 0;
  Vec3 p;
  Eigen::Quaterniond q;
  while (lines >> t >> p.x() >> p.y() >> p.z() >> q.x() >> q.y() >> q.z() >> q.w()) {
    // By the nearest time: a double of an epoch is off by 240 ns, in which nothing moves.
    const auto there = truth.pose(to_ns(t));
    if (!there) continue;
    const Pose run{q.toRotationMatrix(), p};
    if (!first) first = *there * run.inverse();
    worst = std::max(worst, std::abs(axis.dot((*first * run).p - there->p)));
  }
  REQUIRE(first.has_value());
  return worst;
}

void check_says_degenerate(const Outcome& o) {
  CHECK_THAT(o.summary.at("weak_updates").get<std::string>(), Catch::Matchers::Contains("degenerate"));
}

/// Of the simulated world, in whose frame the truth is: floor and ceiling, and walls on both sides of the way [m].
constexpr double kFloor = 0, kCeiling = 2.8, kRight = -1.5, kLeft = 6.6;

/// Floor alone, as far as `range` [m]: the place on it is left open, its height is not.
Row floor_alone(int number, std::string name, std::string injected, double range) {
  return {.number = number,
          .name = std::move(name),
          .injected = std::move(injected),
          .expected = {.status = {"degraded", "diverged", "failed"}},
          .run = seeing({{Vec3::UnitZ(), kFloor}}, range),
          .also = "updates are `degenerate`; height is right to 0.2 m",
          .check = [](const Outcome& o) {
            check_says_degenerate(o);
            CHECK(error_along(o, Vec3::UnitZ()) < 0.2);
          }};
}

std::vector<Row> degenerate() {
  std::vector<Row> rows;
  rows.push_back(floor_alone(41, "single_plane", "nothing but the floor is there", 30));
  rows.push_back(
      {.number = 42,
       .name = "corridor",
       .injected = "there is only a floor, a ceiling and two long walls",
       .expected = {.status = {"degraded", "diverged", "failed"}},
       .run = seeing(
           {{Vec3::UnitZ(), kFloor}, {Vec3::UnitZ(), kCeiling}, {Vec3::UnitY(), kLeft}, {Vec3::UnitY(), kRight}}, 30),
       .also = "updates are `degenerate`; height and place across are right to 0.1 m",
       .check = [](const Outcome& o) {
         check_says_degenerate(o);
         CHECK(error_along(o, Vec3::UnitZ()) < 0.1);
         CHECK(error_along(o, Vec3::UnitY()) < 0.1);
       }});
  rows.push_back(floor_alone(43, "open_field", "nothing but the ground within 8 m is there", 8));
  return rows;
}

}  // namespace

std::vector<Row> view_rows() {
  std::vector<Row> rows = degenerate();
  rows.push_back({.number = 44,
                  .name = "sudden_fov_block_180deg",
                  .injected = "half of the view is covered from 6 to 8 s",
                  .expected = {.status = {"ok", "degraded"}, .ate_times = 2, .ate_plus = 0.01},
                  .run =
                      [] {
                        return run_with(block_view({6, 2}, -std::numbers::pi / 2, std::numbers::pi));
                      },
                  .also = "ok within 1 s of its end",
                  .check = [](const Outcome& o) { check_recovered(o, 8, 1); }});
  const Span cut{5, 3.5};
  rows.push_back({.number = 45,
                  .name = "teleport_kidnap_5m",
                  .injected = "3.5 s of the walk are cut out, a jump of about 5 m",
                  .expected = {.status = {"diverged"}, .exit = {1}},
                  .run =
                      [cut] {
                        const Walk& walk = clean_walk();
                        return run_over(altered(walk.data, teleport(cut)), teleported(walk.truth, walk.begin(), cut),
                                        walk.sensor);
                      },
                  .also = "lost within 1 s of the jump; then a segment with a map of its own",
                  .check =
                      [cut](const Outcome& o) {
                        check_lost(o, cut.begin, 1);
                        REQUIRE(o.updates.contains("segment"));
                        CHECK(o.updates.at("segment").back() == "1");
                      }});
  return rows;
}

}  // namespace aslio::test::faults
