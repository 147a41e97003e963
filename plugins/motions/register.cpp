#include "aslio/plugin/registry.hpp"
#include "motions/imu_euler.hpp"
#include "motions/imu_midpoint.hpp"

namespace aslio::plugins {

void register_motions(plugin::Registry<MotionModel>& registry);

void register_motions(plugin::Registry<MotionModel>& registry) {
  registry.add<ImuEuler>("imu_euler",
                         "First-order IMU integration with the attitude at the start of each step (FAST-LIO).");
  registry.add<ImuMidpoint>("imu_midpoint",
                            "Second-order IMU integration with the attitude in the middle of each step.");
}

}  // namespace aslio::plugins
