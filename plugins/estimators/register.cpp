#include "aslio/plugin/registry.hpp"
#include "estimators/ieskf.hpp"

namespace aslio::plugins {

void register_estimators(plugin::Registry<Estimator>& registry);

void register_estimators(plugin::Registry<Estimator>& registry) {
  registry.add<Ieskf>("ieskf",
                      "Iterated error-state Kalman filter over one window with IMU prediction (FAST-LIO2, AS-LIO).");
}

}  // namespace aslio::plugins
