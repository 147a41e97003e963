#include "aslio/plugin/registry.hpp"
#include "residuals/point_to_plane.hpp"

namespace aslio::plugins {

void register_residuals(plugin::Registry<Residual>& registry);

void register_residuals(plugin::Registry<Residual>& registry) {
  registry.add<PointToPlane>("point_to_plane", "Distance to the plane through the nearest neighbours (FAST-LIO2).");
}

}  // namespace aslio::plugins
