#include "estimators/ct_icp.hpp"

namespace aslio::plugins {

void CtIcp::describe(config::Binder& b, Params& p) {
  using Noise = ImuNoisePreset::Kind;
  b.choice("prediction", p.prediction, {{"constant_velocity", Prediction::constant_velocity}, {"imu", Prediction::imu}},
           "where the first guess comes from: the motion goes on as before, and no IMU data is read; or the IMU. Then "
           "the estimated poses give its velocity and biases");
  b.integer("max_iterations", p.max_iterations, "", {.min = 1, .max = 100}, "searches for neighbours at most");
  b.integer("max_steps", p.max_steps, "", {.min = 1, .max = 100}, "Gauss-Newton steps per search at most");
  b.real("converged_m", p.converged_m, "m", {.above = 0, .max = 1},
         "motion of both ends over one search below which the iteration has converged");
  b.real("converged_deg", p.converged_deg, "deg", {.above = 0, .max = 10}, "the same for their turn");
  b.real("sigma", p.sigma, "m", {.above = 0, .max = 1}, "standard deviation of one residual");
  b.integer("min_matches", p.min_matches, "", {.min = 1, .max = 1e6}, "fewer fresh matches: the step is refused");
  b.real("degenerate_sigma", p.degenerate_sigma, "m", {.above = 0, .max = 100},
         "an update is marked degenerate when 0.1 s of its view know their weakest direction worse than this "
         "(rotation at a 5 m lever arm)");
  b.real("location", p.location, "", {.min = 0, .max = 1e6},
         "weight of the distance of the start from the end of the window before, in residuals of the mean point");
  b.real("orientation", p.orientation, "", {.min = 0, .max = 1e6},
         "the same for its attitude, a radian counting as a metre");
  b.real("displacement", p.displacement, "", {.min = 0, .max = 1e6},
         "weight of the displacement over the window against the predicted one");
  b.real("turn", p.turn, "", {.min = 0, .max = 1e6},
         "the same for the turn over the window, a radian counting as a metre");
  b.choice("noise", p.imu.noise.kind,
           {{"fastlio", Noise::fastlio}, {"physical", Noise::physical}, {"rate_scaled", Noise::rate_scaled}},
           "prediction: imu: IMU noise, as of ieskf");
  b.stage("motion", p.imu.motion, "prediction: imu: pose and covariance between updates");
  b.stage("residual", p.residual, "what a match measures");
}

}  // namespace aslio::plugins
