#include "aslio/plugin/registry.hpp"
#include "windows/fixed.hpp"
#include "windows/imu_rate.hpp"
#include "windows/motion_rate.hpp"
#include "windows/overlapping.hpp"
#include "windows/replay.hpp"
#include "windows/sod_adaptive.hpp"

namespace aslio::plugins {

void register_windows(plugin::Registry<WindowStrategy>& registry);

void register_windows(plugin::Registry<WindowStrategy>& registry) {
  registry.add<FixedWindow>("fixed", "an update every period, or at the end of every sweep");
  registry.add<ImuRateWindow>("imu_rate",
                              "the stronger the motion within a frame, the more parts it is cut into (FR-LIO)");
  registry.add<MotionRateWindow>("motion_rate", "fast updates while the gyro measures a turn, slow ones else");
  registry.add<OverlappingWindow>("overlapping", "windows of one length at a shorter fixed step (SR-LIO)");
  registry.add<ReplayWindow>("replay", "updates at the times a file says, such as the updates.csv of another run");
  registry.add<SodAdaptiveWindow>("sod_adaptive", "updates that come faster as the spatial overlap falls (AS-LIO)");
}

}  // namespace aslio::plugins
