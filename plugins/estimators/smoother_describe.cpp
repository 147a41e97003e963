#include "estimators/smoother.hpp"

namespace aslio::plugins {

void Smoother::describe(config::Binder& b, Params& p) {
  b.choice("gravity", p.estimated.gravity, {{"s2", Gravity::s2}, {"free", Gravity::free}, {"fixed", Gravity::fixed}},
           "what of gravity is estimated: its direction, all three components, or nothing");
  b.real("sigma_gravity", p.estimated.sigma_gravity, "m/s^2", {.above = 0, .max = 10},
         "gravity: free alone: standard deviation of the length of g at the start");
  b.real("gravity_walk", p.estimated.gravity_walk, "deg/sqrt(s)", {.min = 0, .max = 10},
         "gravity: s2, free: random walk of the direction of gravity in the map, by which a map bends as it grows "
         "(0: none)");
  b.choice("gyro_calibration", p.estimated.gyro_calibration,
           {{"none", GyroCalibration::none}, {"diagonal", GyroCalibration::diagonal}, {"full", GyroCalibration::full}},
           "what of the gyro's sensitivity is estimated: nothing, its scale factors (prior 1 %), or cross-axis terms "
           "(0.5 %), too");
  b.flag("time_offset", p.estimated.time_offset, "estimate the delay of the IMU (prior 3 ms)");
  b.choice("noise", p.noise.kind,
           {{"fastlio", Noise::fastlio}, {"physical", Noise::physical}, {"rate_scaled", Noise::rate_scaled}},
           "IMU noise, as of ieskf");
  b.real("degenerate_acc_noise", p.noise.degenerate_acc_noise, "m/s^2/sqrt(Hz)", {.min = 0, .max = 10},
         "noise: physical, rate_scaled: least density of the accelerometer's noise after an update that was degenerate "
         "or refused (0: the sensor's own)");
  b.integer("max_iterations", p.max_iterations, "", {.min = 1, .max = 50},
            "iterations at most; at each, the points of all slices are placed and matched anew");
  b.real("sigma", p.sigma, "m", {.above = 0, .max = 1}, "standard deviation of one point-to-surface residual");
  b.real("converged_m", p.converged_m, "m", {.above = 0, .max = 1},
         "position step of every slice below which an iteration has converged");
  b.real("converged_deg", p.converged_deg, "deg", {.above = 0, .max = 10}, "the same for its attitude");
  b.integer("min_matches", p.min_matches, "", {.min = 1, .max = 1e6}, "fewer fresh matches: the step is refused");
  b.real("degenerate_sigma", p.degenerate_sigma, "m", {.above = 0, .max = 100},
         "an update is marked degenerate when 0.1 s of its view know their weakest direction worse than this "
         "(rotation at a 5 m lever arm)");
  b.stage("motion", p.motion, "pose and covariance between states");
  b.stage("residual", p.residual, "what a match measures");
}

}  // namespace aslio::plugins
