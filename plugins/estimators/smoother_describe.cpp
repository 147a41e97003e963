#include "estimators/smoother.hpp"

namespace aslio::plugins {

void Smoother::describe(config::Binder& b, Params& p) {
  describe_estimated(b, p.estimated);
  b.choice("noise", p.noise.kind,
           {{"fastlio", Noise::fastlio}, {"physical", Noise::physical}, {"rate_scaled", Noise::rate_scaled}},
           "IMU noise, as of ieskf");
  b.real("degenerate_acc_noise", p.noise.degenerate_acc_noise, "m/s^2/sqrt(Hz)", {.min = 0, .max = 10},
         "noise: physical, rate_scaled: minimum density of the accelerometer's noise after a degenerate or refused "
         "update (0: the sensor's own)");
  b.integer("max_iterations", p.max_iterations, "", {.min = 1, .max = 50},
            "iterations at most; each places and matches the points of all slices again");
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
