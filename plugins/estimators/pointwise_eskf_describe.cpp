#include "estimators/pointwise_eskf.hpp"

namespace aslio::plugins {

void PointwiseEskf::describe(config::Binder& b, Params& p) {
  describe_gravity(b, p.gravity);
  b.real("sigma", p.sigma, "m", {.above = 0, .max = 1}, "standard deviation of one point-to-surface residual");
  b.real("velocity_noise", p.noise.velocity, "(m/s^2)^2", {.min = 0},
         "variance of the velocity's random walk in a step of dt, per dt^2");
  b.real("rate_noise", p.noise.rate, "(rad/s^2)^2", {.above = 0}, "the same of the angular rate");
  b.real("force_noise", p.noise.force, "(m/s^3)^2", {.above = 0}, "the same of the specific force");
  b.real("gyro_bias_noise", p.noise.gyro_bias, "(rad/s^2)^2", {.min = 0}, "the same of the gyro's bias");
  b.real("acc_bias_noise", p.noise.acc_bias, "(m/s^3)^2", {.min = 0}, "the same of the accelerometer's bias");
  b.real("gyro_variance", p.gyro_variance, "(rad/s)^2", {.above = 0}, "of one reading of one axis");
  b.real("acc_variance", p.acc_variance, "(m/s^2)^2", {.above = 0}, "of one reading of one axis");
  b.real("gyro_saturation", p.gyro_saturation, "rad/s", {.min = 0},
         "limit of the gyro's range: an axis within 1 % of it is left out of the update (0: none)");
  b.real("acc_saturation", p.acc_saturation, "m/s^2", {.min = 0},
         "limit of the accelerometer's range: an axis within 1 % of it is left out of the update (0: none)");
  b.real("imu_step", p.imu_step, "s", {.min = 1e-4, .max = 10},
         "IMU samples at least twice as far apart get interpolated ones in between: the filter holds rate and force "
         "from one to the next");
  b.real("covariance_step", p.covariance_step, "s", {.min = 0, .max = 1},
         "the covariance is carried on with each IMU sample, and with a point once it is older than this (0: every "
         "point)");
  b.real("mean_leaf", p.mean_leaf, "m", {.min = 0, .max = 100},
         "points are the means of all that a cube of this edge holds, as measured, at their mean time (Point-LIO; 0: "
         "points as they are)");
  b.choice("first_map", p.first_map, {{"sampled", FirstMap::sampled}, {"all", FirstMap::all}},
           "points of the first window, over an empty map: as of any other, or all that the raw samplers leave "
           "(Point-LIO)");
  b.integer("min_matches", p.min_matches, "", {.min = 1, .max = 1e6},
            "fewer matches in a window: it is followed by the IMU alone");
  b.real("degenerate_sigma", p.degenerate_sigma, "m", {.above = 0, .max = 100},
         "a window is marked degenerate when 0.1 s of its view know the weakest direction worse than this "
         "(rotation at a 5 m lever arm)");
  b.stage("residual", p.residual, "what a match measures");
}

}  // namespace aslio::plugins
