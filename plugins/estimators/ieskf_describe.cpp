#include "estimators/ieskf.hpp"

namespace aslio::plugins {

namespace {

void describe_deskew(config::Binder& b, Ieskf::Params& p) {
  b.choice("deskew_correction", p.deskew_correction,
           {{"rigid", Ieskf::DeskewCorrection::rigid},
            {"linear", Ieskf::DeskewCorrection::linear},
            {"asymptotic", Ieskf::DeskewCorrection::asymptotic},
            {"state", Ieskf::DeskewCorrection::state}},
           "how the correction reaches the points inside a window. rigid: all of it. linear: in proportion to their "
           "time. asymptotic: the same in the points, not in the rows (AC-LIO). state: de-skewed again with rate, "
           "velocity and calibration of the iterate");
  b.choice("redeskew", p.redeskew,
           {{"every_iteration", Ieskf::Redeskew::every_iteration},
            {"once_registered", Ieskf::Redeskew::once_registered},
            {"until_converged", Ieskf::Redeskew::until_converged}},
           "deskew_correction: asymptotic: which steps reach the points in proportion to their time; the others move "
           "all alike. every_iteration: all. once_registered: those from an RMS residual of at most redeskew_below on. "
           "until_converged: those before the RMS residual stops to fall");
  b.require(
      p.redeskew == Ieskf::Redeskew::every_iteration || p.deskew_correction == Ieskf::DeskewCorrection::asymptotic,
      "redeskew",
      "needs deskew_correction: asymptotic (the other rules count on every step). Set that, or every_iteration here");
  b.real("redeskew_below", p.redeskew_below, "m", {.above = 0, .max = 10},
         "redeskew: once_registered: RMS residual from which on what is left of it counts as distortion");
  b.real("redeskew_fall", p.redeskew_fall, "", {.min = 0, .below = 1},
         "redeskew: until_converged: share by which the RMS residual has to fall from one iteration to the next");
}

void describe_iterations(config::Binder& b, Ieskf::Params& p) {
  b.choice(
      "association", p.association,
      {{"every_iteration", Ieskf::Association::every_iteration},
       {"on_convergence", Ieskf::Association::on_convergence},
       {"once", Ieskf::Association::once}},
      "when neighbours are searched: at every iteration; again when a step has converged, until two have (FAST-LIO2); "
      "or only at the predicted pose");
  b.flag("search_last", p.search_last,
         "association: on_convergence: where no step has converged before the last iteration, neighbours are searched "
         "again for it (FAST-LIO2)");
  b.flag("gate_again", p.gate_again,
         "a match that a gate has left out may take part again at the next iteration; false: not before neighbours are "
         "searched again (FAST-LIO2)");
  b.integer("max_iterations", p.max_iterations, "", {.min = 1, .max = 50}, "iterations at most");
  b.real("sigma", p.sigma, "m", {.above = 0, .max = 1}, "standard deviation of one point-to-surface residual");
  b.real("converged_m", p.converged_m, "m", {.above = 0, .max = 1},
         "position step below which an iteration has converged");
  b.real("converged_deg", p.converged_deg, "deg", {.above = 0, .max = 10},
         "attitude step below which an iteration has converged");
  b.choice("converged", p.converged, {{"pose", Ieskf::Converged::pose}, {"state", Ieskf::Converged::state}},
           "steps that must be that short: of the pose, or every component of the state (FAST-LIO2). Then velocity and "
           "biases count by the number of converged_m in their own units, the direction of gravity by converged_deg");
}

}  // namespace

void Ieskf::describe(config::Binder& b, Params& p) {
  describe_estimated(b, p.estimated);
  SensorStates::describe(b, p.sensors);
  b.choice("start_covariance", p.start_covariance,
           {{"measured", StartCovariance::measured}, {"fastlio", StartCovariance::fastlio}},
           "variances at the start: by what the initialisation measured, or FAST-LIO2's constants: 1 of pose and "
           "velocity, 1e-4, 1e-3 and 1e-5 of gyro bias, accelerometer bias and direction of gravity");
  describe_deskew(b, p);
  b.choice("noise", p.noise.kind,
           {{"fastlio", Noise::fastlio}, {"physical", Noise::physical}, {"rate_scaled", Noise::rate_scaled}},
           "IMU noise: FAST-LIO2's inflated per-sample variances, the sensor file's densities, or those plus terms for "
           "scale "
           "factor and delay that grow with the turn rate");
  b.real("degenerate_acc_noise", p.noise.degenerate_acc_noise, "m/s^2/sqrt(Hz)", {.min = 0, .max = 10},
         "noise: physical, rate_scaled: minimum density of the accelerometer's noise after a degenerate or refused "
         "update. Gravity turns an error of the map into acceleration, because the tilt takes the map as exact (0: the "
         "sensor's own)");
  describe_iterations(b, p);
  b.integer("min_matches", p.min_matches, "", {.min = 1, .max = 1e6}, "fewer fresh matches: the step is refused");
  b.real("shared_time", p.shared_time, "s", {.min = 0.0, .max = 10.0},
         "with an error that matches of a plane share (plane_sigma of the residual): time over which it stays the "
         "same. So shorter windows give no more information on a plane than one of this length");
  b.real("degenerate_sigma", p.degenerate_sigma, "m", {.above = 0, .max = 100},
         "an update is marked degenerate when 0.1 s of its view know their weakest direction worse than this "
         "(rotation at a 5 m lever arm)");
  DirectionalWeights::describe(b, p.directional);
  b.stage("motion", p.motion, "pose and covariance between updates");
  b.stage("residual", p.residual, "what a match measures");
  // Trials of 0.1.0 (docs/decisions.md, section "Tried and withdrawn").
  b.removed("dense_below", "remove it: every shipped study has it off");
  b.removed("innovation_gate", "use estimator.residual.kernel");
  b.removed("degenerate_to_prior", "remove it: map.doubt gives weak planes less weight");
  b.removed("carry", "use the estimator fixed_lag_smoother, which moves earlier points");
}

}  // namespace aslio::plugins
