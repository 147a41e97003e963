#include "aslio/plugin/registry.hpp"
#include "estimators/ct_icp.hpp"
#include "estimators/fixed_lag_smoother.hpp"
#include "estimators/icp.hpp"
#include "estimators/ieskf.hpp"
#include "estimators/pointwise_eskf.hpp"
#include "estimators/scan_matcher.hpp"
#include "estimators/smoother.hpp"
#include "estimators/spline_iekf.hpp"

namespace aslio::plugins {

void register_estimators(plugin::Registry<Estimator>& registry);

void register_estimators(plugin::Registry<Estimator>& registry) {
  registry.add<CtIcp>("ct_icp",
                      "Elastic registration of one window, begin and end pose unknown (CT-ICP); IMU on demand.");
  registry.add<FixedLagSmoother>("fixed_lag_smoother",
                                 "Poses of a registration and the IMU between them, smoothed together (LIO-SAM).");
  registry.add<Icp>("icp", "Gauss-Newton registration of one window under a constant velocity, no IMU (KISS-ICP).");
  registry.add<Ieskf>("ieskf",
                      "Iterated error-state Kalman filter over one window with IMU prediction (FAST-LIO2, AS-LIO).");
  registry.add<PointwiseEskf>("pointwise_eskf",
                              "Kalman filter with an update per firing, the IMU as a measurement (Point-LIO).");
  registry.add<ScanMatcher>("scan_matcher", "Lines and planes against the last sweep, then against the map (LOAM).");
  registry.add<Smoother>("smoother",
                         "Fixed-lag smoother over the slices of a window, every point matched again (FR-LIO).");
  registry.add<SplineIekf>("spline_iekf",
                           "Kalman filter of the last four control poses of a cubic B-spline (RESPLE); IMU on demand.");
}

}  // namespace aslio::plugins
