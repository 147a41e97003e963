// Whether the filter's covariance says how wrong it is: against walls known exactly, with an IMU without errors of
// calibration and its own noise, the squared error in units of the covariance (NEES) has the mean of its dimension.
#include <catch2/catch.hpp>

#include "aslio/simulator/imu_params.hpp"
#include "aslio/simulator/walk.hpp"
#include "integration/known_room.hpp"

using namespace aslio;
using namespace aslio::test;

namespace {

/// 3.2 s of walking from rest to rest, with a turn of 103 deg at up to 376 deg/s, a corner of the room in view.
simulator::Walk short_walk() {
  simulator::WalkSetting setting;
  setting.heading = 0.55;
  simulator::Gait gait;
  gait.fade = 0.5;
  return {{{0.3, -2, -1, 0, 0}, {1.4, -0.8, -0.9, 1.2, 0.1}, {2.2, 0.1, -0.3, 0.5, 1.0}, {3.2, 0.5, 0.9, 0, 0}},
          {{1.2, 0.6, 1.8}},
          gait,
          setting};
}

struct Consistency {
  double nees = 0;      ///< mean over seeds and updates
  double last = 0;      ///< mean over seeds of the last update
  double residual = 0;  ///< mean residual_rms / sigma
  double nis = 0;       ///< mean over seeds and updates, per match
  std::size_t updates = 0, not_ok = 0;
};

Consistency consistency(const std::string& deskew_correction, PointNoise noise = PointNoise::all_directions) {
  constexpr int seeds = 100;
  const simulator::Walk walk = short_walk();
  KnownRoomSetting setting;
  simulator::ImuParams ideal;
  ideal.preset = simulator::ImuPreset::ideal;
  setting.imu = simulator::imu_model(ideal);
  setting.noise = noise;
  setting.overrides = {"estimator.deskew_correction=" + deskew_correction};
  Consistency sum;
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    KnownRoom room(walk, setting, seed);
    double nees = 0;
    while (!room.at_end()) {
      const Update& update = room.step();
      nees = room.pose_nees(update);
      sum.nees += nees;
      sum.residual += update.residual_rms / setting.sigma;
      sum.nis += update.nis;
      ++sum.updates;
      if (update.status != UpdateStatus::ok) ++sum.not_ok;
    }
    sum.last += nees;
  }
  sum.nees /= static_cast<double>(sum.updates);
  sum.residual /= static_cast<double>(sum.updates);
  sum.nis /= static_cast<double>(sum.updates);
  sum.last /= seeds;
  return sum;
}

}  // namespace

TEST_CASE("consistency: against true walls the mean pose NEES over 100 seeds is that of six dimensions") {
  const Consistency c = consistency("state");
  CAPTURE(c.nees, c.last, c.residual, c.nis);
  REQUIRE(c.updates == 3200);
  CHECK(c.not_ok == 0);
  CHECK(c.nees > 5.3);
  CHECK(c.nees < 6.7);
  CHECK(c.residual == Approx(1.0).epsilon(0.01));  // the noise is what the filter takes it for
  CHECK(c.nis == Approx(1.0).epsilon(0.02));       // and so is what it predicts (eq. IESKF-10)
}

TEST_CASE("consistency: rigid and asymptotic promise more than they hold, linear less") {
  // The error of the velocity over the mean age of the points is in none of its rows; the linear rule gives
  // points up to two thirds less weight instead. The asymptotic rule moves the points as the linear one does, but
  // weighs them as the rigid one: its errors are smaller, what it claims is as much.
  const Consistency rigid = consistency("rigid"), linear = consistency("linear"),
                    asymptotic = consistency("asymptotic");
  CAPTURE(rigid.nees, rigid.last, linear.nees, linear.last, asymptotic.nees, asymptotic.last);
  CAPTURE(rigid.nis, linear.nis, asymptotic.nis);
  CHECK(rigid.not_ok + linear.not_ok + asymptotic.not_ok == 0);
  CHECK(rigid.nees > 6.7);
  CHECK(linear.nees < 5.3);
  CHECK(asymptotic.nees > 6.7);
  CHECK(asymptotic.nees < 0.8 * rigid.nees);
  for (const double nis : {rigid.nis, linear.nis, asymptotic.nis}) CHECK(nis == Approx(1.0).epsilon(0.02));
}

TEST_CASE("consistency: noise along the ray alone is less than one sigma for all incidences assumes") {
  const Consistency c = consistency("state", PointNoise::along_the_ray);
  CAPTURE(c.nees, c.residual);
  CHECK(c.not_ok == 0);
  CHECK(c.nees < 5.3);
  CHECK(c.residual < 0.85);
}
