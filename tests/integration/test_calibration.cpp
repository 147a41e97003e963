// The calibration of the gyro and the delay of the IMU, found while moving.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "aslio/simulator/imu_params.hpp"
#include "integration/known_room.hpp"

using namespace aslio;
using namespace aslio::test;

namespace {

/// Swings of a hand-held sensor about all axes, by up to 2.5 rad/s, around the middle of the room.
class Swings final : public simulator::Motion {
 public:
  simulator::MotionState at(double t) const override {
    const Swing yaw = swing(t, 1.0, 0.37, 0.3), pitch = swing(t, 0.5, 0.53, 1.1), roll = swing(t, 0.5, 0.43, 2.0);
    const Swing x = swing(t, 0.8, 0.2, 0.0), y = swing(t, 0.6, 0.27, 1.0), z = swing(t, 0.3, 0.35, 2.0);
    simulator::MotionState out;
    out.R =
        exp_so3(yaw.value * Vec3::UnitZ()) * exp_so3(pitch.value * Vec3::UnitY()) * exp_so3(roll.value * Vec3::UnitX());
    const double sr = std::sin(roll.value), cr = std::cos(roll.value), cp = std::cos(pitch.value);
    out.w = Vec3(roll.rate - yaw.rate * std::sin(pitch.value), pitch.rate * cr + yaw.rate * sr * cp,
                 -pitch.rate * sr + yaw.rate * cr * cp);
    out.p = Vec3(x.value, y.value, z.value);
    out.v = Vec3(x.rate, y.rate, z.rate);
    out.a = Vec3(x.change, y.change, z.change);
    return out;
  }
  double duration() const override { return 20; }

 private:
  struct Swing {
    double value, rate, change;
  };
  static Swing swing(double t, double amplitude, double frequency, double phase) {
    const double f = 2 * std::numbers::pi * frequency;
    return {amplitude * std::sin(f * t + phase), amplitude * f * std::cos(f * t + phase),
            -amplitude * f * f * std::sin(f * t + phase)};
  }
};

/// The largest errors over ten sensors, each after 20 s.
struct Worst {
  double S = 0, S_sigmas = 0;  ///< of an entry of S_w; in its own standard deviations as the filter sees them
  double S_sigma = 0;          ///< the largest of those
  double delay = 0, delay_sigmas = 0, delay_sigma = 0;  ///< the same for the delay [s]
  double S_at_start = 0;
};

Worst calibrate(bool accelerometer_calibrated) {
  const Swings motion;
  KnownRoomSetting setting;
  simulator::ImuParams imu;
  imu.preset = simulator::ImuPreset::datasheet;
  setting.imu = simulator::imu_model(imu);
  setting.accelerometer_calibrated = accelerometer_calibrated;
  setting.overrides = {"estimator.deskew_correction=state", "estimator.gyro_calibration=full",
                       "estimator.time_offset=true"};
  Worst worst;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    KnownRoom room(motion, setting, seed);
    const Update* last = nullptr;
    while (!room.at_end()) last = &room.step();
    const NavState truth = room.truth(last->state.t);
    const Mat3 S = (last->state.S_w - truth.S_w).cwiseAbs();
    const Mat3 sigma = last->P.diagonal().segment<9>(block::s).cwiseSqrt().reshaped(3, 3);
    const double delay = std::abs(last->state.imu_delay - truth.imu_delay);
    const double delay_sigma = std::sqrt(last->P(block::d, block::d));
    worst.S = std::max(worst.S, S.maxCoeff());
    worst.S_sigmas = std::max(worst.S_sigmas, S.cwiseQuotient(sigma).maxCoeff());
    worst.S_sigma = std::max(worst.S_sigma, sigma.maxCoeff());
    worst.delay = std::max(worst.delay, delay);
    worst.delay_sigmas = std::max(worst.delay_sigmas, delay / delay_sigma);
    worst.delay_sigma = std::max(worst.delay_sigma, delay_sigma);
    worst.S_at_start = std::max(worst.S_at_start, truth.S_w.cwiseAbs().maxCoeff());
  }
  return worst;
}

}  // namespace

TEST_CASE("calibration: turns about all axes tell the gyro's sensitivity and the delay of the IMU, as well as P says") {
  const Worst worst = calibrate(true);
  CAPTURE(worst.S, worst.S_sigmas, worst.S_sigma, worst.delay, worst.delay_sigmas, worst.delay_sigma);
  REQUIRE(worst.S_at_start > 0.009);
  CHECK(worst.S_sigma < 2.5e-4);
  CHECK(worst.S_sigmas < 4);
  CHECK(worst.delay_sigma < 5e-5);
  CHECK(worst.delay_sigmas < 4);
}

TEST_CASE("calibration: errors of the accelerometer's own sensitivity, which no state has, cost some of it") {
  const Worst worst = calibrate(false);
  CAPTURE(worst.S, worst.S_sigmas, worst.delay, worst.delay_sigmas);
  CHECK(worst.S < 2.5e-3);      // of up to 0.01
  CHECK(worst.delay < 1.5e-4);  // of 2 ms
}
