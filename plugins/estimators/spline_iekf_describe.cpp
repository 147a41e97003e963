#include "estimators/spline_iekf.hpp"

namespace aslio::plugins {

void SplineIekf::describe(config::Binder& b, Params& p) {
  b.flag("imu", p.imu, "the IMU measures rate and specific force of the spline; false: LiDAR only");
  describe_gravity(b, p.gravity);
  b.real("interval", p.interval, "s", {.min = 1e-3, .max = 1}, "time between knots");
  b.real("acceleration_noise", p.noise.acceleration, "m/s^2", {.above = 0, .max = 1e4},
         "how far the motion departs from constant velocity over one interval: standard deviation");
  b.real("turn_noise", p.noise.turn, "rad/s^2", {.above = 0, .max = 1e4}, "the same from a constant turn rate");
  b.real("kept_noise", p.noise.kept, "", {.min = 0, .max = 1},
         "share of the variance of a new control pose that the three older ones get with it");
  b.real("gyro_bias_noise", p.noise.gyro_bias, "(rad/s)^2/s", {.min = 0}, "random walk of the gyro's bias");
  b.real("acc_bias_noise", p.noise.acc_bias, "(m/s^2)^2/s", {.min = 0}, "random walk of the accelerometer's bias");
  b.real("sigma", p.sigma, "m", {.above = 0, .max = 1}, "standard deviation of one point-to-surface residual");
  b.real("gyro_variance", p.gyro_variance, "(rad/s)^2", {.above = 0}, "of one reading of one axis");
  b.real("acc_variance", p.acc_variance, "(m/s^2)^2", {.above = 0}, "of one reading of one axis");
  b.integer("batch_points", p.batch_points, "", {.min = 1, .max = 1e6},
            "points per update at most; an update never reaches beyond a knot");
  b.integer("max_iterations", p.max_iterations, "", {.min = 1, .max = 100},
            "searches for neighbours and steps per update at most");
  b.real("converged", p.converged, "", {.above = 0, .max = 1},
         "largest component of a step of the control poses (rad and m alike) below which the iteration has converged");
  b.integer("min_matches", p.min_matches, "", {.min = 1, .max = 1e6},
            "fewer matches in a window: it is followed without its points");
  b.real("degenerate_sigma", p.degenerate_sigma, "m", {.above = 0, .max = 100},
         "a window is marked degenerate when 0.1 s of its view know the weakest direction worse than this "
         "(rotation at a 5 m lever arm)");
  b.stage("residual", p.residual, "what a match measures");
}

}  // namespace aslio::plugins
