#include "aslio/plugin/registry.hpp"
#include "aslio/stages/motion.hpp"

namespace aslio::plugins {

void register_motions(plugin::Registry<MotionModel>& registry);

void register_motions(plugin::Registry<MotionModel>& registry) { (void)registry; }

}  // namespace aslio::plugins
