#include "aslio/plugin/registry.hpp"
#include "residuals/hybrid.hpp"
#include "residuals/point_to_line.hpp"
#include "residuals/point_to_plane.hpp"
#include "residuals/point_to_point.hpp"

namespace aslio::plugins {

void register_residuals(plugin::Registry<Residual>& registry);

void register_residuals(plugin::Registry<Residual>& registry) {
  registry.add<Hybrid>("hybrid", "Point to plane where neighbours are planar, point to point elsewhere (GenZ-ICP).");
  registry.add<PointToLine>("point_to_line", "Distance to the line through the nearest neighbours (LOAM).");
  registry.add<PointToPlane>("point_to_plane", "Distance to the plane through the nearest neighbours (FAST-LIO2).");
  registry.add<PointToPoint>("point_to_point", "Vector from the nearest neighbour, with a kernel (KISS-ICP).");
}

}  // namespace aslio::plugins
